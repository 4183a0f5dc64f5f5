//! The triangle's expert: over it, down, close, turn, hold.

use std::f64::consts::{PI, TAU};

use nalgebra::Vector3;
use reseflow_data::Action;
use reseflow_lie::{SE3, SO3};

use super::scene::HEIGHT_M;
use super::setup::{grasp_yaw_rad, pointing_down};
use crate::expert::{Glance, Script, Tolerance};

/// How far above the grasp the gripper stops first, metres.
const HOVER_M: f64 = 0.08;
/// Action steps before the turn.
const STEPS_TO_GRASP: usize = 3;
/// Action steps over which the turn is spread where there is time.
const TURN_STEPS: usize = 6;

/// The prism is on its course within this; the pads that hold it are at least 5 cm apart.
pub(super) const TOLERANCE: Tolerance = Tolerance { off_m: 0.015, off_rad: 0.2, held_opening: 0.3 };

/// The script that turns the prism by `turn_rad` from where it started, counter-clockwise seen from above, and ends with
/// its centre where it started.
///
/// Every command is a smooth function of the poses, but for the choice of the half-turn. `radius_m` is the prism's
/// circumradius. `None` with fewer than four action steps.
pub(super) fn script(
    glance: &Glance,
    world_from_gripper: &SE3,
    steps: usize,
    radius_m: f64,
    turn_rad: f64,
) -> Option<Script> {
    let turn_steps = steps.checked_sub(STEPS_TO_GRASP).filter(|&left| left > 0)?.min(TURN_STEPS);
    let turned_rad = wrapped(yaw(&glance.object) - yaw(&glance.start));
    let at = |center: Vector3<f64>, yaw_rad: f64| {
        let level = Vector3::new(center.x, center.y, 0.5 * HEIGHT_M);
        SE3::new(SO3::exp(&(Vector3::z() * yaw_rad)), level)
    };
    let now = at(glance.object.translation, yaw(&glance.object));
    // The middle between the corner (at +r) and the opposite face (at −r/2).
    let grasp = SE3::new(
        pointing_down(grasp_yaw_rad(world_from_gripper, yaw(&now))),
        now.act(&(Vector3::x() * (0.25 * radius_m))),
    );
    let hover = SE3::new(grasp.rotation, grasp.translation + Vector3::z() * HOVER_M);
    let object_from_gripper = now.inverse() * grasp;

    let command = |world_from_gripper, opening| Action { world_from_gripper, opening };
    let mut actions = vec![command(hover, 1.0), command(grasp, 1.0), command(grasp, 0.0)];
    let mut objects = vec![now; STEPS_TO_GRASP + 1];
    for step in 1..=turn_steps {
        let share = step as f64 / turn_steps as f64;
        let center = now.translation + (glance.start.translation - now.translation) * share;
        let object = at(center, yaw(&now) + (turn_rad - turned_rad) * share);
        actions.push(command(object * object_from_gripper, 0.0));
        objects.push(object);
    }
    let (last, object) = (actions[actions.len() - 1], objects[objects.len() - 1]);
    actions.resize(steps, last);
    objects.resize(steps + 1, object);
    Some(Script { actions, objects, held_from: STEPS_TO_GRASP })
}

/// The direction, seen from above, from a prism's centre to its coloured corner, rad from the world's x axis.
fn yaw(world_from_prism: &SE3) -> f64 {
    let corner = world_from_prism.rotation.act(&Vector3::x());
    corner.y.atan2(corner.x)
}

/// An angle in \[−π, π).
fn wrapped(angle_rad: f64) -> f64 {
    (angle_rad + PI).rem_euclid(TAU) - PI
}
