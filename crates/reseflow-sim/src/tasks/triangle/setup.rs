//! Everything random about a triangle scene, drawn from the episode's key.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::Vector3;
use rand::RngExt;
use reseflow_data::{EpisodeKey, Split};
use reseflow_lie::{SE3, SO3};

use super::scene::{DENSITY_KG_M3, HEIGHT_M};
use crate::camera::Camera;
use crate::tasks::draws;
use crate::world::gripper;

/// The side of a triangle of nominal size, metres.
const NOMINAL_SIDE_M: f64 = 0.075;
/// Nearest start, in yaw, to where both half-turns of the gripper are equally near.
const BOUNDARY_MARGIN_RAD: f64 = 10.0 * PI / 180.0;
/// The middle of the gripper's start poses, metres above the table's middle.
const HOME_HEIGHT_M: f64 = 0.25;

/// One triangle scene at its start.
#[derive(Debug, Clone, PartialEq)]
pub struct TriangleSetup {
    /// The prism's edge length, metres.
    pub side_m: f64,
    /// The centre on the table, metres.
    pub center_m: [f64; 2],
    /// The direction from the centre to the coloured corner, rad from the world's x axis.
    pub yaw_rad: f64,
    /// Where the gripper starts.
    pub world_from_gripper: SE3,
    /// The prism's colour, not salient.
    pub body_color: [u8; 3],
    /// The coloured corner's, salient.
    pub corner_color: [u8; 3],
    /// The table's, not salient.
    pub table_color: [u8; 3],
    /// The camera.
    pub camera: Camera,
}

impl TriangleSetup {
    /// The setup that `key` names.
    ///
    /// In train, validation and test: centre within ± 0.15 m, any yaw, size ± 15 %, gripper start σ = 4 cm and
    /// 0.15 rad. In `wide`: centre outside that square and within ± 0.22 m, size 15–25 % off, gripper start σ = 6 cm
    /// and 0.25 rad, camera 0.25–0.7 rad to either side. No start is within 10° of a decision boundary.
    pub fn draw(key: &EpisodeKey) -> TriangleSetup {
        let rng = &mut key.rng("scene");
        let wide = key.split == Split::Wide;
        let center_m = draws::center_offset(wide, rng);
        let size_factor = draws::size_factor(wide, rng);
        let world_from_gripper = draws::gripper_start(&home(), wide, rng);
        let yaw_rad = loop {
            let yaw: f64 = rng.random_range(-PI..PI);
            if distance_to_boundary(gripper_yaw(&world_from_gripper), yaw) >= BOUNDARY_MARGIN_RAD {
                break yaw;
            }
        };
        TriangleSetup {
            side_m: NOMINAL_SIDE_M * size_factor,
            center_m,
            yaw_rad,
            world_from_gripper,
            body_color: draws::object_color(rng),
            corner_color: draws::salient_color(rng),
            table_color: draws::table_color(rng),
            camera: draws::camera(wide, rng),
        }
    }

    /// The prism's mass, kilograms.
    pub(super) fn mass_kg(&self) -> f64 {
        DENSITY_KG_M3 * HEIGHT_M * 0.25 * 3.0_f64.sqrt() * self.side_m * self.side_m
    }

    /// From the centre to a corner, metres.
    pub(super) fn circumradius_m(&self) -> f64 {
        self.side_m / 3.0_f64.sqrt()
    }
}

/// The yaw of the grasp: closing along the median with direction `median_rad`, the half-turn nearest to the gripper's.
pub(super) fn grasp_yaw_rad(world_from_gripper: &SE3, median_rad: f64) -> f64 {
    let start = gripper_yaw(world_from_gripper);
    start + half_turn_difference(start, median_rad)
}

/// The gripper pointing straight down with its closing direction at `yaw_rad` from the world's x axis.
pub(super) fn pointing_down(yaw_rad: f64) -> SO3 {
    let (sin, cos) = yaw_rad.sin_cos();
    gripper::orientation(&-Vector3::z(), &Vector3::new(cos, sin, 0.0))
}

/// The middle of the start poses: over the table's middle, pointing down, closing along the world's y axis.
fn home() -> SE3 {
    SE3::new(pointing_down(FRAC_PI_2), Vector3::new(0.0, 0.0, HOME_HEIGHT_M))
}

/// The direction, seen from above, in which a gripper closes, rad from the world's x axis.
fn gripper_yaw(world_from_gripper: &SE3) -> f64 {
    let close = world_from_gripper.rotation.act(&Vector3::y());
    close.y.atan2(close.x)
}

/// The turn in \[−π/2, π/2\] from the direction `start` to the line with direction `line`.
fn half_turn_difference(start: f64, line: f64) -> f64 {
    (line - start + FRAC_PI_2).rem_euclid(PI) - FRAC_PI_2
}

/// How far a start is from where both half-turns are equally near, rad.
fn distance_to_boundary(start: f64, line: f64) -> f64 {
    FRAC_PI_2 - half_turn_difference(start, line).abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(split: Split, index: u64) -> EpisodeKey {
        EpisodeKey { task: "triangle".to_owned(), split, seed: 1, index, attempt: 0 }
    }

    #[test]
    fn draws_stay_in_their_distributions() {
        for index in 0..300 {
            let setup = TriangleSetup::draw(&key(Split::Train, index));
            assert!(setup.center_m.iter().all(|c| c.abs() <= 0.15));
            assert!((setup.side_m / NOMINAL_SIDE_M - 1.0).abs() <= 0.15 + 1e-12);
            let start = gripper_yaw(&setup.world_from_gripper);
            assert!(distance_to_boundary(start, setup.yaw_rad) >= BOUNDARY_MARGIN_RAD);
            let turn = (grasp_yaw_rad(&setup.world_from_gripper, setup.yaw_rad) - start).abs();
            assert!(turn <= FRAC_PI_2 - BOUNDARY_MARGIN_RAD + 1e-12);
            let wide = TriangleSetup::draw(&key(Split::Wide, index));
            assert!(wide.center_m.iter().any(|c| c.abs() > 0.15));
            assert!((wide.side_m / NOMINAL_SIDE_M - 1.0).abs() >= 0.15 - 1e-12);
        }
    }

    #[test]
    fn the_grasp_lies_on_the_median_through_the_corner() {
        for index in 0..100 {
            let setup = TriangleSetup::draw(&key(Split::Test, index));
            let off = (grasp_yaw_rad(&setup.world_from_gripper, setup.yaw_rad) - setup.yaw_rad).sin();
            assert!(off.abs() < 1e-12);
        }
    }
}
