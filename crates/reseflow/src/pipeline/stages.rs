//! The stages of a run and what each depends on; those that make data.

use std::path::PathBuf;

use reseflow_data::{Dataset, Split, Task};
use serde_json::{Value, json};

use super::scoring::eval_solver;
use super::timing::{LATENCY, time_policies};
use super::{Layout, RolloutSeries, StageRun, Stamps};
use crate::config::{EvalSplit, ExperimentConfig};
use crate::demonstrations::{DemonstrationRequest, record};
use crate::evaluation::turned;
use crate::learners::Learner;
use crate::output::{OutputFile, Terminal};
use crate::plot::{LinePlot, encode_png};

/// What every stage needs.
pub(super) struct Context<'a> {
    pub(super) config: &'a ExperimentConfig,
    pub(super) task: &'a dyn Task,
    pub(super) layout: &'a Layout,
    pub(super) fresh: bool,
    pub(super) terminal: &'a Terminal,
}

/// Does the work of the stage of this name, which depends on the inputs and leaves the outputs, where it has to be done, and gives
/// the hash of what it depended on.
pub(super) type Stage<'s> =
    dyn FnMut(&str, Value, &[PathBuf], &mut dyn FnMut() -> anyhow::Result<()>) -> anyhow::Result<String> + 's;

/// Runs the stages in order; each depends on the hashes of those whose results it reads.
pub(super) fn run_all(context: &Context<'_>) -> anyhow::Result<Vec<StageRun>> {
    let Context { config, layout, terminal, .. } = context;
    let shipped = context.shipped()?;
    let stamps = Stamps::new(layout.stamps(), context.fresh);
    let mut runs = Vec::new();
    let mut stage =
        |name: &str, inputs: Value, outputs: &[PathBuf], work: &mut dyn FnMut() -> anyhow::Result<()>| {
            let run = stamps.stage(name, &inputs, outputs, terminal, work)?;
            let hash = run.inputs.clone();
            runs.push(run);
            anyhow::Ok(hash)
        };

    let mut data_stage = |split: Split, episodes: usize| {
        let file = layout.data(&split.to_string());
        let data = &config.data;
        let mut inputs = json!([config.task, split, data.seed, episodes, data.camera]);
        if let (Some(inputs), true) = (inputs.as_array_mut(), context.disturbed_share(split) > 0.0) {
            inputs.push(data.disturbed_share.into());
        }
        stage(&format!("data-{split}"), inputs, &[file], &mut || context.record(split, episodes))
    };
    let train_data = data_stage(Split::Train, config.data.train_episodes)?;
    let test_data = data_stage(Split::Test, config.data.test_episodes)?;
    let validation_data = match config.data.validation_episodes {
        0 => None,
        episodes => Some(data_stage(Split::Validation, episodes)?),
    };

    let asked = |split| config.eval.splits.contains(&split);
    let wide_data = match asked(EvalSplit::Wide) {
        true => Some(data_stage(Split::Wide, config.data.test_episodes)?),
        false => None,
    };
    let turned_data = match asked(EvalSplit::Turned) {
        true => {
            let file = layout.data(EvalSplit::Turned.name());
            Some(stage("data-turned", json!(test_data), &[file], &mut || context.turn())?)
        }
        false => None,
    };
    let splits =
        [(EvalSplit::Test, Some(test_data)), (EvalSplit::Wide, wide_data), (EvalSplit::Turned, turned_data)];
    let splits: Vec<_> = splits.into_iter().filter_map(|(split, data)| Some((split, data?))).collect();

    let policies = match shipped {
        Some(shipped) => context.adopt(&mut stage, &shipped)?,
        None => {
            let learned = context.learn(&mut stage, &train_data, validation_data.as_deref())?;
            let hashes: Vec<&String> = learned.iter().map(|(_, hash)| hash).collect();
            let work = &mut || context.log_trainings(&learned);
            stage("training-log", json!(hashes), &[layout.training_log()], work)?;
            learned
        }
    };
    for (learner, policy) in &policies {
        let mut on_test = None;
        for (split, data) in &splits {
            // The turned episodes are compared with those of the test split.
            let before = on_test.as_ref().filter(|_| *split == EvalSplit::Turned);
            let inputs = json!([policy, train_data, data, before, context.eval_inputs(*learner, *split)]);
            let (name, outputs) = (Layout::eval_name(*learner, *split), context.scores(*learner, *split));
            let hash = stage(&name, inputs, &outputs, &mut || context.eval(*learner, *split))?;
            if *split == EvalSplit::Test {
                on_test = Some(hash);
            }
        }
    }

    if let Some(samplers) = &config.samplers {
        let flows = context.compared_flows().into_iter().map(Learner::Flow);
        let compared: Vec<_> =
            flows.map(|flow| policies.iter().find(|(learner, _)| *learner == flow)).collect();
        let hashes: Vec<_> = compared.into_iter().flatten().map(|(_, hash)| hash).collect();
        let inputs = json!([hashes, splits[0].1, samplers, config.device]);
        stage("samplers", inputs, &[layout.samplers()], &mut || context.compare_samplers(samplers))?;
    }

    for series in RolloutSeries::all(config) {
        let acting = policies.iter().find(|(learner, _)| *learner == series.learner);
        let inputs = json!([acting.map(|(_, hash)| hash), context.rollout_inputs(&series)]);
        stage(&series.name, inputs, &context.rollout_leaves(&series), &mut || context.rollout(&series))?;
    }

    if config.eval.timed {
        let learned: Vec<_> = policies
            .iter()
            .map(|(learner, hash)| json!([hash, eval_solver(&config.eval, *learner, EvalSplit::Test)]))
            .collect();
        let inputs = json!([learned, splits[0].1, config.device]);
        let work = &mut || time_policies(config, layout, terminal).map(drop);
        stage(LATENCY, inputs, &[layout.latency()], work)?;
    }
    Ok(runs)
}

impl Context<'_> {
    /// Policies are judged on episodes that were left alone.
    fn disturbed_share(&self, split: Split) -> f64 {
        if split == Split::Train { self.config.data.disturbed_share } else { 0.0 }
    }

    fn record(&self, split: Split, episodes: usize) -> anyhow::Result<()> {
        let data = &self.config.data;
        let disturbed_share = self.disturbed_share(split);
        let request =
            DemonstrationRequest { split, seed: data.seed, episodes, camera: data.camera, disturbed_share };
        let progress = self.terminal.progress(&format!("data, {split}"), episodes as u64);
        let dataset = record(self.task, &request, &|| progress.advance())?;
        progress.finish();
        Ok(dataset.write(self.layout.data(&split.to_string()))?)
    }

    /// Moves the test episodes.
    fn turn(&self) -> anyhow::Result<()> {
        let test = Dataset::read(self.layout.data(EvalSplit::Test.name()))?;
        Ok(turned(&test).write(self.layout.data(EvalSplit::Turned.name()))?)
    }

    /// Draws a picture of the run.
    pub(super) fn draw(&self, name: &str, plot: &LinePlot) -> anyhow::Result<()> {
        OutputFile::claim(&self.layout.picture(name))?.write(&encode_png(&plot.draw()?, name)?)
    }
}
