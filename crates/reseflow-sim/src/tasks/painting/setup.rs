//! Everything random about a painting scene, drawn from the episode's key.

use std::f64::consts::FRAC_PI_2;

use nalgebra::Vector3;
use rand::{Rng, RngExt};
use reseflow_data::{EpisodeKey, Split, TaskError};
use reseflow_lie::{SE3, SO3};

use super::stroke::Stroke;
use super::{NAME, board, expert, library};
use crate::camera::Camera;
use crate::color::rgb_from_hsv;
use crate::tasks::draws;
use crate::world::TABLE_HALF_M;
use crate::world::brush::TIP_Z_M;
use crate::world::gripper;

/// The middle of the gripper's start poses, metres: above and behind the board, out of the camera's view of it.
const HOME_M: [f64; 3] = [-0.20, 0.0, 0.47];
/// Tilts are at most this, degrees.
const MAX_TILT_DEG: f64 = 45.0;
/// The stroke is printed upright on the board to within this, radians.
const PRINT_TURN_RAD: f64 = 0.25;
/// The brush's tip starts at least this far above the board, metres.
const START_CLEARANCE_M: f64 = 0.05;
/// Nearest start, in yaw about the board's normal, to where both half-turns of the gripper are equally near.
const BOUNDARY_MARGIN_RAD: f64 = 10.0 * std::f64::consts::PI / 180.0;
/// Commands of the expert keep within this of the table's middle on both axes, metres.
const EXPERT_REACH_M: f64 = 0.48;
/// The camera is raised by this against those of the other tasks, metres, and sees more around: a board is tall.
const CAMERA_RAISE_M: f64 = 0.08;
const CAMERA_FOCAL_FACTOR: f64 = 0.92;
/// How far inside the image the whole stroke lies, pixels.
const IMAGE_MARGIN_PX: f64 = 6.0;
/// Draws before a setup is given up.
const MAX_DRAWS: usize = 1000;

/// Hues of the printed stroke, of its beginning and of wet paint, turns: blue, green, red.
const STROKE_HUE: [f64; 2] = [0.58, 0.68];
const BEGINNING_HUE: [f64; 2] = [0.27, 0.38];
const PAINT_HUE: [f64; 2] = [0.95, 1.02];

/// One painting scene at its start.
#[derive(Debug, Clone, PartialEq)]
pub struct PaintingSetup {
    /// The stroke as it is printed, in the board's frame.
    pub stroke: Stroke,
    /// Half of the square board's edge, metres.
    pub board_half_m: f64,
    /// The middle of the board over the table, metres.
    pub center_m: [f64; 2],
    /// The direction to which the board looks, rad from the world's x axis.
    pub yaw_rad: f64,
    /// The angle between the board and the table, radians.
    pub tilt_rad: f64,
    /// Where the gripper starts.
    pub world_from_gripper: SE3,
    /// The board's colour: nearly white.
    pub board_color: [u8; 3],
    /// The stand's, not salient.
    pub stand_color: [u8; 3],
    /// The printed stroke's, salient.
    pub stroke_color: [u8; 3],
    /// That of the disc where the stroke begins, salient.
    pub beginning_color: [u8; 3],
    /// The wet paint's, salient.
    pub paint_color: [u8; 3],
    /// The table's, not salient.
    pub table_color: [u8; 3],
    /// The camera.
    pub camera: Camera,
}

impl PaintingSetup {
    /// The setup that `key` names.
    ///
    /// In train, validation and test: any stroke of the library from either end, the board's middle within ± 0.15 m, yaw ± 45°,
    /// tilt up to 45°, size ± 15 %, gripper start σ = 4 cm and 0.15 rad. In `wide`: middle outside that square and within
    /// ± 0.22 m, yaw 45° to 60° to either side, size 15–25 % off, gripper start σ = 6 cm and 0.25 rad, camera
    /// 0.25–0.7 rad to either side. Drawn again until the board stands on the table with its stroke in reach and in view, and
    /// the gripper starts over it, not within 10° of a decision boundary between its half-turns.
    ///
    /// # Errors
    /// When the stroke library is broken, or no setup is found.
    pub fn draw(key: &EpisodeKey) -> Result<PaintingSetup, TaskError> {
        let fault = |reason: String| TaskError { task: NAME.to_owned(), index: key.index, reason };
        let strokes = library::strokes().map_err(|error| fault(error.to_string()))?;
        let rng = &mut key.rng("scene");
        let wide = key.split == Split::Wide;
        (0..MAX_DRAWS).map(|_| Self::draw_any(strokes, wide, rng)).find(Self::is_possible).ok_or_else(|| {
            fault(format!("expected a board in reach and in view, found none in {MAX_DRAWS} draws"))
        })
    }

