//! What single plans of a run's policies take: the stage `latency`, and the same afterwards, when nothing else runs beside.

use std::fs::File;
use std::path::Path;

use reseflow_data::Dataset;

use super::scoring::eval_solver;
use super::{Layout, Stamps};
use crate::config::{EvalSplit, ExperimentConfig, load_experiment};
use crate::error::{about_data, bad_input};
use crate::evaluation::{LatencyReport, time_plans};
use crate::learners::Learner;
use crate::learning::LearnedPolicy;
use crate::output::{OutputFile, Terminal};

/// The stage's name.
pub(super) const LATENCY: &str = "latency";

/// Times every policy from the test episodes' first observations, with each number of steps that it is scored with.
pub(super) fn time_policies(
    config: &ExperimentConfig,
    layout: &Layout,
    terminal: &Terminal,
) -> anyhow::Result<LatencyReport> {
    let path = layout.data(EvalSplit::Test.name());
    let data = Dataset::read(&path)?;
    let out = OutputFile::claim(&layout.latency())?;
    let learners: Vec<Learner> = Learner::all(config).collect();
    let mut report = LatencyReport::new(&layout.root().display().to_string(), config.device);
    let progress = terminal.progress(LATENCY, learners.len() as u64);
    for learner in learners {
        let folder = layout.checkpoint(learner);
        let policy = LearnedPolicy::load(&folder, config.device)?;
        let (steps, solver) = eval_solver(&config.eval, learner, EvalSplit::Test);
        let timed = time_plans(&learner.shipped_name(), &folder, &policy, &data, &solver.with_each(&steps));
        report.rows.extend(timed.map_err(|fault| about_data(&path, None, fault))?);
        progress.advance();
    }
    progress.finish();
    out.write_json(&report)?;
    Ok(report)
}

/// A run that has been finished, and that no other process works on.
#[derive(Debug)]
pub struct FinishedRun {
    config: ExperimentConfig,
    layout: Layout,
    _lock: File,
}

impl FinishedRun {
    /// The run in `folder`.
    ///
    /// # Errors
    /// Bad input: there is no such folder, no run has been finished in it, one is at work in it, or something of it is gone.
    pub fn open(folder: &Path) -> anyhow::Result<Self> {
        let place = folder.display();
        if !folder.is_dir() {
            return Err(bad_input(format!(
                "{place}: there is no such folder, expected that of a run; a policy by its name or path is given with --checkpoint"
            )));
        }
        let layout = Layout::new(folder.to_owned());
        if !layout.config().is_file() || !layout.stamps().is_dir() {
            return Err(bad_input(format!(
                "{place}: expected the folder of a run that `reseflow run` has finished"
            )));
        }
        let lock = super::lock(&layout)?;
        let config = load_experiment(&layout.config(), &[])?;
        let needed = Learner::all(&config).map(|learner| layout.weights(learner));
        for path in needed.chain([layout.data(EvalSplit::Test.name())]) {
            if !path.is_file() {
                let path = path.display();
                return Err(bad_input(format!(
                    "{path}: there is no such file, expected what the run left there"
                )));
            }
        }
        Ok(Self { config, layout, _lock: lock })
    }

    /// Times the run's policies anew, and writes its `latency.json`.
    ///
    /// # Errors
    /// Bad input: a file of the run is broken.
    pub fn time(&self, terminal: &Terminal) -> anyhow::Result<LatencyReport> {
        let report = time_policies(&self.config, &self.layout, terminal)?;
        // Otherwise the next run would take these for a damaged result of its own, and time again.
        Stamps::new(self.layout.stamps(), false).renew(LATENCY, &[self.layout.latency()])?;
        Ok(report)
    }
}
