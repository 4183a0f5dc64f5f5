//! `reseflow run`: data, training, evaluation and rollouts as one resumable pipeline.

mod acting;
mod layout;
mod policies;
mod scoring;
mod stages;
mod stamp;
mod summary;
mod timing;

pub use acting::RolloutSeries;
pub use layout::Layout;
pub use stamp::{StageRun, Stamps};
pub use summary::RunSummary;
pub use timing::FinishedRun;

use std::fs::{File, TryLockError};
use std::time::Instant;

use anyhow::Context;

use crate::config::ExperimentConfig;
use crate::error::bad_input;
use crate::output::{OutputFile, OutputFolder, Terminal};
use crate::rollouts::find_task;

/// Runs every stage whose inputs have changed, and sums up what is there in the end.
///
/// # Errors
/// Bad input before anything is done; later, what a stage reports. Finished stages stay finished.
pub fn run(config: &ExperimentConfig, fresh: bool, terminal: &Terminal) -> anyhow::Result<RunSummary> {
    let started = Instant::now();
    let task = find_task(&config.task, config.data.camera)?;
    let layout = Layout::new(config.folder());
    for folder in layout.folders() {
        OutputFolder::claim(&folder)?;
    }
    let _lock = lock(&layout)?;
    let resolved = toml::to_string(config).context("writing the resolved configuration")?;

    let stages =
        stages::run_all(&stages::Context { config, task: task.as_ref(), layout: &layout, fresh, terminal })?;
    // Only now does the folder hold what the configuration says.
    OutputFile::claim(&layout.config())?.write(resolved.as_bytes())?;
    let summary = RunSummary::gather(config, &layout, stages, started.elapsed().as_secs_f64())?;
    OutputFile::claim(&layout.summary())?.write_json(&summary)?;
    Ok(summary)
}

/// Keeps a second run out of the folder until the file is dropped; the system lets go of it when the process ends, however it ends.
fn lock(layout: &Layout) -> anyhow::Result<File> {
    let path = layout.lock();
    let file = File::create(&path).with_context(|| format!("{}: cannot be written", path.display()))?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => {
            Err(bad_input(format!("{}: another run is at work in this folder", layout.root().display())))
        }
        Err(TryLockError::Error(reason)) => {
            Err(reason).with_context(|| format!("{}: cannot be locked", path.display()))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::{EXIT_BAD_INPUT, exit_code};

    #[test]
    fn a_folder_takes_one_run_at_a_time() {
        let folder = tempfile::tempdir().unwrap();
        let layout = Layout::new(folder.path().to_owned());
        std::fs::create_dir(layout.stamps()).unwrap();
        let first = lock(&layout).unwrap();
        assert_eq!(exit_code(&lock(&layout).unwrap_err()), EXIT_BAD_INPUT);
        drop(first);
        lock(&layout).unwrap();
    }
}