    fn draw_any<R: Rng>(strokes: &[Stroke], wide: bool, rng: &mut R) -> PaintingSetup {
        let center_m = draws::center_offset(wide, rng);
        let yaw_deg: f64 = if wide {
            let magnitude: f64 = rng.random_range(45.0..=60.0);
            if rng.random::<bool>() { magnitude } else { -magnitude }
        } else {
            rng.random_range(-45.0..=45.0)
        };
        let size_factor = draws::size_factor(wide, rng);
        let printed = strokes[rng.random_range(0..strokes.len())]
            .scaled_and_turned(size_factor, rng.random_range(-PRINT_TURN_RAD..=PRINT_TURN_RAD));
        let mut camera = draws::camera(wide, rng);
        camera.world_from_camera.translation.z += CAMERA_RAISE_M;
        camera.focal_px *= CAMERA_FOCAL_FACTOR;
        PaintingSetup {
            stroke: if rng.random::<bool>() { printed.reversed() } else { printed },
            board_half_m: board::NOMINAL_HALF_M * size_factor,
            center_m,
            yaw_rad: yaw_deg.to_radians(),
            tilt_rad: rng.random_range(0.0..=MAX_TILT_DEG).to_radians(),
            world_from_gripper: draws::gripper_start(&home(), wide, rng),
            board_color: draws::color([0.02, 0.12], [0.75, 0.95], rng),
            stand_color: draws::object_color(rng),
            stroke_color: print_color(STROKE_HUE, rng),
            beginning_color: print_color(BEGINNING_HUE, rng),
            paint_color: print_color(PAINT_HUE, rng),
            table_color: draws::table_color(rng),
            camera,
        }
    }

    /// Whether the scene is one that the task is about.
    fn is_possible(&self) -> bool {
        let world_from_board = self.world_from_board();
        let on_table = board::stand_corners(&world_from_board, self.board_half_m).iter().all(|corner| {
            let at = world_from_board.act(corner);
            at.x.abs().max(at.y.abs()) <= TABLE_HALF_M
        });
        let tip = self.world_from_gripper.act(&(Vector3::z() * TIP_Z_M));
        let over_board = world_from_board.inverse().act(&tip).z >= START_CLEARANCE_M;
        let off_boundary = (expert::turn_to_stroke_rad(self).abs() - FRAC_PI_2).abs() >= BOUNDARY_MARGIN_RAD;
        let in_reach = expert::commands(self).iter().all(|command| {
            let at = command.world_from_gripper.translation;
            at.x.abs().max(at.y.abs()) <= EXPERT_REACH_M
        });
        on_table && over_board && off_boundary && in_reach && self.is_in_view(&world_from_board)
    }

    /// Whether the camera's image holds the whole stroke.
    fn is_in_view(&self, world_from_board: &SE3) -> bool {
        let camera_from_board = self.camera.world_from_camera.inverse() * *world_from_board;
        self.stroke.points_m(20).iter().all(|&[x, y]| {
            let at = camera_from_board.act(&Vector3::new(x, y, 0.0));
            (0..2).all(|axis| {
                let pixel = self.camera.center_px[axis] + self.camera.focal_px * at[axis] / at.z;
                (IMAGE_MARGIN_PX..=self.camera.size_px[axis] as f64 - IMAGE_MARGIN_PX).contains(&pixel)
            })
        })
    }

    /// Where the board is at the start; its frame has its origin in the middle of the face, z out of it.
    pub fn world_from_board(&self) -> SE3 {
        board::world_from_board(self.center_m, self.yaw_rad, self.tilt_rad, self.board_half_m)
    }
}

/// The middle of the start poses: pointing down, closing along the world's y axis.
fn home() -> SE3 {
    let rotation: SO3 = gripper::orientation(&-Vector3::z(), &Vector3::y());
    SE3::new(rotation, Vector3::from(HOME_M))
}

/// A colour that stands out, its hue within a range.
fn print_color<R: Rng>(hue: [f64; 2], rng: &mut R) -> [u8; 3] {
    rgb_from_hsv(
        rng.random_range(hue[0]..=hue[1]),
        rng.random_range(0.85..=1.0),
        rng.random_range(0.75..=1.0),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn setup(split: Split, index: u64) -> PaintingSetup {
        PaintingSetup::draw(&EpisodeKey { task: NAME.to_owned(), split, seed: 1, index, attempt: 0 }).unwrap()
    }

    #[test]
    fn draws_stay_in_their_distributions() {
        let mut names = std::collections::BTreeSet::new();
        for index in 0..300 {
            let train = setup(Split::Train, index);
            assert!(train.center_m.iter().all(|c| c.abs() <= 0.15));
            assert!((train.board_half_m / board::NOMINAL_HALF_M - 1.0).abs() <= 0.15 + 1e-12);
            assert!(train.yaw_rad.abs().to_degrees() <= 45.0);
            assert!((0.0..=45.0).contains(&train.tilt_rad.to_degrees()));
            assert!(train.stroke.length_m() <= library::MAX_LENGTH_M);
            names.insert(train.stroke.name().to_owned());
            let wide = setup(Split::Wide, index);
            assert!(wide.center_m.iter().any(|c| c.abs() > 0.15));
            assert!(wide.yaw_rad.abs().to_degrees() >= 45.0);
            assert!((wide.board_half_m / board::NOMINAL_HALF_M - 1.0).abs() >= 0.15 - 1e-12);
            assert!(wide.stroke.length_m() <= library::MAX_LENGTH_M);
        }
        assert_eq!(names.len(), library::strokes().unwrap().len(), "every stroke is drawn");
    }

    #[test]
    fn the_expert_turns_by_less_than_a_quarter_to_the_beginning() {
        for index in 0..100 {
            let setup = setup(Split::Test, index);
            let first = expert::commands(&setup)[0].world_from_gripper;
            let turned = |pose: &SE3| {
                let close =
                    setup.world_from_board().rotation.inverse().act(&pose.rotation.act(&Vector3::y()));
                close.y.atan2(close.x)
            };
            let turn = super::super::stroke::wrapped(turned(&first) - turned(&setup.world_from_gripper));
            assert!(turn.abs() <= FRAC_PI_2 - BOUNDARY_MARGIN_RAD + 1e-9, "{turn}");
        }
    }
}
