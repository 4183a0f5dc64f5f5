//! Actions: commanded gripper poses with an opening, and chunks of them.

use std::f64::consts::PI;

use reseflow_lie::{SE3, SO3, Vector3};

/// Half a turn about the approach axis, z: after it the gripper is where it was, with its fingers exchanged.
pub fn gripper_half_turn() -> SE3 {
    SE3::new(SO3::exp(&Vector3::new(0.0, 0.0, PI)), Vector3::zeros())
}

/// The command in force at the end of one action step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Action {
    /// The commanded gripper pose.
    pub world_from_gripper: SE3,
    /// The commanded opening, 0 closed to 1 open.
    pub opening: f64,
}

impl Action {
    /// The command a fraction `s` ∈ \[0, 1\] of the way to `end`: along the screw geodesic, the opening linearly.
    pub fn interpolate(&self, end: &Action, s: f64) -> Action {
        Action {
            world_from_gripper: self.world_from_gripper.interpolate_screw(&end.world_from_gripper, s),
            opening: self.opening + s * (end.opening - self.opening),
        }
    }
}

/// L consecutive actions, one per action step.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ActionChunk(pub Vec<Action>);

impl ActionChunk {
    /// The horizon L.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there is no action at all.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The actions in order.
    pub fn iter(&self) -> std::slice::Iter<'_, Action> {
        self.0.iter()
    }
}
