//! `reseflow run`: data, training, evaluation and rollouts as one resumable pipeline.

mod layout;
mod stages;
mod stamp;
mod summary;

pub use layout::Layout;
pub use stamp::{StageRun, Stamps};
pub use summary::RunSummary;

use std::time::Instant;

use anyhow::Context;

use crate::config::ExperimentConfig;
use crate::output::{OutputFile, OutputFolder, Terminal};
use crate::rollouts::find_task;

/// Runs every stage whose inputs have changed, and sums up what is there in the end.
///
/// # Errors
/// Bad input before anything is done; later, what a stage reports. Finished stages stay finished.
pub fn run(config: &ExperimentConfig, fresh: bool, terminal: &Terminal) -> anyhow::Result<RunSummary> {
    let started = Instant::now();
    let task = find_task(&config.task)?;
    let layout = Layout::new(config.folder());
    for folder in layout.folders() {
        OutputFolder::claim(&folder)?;
    }
    let resolved = toml::to_string(config).context("writing the resolved configuration")?;
    OutputFile::claim(&layout.config())?.write(resolved.as_bytes())?;

    let stages =
        stages::run_all(&stages::Context { config, task: task.as_ref(), layout: &layout, fresh, terminal })?;
    let summary = RunSummary::gather(config, &layout, stages, started.elapsed().as_secs_f64())?;
    OutputFile::claim(&layout.summary())?.write_json(&summary)?;
    Ok(summary)
}
