//! What single plans of a run's policies take: the stage `latency`, and the same afterwards, when nothing else runs beside.

use std::path::Path;

use reseflow_data::Dataset;

use super::Layout;
use super::stages::Context;
use crate::config::{EvalSplit, load_experiment};
use crate::error::bad_input;
use crate::evaluation::{LatencyReport, time_plans};
use crate::learners::Learner;
use crate::learning::LearnedPolicy;
use crate::output::{OutputFile, Terminal};
use crate::rollouts::find_task;

impl Context<'_> {
    /// Times every policy from the test episodes' first observations, with each number of steps that it is scored with.
    pub(super) fn time(&self) -> anyhow::Result<LatencyReport> {
        let data = Dataset::read(self.layout.data(EvalSplit::Test.name()))?;
        let flows = (1..=self.config.flows()).map(Learner::Flow);
        let learners: Vec<Learner> = flows.chain(Learner::references(self.config)).collect();
        let mut report = LatencyReport::new(self.config.device);
        let progress = self.terminal.progress("latency", learners.len() as u64);
        for learner in learners {
            let policy = LearnedPolicy::load(&self.layout.checkpoint(learner), self.config.device)?;
            let (steps, solver) = self.eval_solver(learner);
            let name = learner.shipped_name();
            report.rows.extend(time_plans(&name, &policy, &data, &solver.with_each(&steps))?);
            progress.advance();
        }
        progress.finish();
        OutputFile::claim(&self.layout.latency())?.write_json(&report)?;
        Ok(report)
    }
}

/// Times the policies of the finished run in `folder` anew, and writes its `latency.json`.
///
/// # Errors
/// Bad input: no run has been finished in this folder, or one is at work in it.
pub fn time_run(folder: &Path, terminal: &Terminal) -> anyhow::Result<LatencyReport> {
    let layout = Layout::new(folder.to_owned());
    if !layout.config().is_file() || !layout.stamps().is_dir() {
        let place = folder.display();
        return Err(bad_input(format!(
            "{place}: expected the folder of a run that `reseflow run` has finished"
        )));
    }
    let _lock = super::lock(&layout)?;
    let config = load_experiment(&layout.config(), &[])?;
    let task = find_task(&config.task, config.data.camera)?;
    Context { config: &config, task: task.as_ref(), layout: &layout, fresh: false, terminal }.time()
}
