//! Painting: follow the stroke that is printed on a tilted board with a wet brush.
//!
//! A square board on a stand shows one open stroke of the library (`assets/strokes/`), blue, with a green disc where it begins.
//! The gripper holds a brush that paints while its bristles are compressed by 1 to 10 mm; paint is red and hides what is under
//! it. Done when 90 % of the stroke is within 10 mm of paint, the paint's 95th-percentile distance from the stroke is at
//! most 15 mm, and the compression was in range in 95 % of the control ticks from the first to the last at which the brush
//! painted. Where it was begun does not count: the disc is where the expert begins.

mod board;
mod expert;
mod library;
mod paint;
mod scene;
mod setup;
mod stroke;

use reseflow_data::{EpisodeKey, Scene, Task, TaskError, TaskSpec};

use crate::camera::CameraSettings;
use crate::tabletop;
use crate::world::settings::PhysicsSettings;
use scene::PaintingScene;

pub use setup::PaintingSetup;
pub use stroke::Stroke;

/// The registered name.
pub(crate) const NAME: &str = "painting";
/// Points per cloud unless the camera says otherwise, the paper's.
const POINTS: usize = 256;
/// A disturbance comes while the brush is over the board, before it touches.
const DISTURB_BEFORE: usize = 1;

/// The painting task.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PaintingTask {
    /// How the world is simulated.
    pub physics: PhysicsSettings,
    /// How frames are made.
    pub camera: CameraSettings,
}

impl PaintingTask {
    /// The scene of a given setup; `key` names the camera's noise.
    ///
    /// # Errors
    /// When the board has no size.
    pub fn scene(&self, setup: PaintingSetup, key: &EpisodeKey) -> Result<Box<dyn Scene>, TaskError> {
        Ok(Box::new(PaintingScene::new(self, setup, key)?))
    }
}

impl Task for PaintingTask {
    fn spec(&self) -> TaskSpec {
        let description = "Paint along the stroke that is printed on the tilted board, from the disc where it begins or \
                           from its other end, so that paint covers 90 % of it to 10 mm and hardly any lies beyond 15 mm.";
        tabletop::spec(NAME, description, self.camera.points.unwrap_or(POINTS), DISTURB_BEFORE)
    }

    fn reset(&self, key: &EpisodeKey) -> Result<Box<dyn Scene>, TaskError> {
        self.scene(PaintingSetup::draw(key)?, key)
    }
}
