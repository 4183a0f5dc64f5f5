//! The door's expert: before the handle, around it, close, swing along the arc.

use nalgebra::Vector3;
use reseflow_data::Action;
use reseflow_lie::SE3;

use super::cabinet::{cabinet_from_door, handle_in_door};
use super::setup::DoorSetup;
use crate::tabletop::ACTION_STEPS;
use crate::world::gripper;

/// How far before the handle the gripper stops first, metres.
const APPROACH_M: f64 = 0.07;
/// How far the expert opens the door.
const OPEN_RAD: f64 = 70.0 * std::f64::consts::PI / 180.0;
/// Action steps before the swing.
const STEPS_TO_GRASP: usize = 3;

/// The expert's T commands, smooth functions of the setup for each side of the hinge.
pub(super) fn commands(setup: &DoorSetup) -> Vec<Action> {
    let grasp = |angle_rad: f64| {
        let world_from_door = setup.world_from_cabinet() * cabinet_from_door(setup, angle_rad);
        // Into the door, closing along its face, the pads along the bar.
        let facing = gripper::orientation(&-Vector3::x(), &Vector3::y());
        world_from_door * SE3::new(facing, handle_in_door(setup))
    };
    let closed = grasp(0.0);
    let back = SE3::new(closed.rotation, closed.act(&(Vector3::z() * -APPROACH_M)));
    let mut actions = vec![
        Action { world_from_gripper: back, opening: 1.0 },
        Action { world_from_gripper: closed, opening: 1.0 },
        Action { world_from_gripper: closed, opening: 0.0 },
    ];
    let swing_steps = ACTION_STEPS - STEPS_TO_GRASP;
    for step in 1..=swing_steps {
        let angle_rad = OPEN_RAD * step as f64 / swing_steps as f64;
        actions.push(Action { world_from_gripper: grasp(angle_rad), opening: 0.0 });
    }
    actions
}
