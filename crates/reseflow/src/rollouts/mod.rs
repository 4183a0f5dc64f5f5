//! Policies in the simulator: running episodes, reporting them, picturing them.

mod episodes;
mod pictures;
mod plan_choice;
mod report;
mod turned;
mod witness;

pub use episodes::{Actor, EpisodeResult, RolloutRequest, Script, run_episodes};
pub use pictures::PictureBook;
pub use report::{LatencyMillis, RolloutReport};
pub use turned::TurnedTask;
pub(crate) use turned::{motion_of, move_action, move_observation};
pub use witness::Witness;

use std::path::Path;

use reseflow_data::Task;
use reseflow_sim::{CameraSettings, PhysicsSettings, SimError, configured_task, tasks};

use crate::cli::SplitArg;
use crate::config::nearest;
use crate::error::bad_input;
use crate::output::OutputFile;

/// Episodes in a preview.
pub const PREVIEW_EPISODES: usize = 4;

/// The first noise seed, as in the paper.
pub const FIRST_SEED: u64 = 3407;

/// The registered task of this name under `camera`.
///
/// # Errors
/// Bad input that lists the known tasks, or names the setting of the camera that cannot be.
pub fn find_task(name: &str, camera: CameraSettings) -> anyhow::Result<Box<dyn Task>> {
    configured_task(name, PhysicsSettings::default(), camera).map_err(|fault| {
        let near = match fault {
            SimError::UnknownTask { .. } => nearest(name, tasks().iter().copied()),
            _ => None,
        };
        let hint = near.map(|near| format!("; did you mean `{near}`?"));
        bad_input(format!("{fault}{}", hint.unwrap_or_default()))
    })
}

/// The registered task of this name under `camera`, as the split wants it.
///
/// # Errors
/// As [`find_task`].
pub fn find_split_task(name: &str, split: SplitArg, camera: CameraSettings) -> anyhow::Result<Box<dyn Task>> {
    let task = find_task(name, camera)?;
    Ok(if split == SplitArg::Turned { Box::new(TurnedTask(task)) } else { task })
}

/// Where a preview goes: the strip of pictures that was asked for, and a film beside it.
pub struct PreviewFiles {
    strip: OutputFile,
    film: OutputFile,
}

impl PreviewFiles {
    /// Makes sure that `path`, and the `.gif` of the same name, can be written.
    ///
    /// # Errors
    /// Bad input when they cannot, or when `path` is itself the name of a GIF.
    pub fn claim(path: &Path) -> anyhow::Result<Self> {
        let film = path.with_extension("gif");
        if film == path {
            return Err(bad_input(format!("{}: expected the name of a PNG picture", path.display())));
        }
        Ok(Self { strip: OutputFile::claim(path)?, film: OutputFile::claim(&film)? })
    }

    /// The names of both, as messages show them.
    pub fn names(path: &Path) -> String {
        format!("{}, {}", path.display(), path.with_extension("gif").display())
    }

    /// Draws the pictures.
    ///
    /// # Errors
    /// When drawing or writing fails.
    pub fn write(&self, pictures: &PictureBook) -> anyhow::Result<()> {
        self.strip.write(&pictures.png()?)?;
        self.film.write(&pictures.gif()?)
    }
}
