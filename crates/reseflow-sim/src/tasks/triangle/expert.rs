//! The triangle's expert: over it, down, close, turn, hold.

use nalgebra::Vector3;
use reseflow_data::Action;
use reseflow_lie::{SE3, SO3};

use super::scene::HEIGHT_M;
use super::setup::{TriangleSetup, pointing_down};
use crate::tabletop::ACTION_STEPS;

/// How far above the grasp the gripper stops first, metres.
const HOVER_M: f64 = 0.08;
/// Action steps over which the turn is spread.
const TURN_STEPS: usize = 6;

/// The T commands that turn by `turn_rad`, counter-clockwise seen from above.
///
/// Every command is a smooth function of the setup, but for the choice of the half-turn.
pub(super) fn commands(setup: &TriangleSetup, turn_rad: f64) -> Vec<Action> {
    let radius = setup.circumradius_m();
    let corner = Vector3::new(setup.yaw_rad.cos(), setup.yaw_rad.sin(), 0.0);
    let center = Vector3::new(setup.center_m[0], setup.center_m[1], 0.5 * HEIGHT_M);
    // The middle between the corner (at +r) and the opposite face (at −r/2).
    let grasp = SE3::new(pointing_down(setup.grasp_yaw_rad()), center + corner * (0.25 * radius));
    let hover = SE3::new(grasp.rotation, grasp.translation + Vector3::z() * HOVER_M);
    let to_center = SE3::new(SO3::identity(), center);

    let mut actions = vec![
        Action { world_from_gripper: hover, opening: 1.0 },
        Action { world_from_gripper: grasp, opening: 1.0 },
        Action { world_from_gripper: grasp, opening: 0.0 },
    ];
    for step in 1..=TURN_STEPS {
        let angle = turn_rad * step as f64 / TURN_STEPS as f64;
        let turn = SE3::new(SO3::exp(&(Vector3::z() * angle)), Vector3::zeros());
        let world_from_gripper = to_center * turn * to_center.inverse() * grasp;
        actions.push(Action { world_from_gripper, opening: 0.0 });
    }
    let last = actions[actions.len() - 1];
    actions.resize(ACTION_STEPS, last);
    actions
}
