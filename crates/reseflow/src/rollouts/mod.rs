//! Policies in the simulator: running episodes, reporting them, picturing them.

mod episodes;
mod pictures;
mod report;
mod turned;
mod witness;

pub use episodes::{Actor, EpisodeResult, RolloutRequest, Script, run_episodes};
pub use pictures::PictureBook;
pub use report::{LatencyMillis, RolloutReport};
pub use turned::TurnedTask;
pub use witness::Witness;

use reseflow_data::Task;

use crate::cli::SplitArg;
use crate::config::nearest;
use crate::error::bad_input;

/// The first noise seed, as in the paper.
pub const FIRST_SEED: u64 = 3407;

/// The registered task of this name.
///
/// # Errors
/// Bad input that lists the known tasks.
pub fn find_task(name: &str) -> anyhow::Result<Box<dyn Task>> {
    reseflow_sim::task(name).ok_or_else(|| {
        let known = reseflow_sim::tasks();
        let hint = nearest(name, known.iter().copied()).map(|near| format!("; did you mean `{near}`?"));
        bad_input(format!(
            "unknown task `{name}`, expected one of {}{}",
            known.join(", "),
            hint.unwrap_or_default()
        ))
    })
}

/// The registered task of this name, as the split wants it.
///
/// # Errors
/// As [`find_task`].
pub fn find_split_task(name: &str, split: SplitArg) -> anyhow::Result<Box<dyn Task>> {
    let task = find_task(name)?;
    Ok(if split == SplitArg::Turned { Box::new(TurnedTask(task)) } else { task })
}
