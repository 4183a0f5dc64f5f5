//! The door's expert: before the handle, around it, close, swing along the arc.

use nalgebra::Vector3;
use reseflow_data::Action;
use reseflow_lie::SE3;

use super::cabinet::{cabinet_from_door, handle_in_door};
use super::setup::DoorSetup;
use crate::expert::{Script, Tolerance};
use crate::world::gripper;

/// How far before the handle the gripper stops first, metres.
const APPROACH_M: f64 = 0.07;
/// How far the expert opens the door.
const OPEN_RAD: f64 = 70.0 * std::f64::consts::PI / 180.0;
/// Action steps before the swing.
const STEPS_TO_GRASP: usize = 3;

/// The door is on its course within this; fingers around the handle bar are open by 0.14.
pub(super) const TOLERANCE: Tolerance = Tolerance { off_m: 0.01, off_rad: 0.12, held_opening: 0.1 };

/// The script that opens a door which is open by `angle_rad`, a smooth function of the setup for each side of the hinge.
///
/// `None` with fewer than four action steps.
pub(super) fn script(setup: &DoorSetup, angle_rad: f64, steps: usize) -> Option<Script> {
    let swing_steps = steps.checked_sub(STEPS_TO_GRASP).filter(|&left| left > 0)?;
    let door = |angle_rad: f64| setup.world_from_cabinet() * cabinet_from_door(setup, angle_rad);
    // Into the door, closing along its face, the pads along the bar.
    let facing = gripper::orientation(&-Vector3::x(), &Vector3::y());
    let grasp = |angle_rad: f64| door(angle_rad) * SE3::new(facing, handle_in_door(setup));
    let now = grasp(angle_rad);
    let back = SE3::new(now.rotation, now.act(&(Vector3::z() * -APPROACH_M)));
    let command = |world_from_gripper, opening| Action { world_from_gripper, opening };
    let mut actions = vec![command(back, 1.0), command(now, 1.0), command(now, 0.0)];
    let mut objects = vec![door(angle_rad); STEPS_TO_GRASP + 1];
    for step in 1..=swing_steps {
        let share = step as f64 / swing_steps as f64;
        let angle_rad = angle_rad + (OPEN_RAD - angle_rad) * share;
        actions.push(command(grasp(angle_rad), 0.0));
        objects.push(door(angle_rad));
    }
    Some(Script { actions, objects, held_from: STEPS_TO_GRASP })
}

/// The expert's T commands at a closed door.
pub(super) fn commands(setup: &DoorSetup) -> Vec<Action> {
    script(setup, 0.0, crate::tabletop::ACTION_STEPS).map_or(Vec::new(), |script| script.actions)
}
