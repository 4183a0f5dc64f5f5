//! Rotating triangle: grasp a flat triangular prism, one corner coloured, and turn it by π/2 about its centre.
//!
//! One pad lies on the coloured corner's edge, the other flat on the face opposite; friction holds. Counter-clockwise
//! seen from above. Done when the prism has turned by π/2 ± 0.1 rad about the vertical, its centre is within 3 cm of where
//! it was, and it is not tipped over (0.3 rad: held between the pads it tilts with the gripper).

mod expert;
mod scene;
mod setup;

use reseflow_data::{EpisodeKey, Scene, Task, TaskError, TaskSpec};

use crate::camera::CameraSettings;
use crate::tabletop;
use crate::world::settings::PhysicsSettings;
use scene::TriangleScene;

pub use setup::TriangleSetup;

/// The registered name.
pub(crate) const NAME: &str = "triangle";
/// Points per cloud, the paper's.
const POINTS: usize = 100;

/// The rotating-triangle task.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct TriangleTask {
    /// How the world is simulated.
    pub physics: PhysicsSettings,
    /// How frames are made.
    pub camera: CameraSettings,
}

impl TriangleTask {
    /// The scene of a given setup; `key` names the camera's noise.
    ///
    /// # Errors
    /// When the triangle has no volume.
    pub fn scene(&self, setup: TriangleSetup, key: &EpisodeKey) -> Result<Box<dyn Scene>, TaskError> {
        Ok(Box::new(TriangleScene::new(self, setup, key)?))
    }
}

impl Task for TriangleTask {
    fn spec(&self) -> TaskSpec {
        let description = "Grasp the flat triangle with one pad on its coloured corner and turn it by a quarter turn \
                           counter-clockwise, to 0.1 rad, its centre kept within 3 cm.";
        tabletop::spec(NAME, description, POINTS)
    }

    fn reset(&self, key: &EpisodeKey) -> Result<Box<dyn Scene>, TaskError> {
        self.scene(TriangleSetup::draw(key), key)
    }
}
