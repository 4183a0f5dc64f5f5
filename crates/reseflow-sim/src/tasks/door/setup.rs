//! Everything random about a door scene, drawn from the episode's key.

use nalgebra::Vector3;
use rand::{Rng, RngExt};
use reseflow_data::{EpisodeKey, Split, TaskError};
use reseflow_lie::{SE3, SO3};

use super::{NAME, expert};
use crate::camera::Camera;
use crate::tasks::draws;
use crate::world::{TABLE_HALF_M, gripper};

/// Width, height and depth of a cabinet of nominal size, metres.
const NOMINAL_SIZE_M: [f64; 3] = [0.22, 0.20, 0.14];
/// The middle of the cabinets' places on the table, metres: towards the back, so that the doors have room.
const NOMINAL_PLACE_M: [f64; 2] = [-0.15, 0.0];
/// Handle heights over the door's height.
const HANDLE_HEIGHT_SHARE: [f64; 2] = [0.38, 0.62];
/// The middle of the gripper's start poses, metres.
const HOME_M: [f64; 3] = [0.30, 0.0, 0.18];
/// How far before the cabinet's front every part of the gripper starts, metres.
const START_CLEARANCE_M: f64 = 0.08;
/// How far over the table every part of the gripper starts, metres.
const TABLE_CLEARANCE_M: f64 = 0.01;
/// Commands of the expert keep within this of the table's middle on both axes, metres.
const EXPERT_REACH_M: f64 = 0.48;
/// Draws before a setup is given up.
const MAX_DRAWS: usize = 1000;

/// Where a door's hinge is, seen from before the cabinet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HingeSide {
    /// Opens clockwise seen from above.
    Left,
    /// Opens counter-clockwise seen from above.
    Right,
}

impl HingeSide {
    /// The side along the cabinet's y axis, which also is the sense of opening about z: +1 right, −1 left.
    pub(super) fn sign(self) -> f64 {
        match self {
            HingeSide::Left => -1.0,
            HingeSide::Right => 1.0,
        }
    }
}

/// One door scene at its start. The cabinet's frame: origin in the middle of its base, x out of its front, z up.
#[derive(Debug, Clone, PartialEq)]
pub struct DoorSetup {
    /// Where the hinge is.
    pub hinge: HingeSide,
    /// The cabinet's width, height and depth, metres.
    pub size_m: [f64; 3],
    /// The height of the middle of the handle bar over the table, metres.
    pub handle_height_m: f64,
    /// The middle of the cabinet on the table, metres.
    pub center_m: [f64; 2],
    /// The direction out of the front, rad from the world's x axis.
    pub yaw_rad: f64,
    /// Where the gripper starts.
    pub world_from_gripper: SE3,
    /// The cabinet's colour, not salient.
    pub cabinet_color: [u8; 3],
    /// The door's, not salient.
    pub door_color: [u8; 3],
    /// The handle's, salient.
    pub handle_color: [u8; 3],
    /// The strip's along the hinge, dark.
    pub hinge_color: [u8; 3],
    /// The table's, not salient.
    pub table_color: [u8; 3],
    /// The camera.
    pub camera: Camera,
}

impl DoorSetup {
    /// The setup that `key` names.
    ///
    /// In train, validation and test: hinge left or right, centre within ± 0.15 m of (−0.15, 0) m, yaw ± 45°, size ± 15 %,
    /// gripper start σ = 4 cm and 0.15 rad. In `wide`: centre outside that square and within ± 0.22 m, yaw 45° to 60° to
    /// either side, size 15–25 % off, gripper start σ = 6 cm and 0.25 rad, camera 0.25–0.7 rad to either side. Drawn again
    /// until the cabinet stands on the table, the gripper starts before it, and the opened handle is in reach.
    ///
    /// # Errors
    /// When no setup is found.
    pub fn draw(key: &EpisodeKey) -> Result<DoorSetup, TaskError> {
        let rng = &mut key.rng("scene");
        let wide = key.split == Split::Wide;
        (0..MAX_DRAWS).map(|_| Self::draw_any(wide, rng)).find(Self::is_possible).ok_or_else(|| TaskError {
            task: NAME.to_owned(),
            index: key.index,
            reason: format!("expected a cabinet in reach, found none in {MAX_DRAWS} draws"),
        })
    }

