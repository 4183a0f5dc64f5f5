//! Door opening: take the handle bar of a cabinet's door and swing the door open along its arc.
//!
//! The hinge is on the left or on the right, a vertical axis with Coulomb friction and stops; a dark strip marks it and
//! the coloured handle is on the other side. Done when the door stands open by 50° or more, and nothing but the gripper's
//! touch has moved it.

mod cabinet;
mod expert;
mod scene;
mod setup;

use reseflow_data::{EpisodeKey, Scene, Task, TaskError, TaskSpec};

use crate::camera::CameraSettings;
use crate::tabletop;
use crate::world::settings::PhysicsSettings;
use scene::DoorScene;

pub use setup::{DoorSetup, HingeSide};

/// The registered name.
pub(crate) const NAME: &str = "door";
/// Points per cloud unless the camera says otherwise, the paper's.
const POINTS: usize = 128;
/// A disturbance comes when the fingers have closed on the handle and the door moves.
const DISTURB_BEFORE: usize = 4;

/// The door-opening task.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct DoorTask {
    /// How the world is simulated.
    pub physics: PhysicsSettings,
    /// How frames are made.
    pub camera: CameraSettings,
}

impl DoorTask {
    /// The scene of a given setup; `key` names the camera's noise.
    pub fn scene(&self, setup: DoorSetup, key: &EpisodeKey) -> Box<dyn Scene> {
        Box::new(DoorScene::new(self, setup, key))
    }
}

impl Task for DoorTask {
    fn spec(&self) -> TaskSpec {
        let description = "Grasp the handle bar of the cabinet's door and swing the door open by at least 50 degrees, \
                           moving it by touch alone.";
        tabletop::spec(NAME, description, self.camera.points.unwrap_or(POINTS), DISTURB_BEFORE)
    }

    fn reset(&self, key: &EpisodeKey) -> Result<Box<dyn Scene>, TaskError> {
        Ok(self.scene(DoorSetup::draw(key)?, key))
    }
}
