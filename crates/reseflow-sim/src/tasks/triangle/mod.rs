//! Rotating triangle: grasp a flat triangular prism, one corner coloured, and turn it about its centre.
//!
//! One pad lies on the coloured corner's edge, the other flat on the face opposite; friction holds. Done when the prism
//! has turned about the vertical by the goal ± 0.1 rad, counter-clockwise seen from above, its centre is within 3 cm of where
//! it was, and it is not tipped over (0.3 rad: held between the pads it tilts with the gripper). A shove moves the task along:
//! what counts then is where the prism lay when the gripper next touched it. Each goal is a task of its own; `coin_toss` is
//! done by a quarter turn to either side.

mod expert;
mod goal;
mod scene;
mod setup;

use reseflow_data::{EpisodeKey, Scene, Task, TaskError, TaskSpec};

use crate::camera::CameraSettings;
use crate::tabletop;
use crate::world::settings::PhysicsSettings;
use scene::TriangleScene;

pub use goal::TriangleGoal;
pub use setup::TriangleSetup;

/// Points per cloud unless the camera says otherwise, the paper's.
const POINTS: usize = 100;
/// A disturbance comes while the gripper is over the prism, before it goes down.
const DISTURB_BEFORE: usize = 1;

/// The rotating-triangle task.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct TriangleTask {
    /// How far to turn.
    pub goal: TriangleGoal,
    /// How the world is simulated.
    pub physics: PhysicsSettings,
    /// How frames are made.
    pub camera: CameraSettings,
}

impl TriangleTask {
    /// The scene of a given setup; `key` names the camera's noise and the coin.
    ///
    /// # Errors
    /// When the triangle has no volume.
    pub fn scene(&self, setup: TriangleSetup, key: &EpisodeKey) -> Result<Box<dyn Scene>, TaskError> {
        Ok(Box::new(TriangleScene::new(self, setup, key)?))
    }
}

impl Task for TriangleTask {
    fn spec(&self) -> TaskSpec {
        let description = format!(
            "Grasp the flat triangle with one pad on its coloured corner and turn it {}, to 0.1 rad, its centre kept \
             within 3 cm; after a shove both count from where it lies when the gripper next touches it.",
            self.goal.wording()
        );
        tabletop::spec(
            self.goal.task_name(),
            &description,
            self.camera.points.unwrap_or(POINTS),
            DISTURB_BEFORE,
        )
    }

    fn reset(&self, key: &EpisodeKey) -> Result<Box<dyn Scene>, TaskError> {
        self.scene(TriangleSetup::draw(key), key)
    }
}