    fn draw_any<R: Rng>(wide: bool, rng: &mut R) -> DoorSetup {
        let hinge = if rng.random::<bool>() { HingeSide::Left } else { HingeSide::Right };
        let offset = draws::center_offset(wide, rng);
        let yaw_deg: f64 = if wide {
            let magnitude: f64 = rng.random_range(45.0..=60.0);
            if rng.random::<bool>() { magnitude } else { -magnitude }
        } else {
            rng.random_range(-45.0..=45.0)
        };
        let factor = draws::size_factor(wide, rng);
        let size_m = NOMINAL_SIZE_M.map(|size| size * factor);
        DoorSetup {
            hinge,
            size_m,
            handle_height_m: size_m[1] * rng.random_range(HANDLE_HEIGHT_SHARE[0]..=HANDLE_HEIGHT_SHARE[1]),
            center_m: [NOMINAL_PLACE_M[0] + offset[0], NOMINAL_PLACE_M[1] + offset[1]],
            yaw_rad: yaw_deg.to_radians(),
            world_from_gripper: draws::gripper_start(&home(), wide, rng),
            cabinet_color: draws::object_color(rng),
            door_color: draws::object_color(rng),
            handle_color: draws::salient_color(rng),
            hinge_color: draws::color([0.0, 0.3], [0.08, 0.2], rng),
            table_color: draws::table_color(rng),
            camera: draws::camera(wide, rng),
        }
    }

    /// Whether the cabinet stands on the table, the gripper starts before it, and the expert's commands are in reach.
    fn is_possible(&self) -> bool {
        let world_from_cabinet = self.world_from_cabinet();
        let [width, _, depth] = self.size_m;
        let on_the_table = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)].into_iter().all(|(x, y)| {
            let corner = world_from_cabinet.act(&Vector3::new(0.5 * x * depth, 0.5 * y * width, 0.0));
            corner.x.abs().max(corner.y.abs()) <= TABLE_HALF_M
        });
        let starts_before_it = gripper::corners().all(|corner| {
            let corner = self.world_from_gripper.act(&corner);
            let before = world_from_cabinet.inverse().act(&corner).x;
            corner.z >= TABLE_CLEARANCE_M && before >= 0.5 * depth + START_CLEARANCE_M
        });
        let in_reach = expert::commands(self).iter().all(|action| {
            let at = action.world_from_gripper.translation;
            at.x.abs().max(at.y.abs()) <= EXPERT_REACH_M
        });
        on_the_table && starts_before_it && in_reach
    }

    /// Where the cabinet stands.
    pub(super) fn world_from_cabinet(&self) -> SE3 {
        let [x, y] = self.center_m;
        SE3::new(SO3::exp(&(Vector3::z() * self.yaw_rad)), Vector3::new(x, y, 0.0))
    }
}

/// The middle of the start poses: facing the back of the table, closing along the world's y axis.
fn home() -> SE3 {
    SE3::new(gripper::orientation(&-Vector3::x(), &Vector3::y()), Vector3::from(HOME_M))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn setups(split: Split) -> Vec<DoorSetup> {
        let key = |index| EpisodeKey { task: NAME.to_owned(), split, seed: 1, index, attempt: 0 };
        (0..300).map(|index| DoorSetup::draw(&key(index)).unwrap()).collect()
    }

    #[test]
    fn draws_stay_in_their_distributions() {
        for setup in setups(Split::Train) {
            assert!((setup.center_m[0] + 0.15).abs() <= 0.15 && setup.center_m[1].abs() <= 0.15);
            assert!((setup.size_m[0] / NOMINAL_SIZE_M[0] - 1.0).abs() <= 0.15 + 1e-12);
            assert!(setup.yaw_rad.abs() <= 45.0_f64.to_radians());
        }
        for setup in setups(Split::Wide) {
            assert!((setup.center_m[0] + 0.15).abs().max(setup.center_m[1].abs()) > 0.15);
            assert!((setup.size_m[0] / NOMINAL_SIZE_M[0] - 1.0).abs() >= 0.15 - 1e-12);
            assert!(setup.yaw_rad.abs() >= 45.0_f64.to_radians());
        }
    }

    #[test]
    fn both_hinges_and_all_yaws_are_drawn() {
        let setups = setups(Split::Train);
        let left = setups.iter().filter(|setup| setup.hinge == HingeSide::Left).count();
        // 300 fair coins: within 4.6 standard deviations.
        assert!((110..=190).contains(&left), "{left}");
        let mut yaws: Vec<f64> = setups.iter().map(|setup| setup.yaw_rad).collect();
        yaws.sort_by(f64::total_cmp);
        assert!(yaws[15] < -0.6 && yaws[284] > 0.6, "{} to {}", yaws[15], yaws[284]);
    }
}
