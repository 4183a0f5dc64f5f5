//! What each stage of a run does.

use std::path::PathBuf;

use reseflow_data::{Dataset, DatasetFile, PairSet, Split, Task};
use reseflow_train::{ReflowConfig, Resume};
use serde_json::{Value, json};

use super::{Layout, StageRun, Stamps};
use crate::config::{ExperimentConfig, SolverChoice};
use crate::demonstrations::{DemonstrationRequest, record};
use crate::evaluation::{EvalInputs, EvalReport, evaluate};
use crate::learners::{Learner, Training};
use crate::learning::LearnedPolicy;
use crate::output::{OutputFile, Terminal};
use crate::plot::{
    LinePlot, PredictorCurve, d_geo_against_steps, encode_png, per_action_error, training_curve,
};
use crate::provenance::Provenance;
use crate::reflow::Round;
use crate::rollouts::{Actor, PictureBook, RolloutReport, RolloutRequest, Witness, run_episodes};

/// What every stage needs.
pub(super) struct Context<'a> {
    pub(super) config: &'a ExperimentConfig,
    pub(super) task: &'a dyn Task,
    pub(super) layout: &'a Layout,
    pub(super) fresh: bool,
    pub(super) terminal: &'a Terminal,
}

/// Runs the stages in order; each depends on the hashes of those whose results it reads.
pub(super) fn run_all(context: &Context<'_>) -> anyhow::Result<Vec<StageRun>> {
    let Context { config, layout, terminal, .. } = context;
    let stamps = Stamps::new(layout.stamps(), context.fresh);
    let mut runs = Vec::new();
    let mut stage =
        |name: &str, inputs: Value, outputs: &[_], work: &mut dyn FnMut() -> anyhow::Result<()>| {
            let run = stamps.stage(name, &inputs, outputs, terminal, work)?;
            let hash = run.inputs.clone();
            runs.push(run);
            anyhow::Ok(hash)
        };

    let mut data_stage = |split: Split, episodes: usize| {
        let file = layout.data(&split.to_string());
        let inputs = json!([config.task, split, config.data.seed, episodes, config.data.camera]);
        stage(&format!("data-{split}"), inputs, &[file], &mut || context.record(split, episodes))
    };
    let train_data = data_stage(Split::Train, config.data.train_episodes)?;
    let test_data = data_stage(Split::Test, config.data.test_episodes)?;
    let validation_data = match config.data.validation_episodes {
        0 => None,
        episodes => Some(data_stage(Split::Validation, episodes)?),
    };

    let inputs = json!([train_data, validation_data, config.model, config.train, config.device]);
    let mut learners = vec![(Learner::Flow(1), inputs.clone())];
    learners.extend(Learner::references(config).map(|reference| match reference {
        Learner::Baseline => (reference, json!([inputs, config.baseline])),
        _ => (reference, inputs.clone()),
    }));
    let mut policies = Vec::new();
    for (learner, inputs) in learners {
        let outputs = context.leaves(learner);
        let hash = stage(&learner.name("train"), inputs, &outputs, &mut || context.train(learner))?;
        policies.push((learner, hash));
    }
    let mut last = policies[0].1.clone();
    for (reflow, round) in
        config.reflow.iter().flat_map(|reflow| (1..=reflow.rounds).map(move |n| (reflow, n)))
    {
        let (learner, start) = (Learner::Flow(round + 1), last);
        let inputs = json!([start, train_data, reflow.pairs_of(round), config.device]);
        let work = &mut || context.pairs(reflow, round);
        let pairs = stage(&learner.name("pairs"), inputs, &[layout.pairs(round + 1)], work)?;

        let training = reflow.training(&config.train, round);
        let inputs =
            json!([start, pairs, train_data, validation_data, training, reflow.mixture, config.device]);
        let work = &mut || context.reflow(reflow, round);
        last = stage(&learner.name("train"), inputs, &context.leaves(learner), work)?;
        policies.push((learner, last.clone()));
    }

    for (learner, policy) in &policies {
        let inputs = json!([policy, train_data, test_data, config.eval, config.device]);
        let picture = |name: &str| layout.picture(&learner.name(name));
        let outputs = [layout.eval(*learner), picture("d_geo_steps"), picture("per_action")];
        stage(&learner.name("eval"), inputs, &outputs, &mut || context.eval(*learner))?;
    }

    let inputs =
        json!([last, config.task, config.data.seed, config.data.camera, config.rollout, config.device]);
    let outputs = [layout.rollout(), layout.log(), layout.picture("episodes")];
    stage("rollout", inputs, &outputs, &mut || context.rollout())?;
    Ok(runs)
}

impl Context<'_> {
    fn record(&self, split: Split, episodes: usize) -> anyhow::Result<()> {
        let data = &self.config.data;
        let request = DemonstrationRequest { split, seed: data.seed, episodes, camera: data.camera };
        let progress = self.terminal.progress(&format!("data, {split}"), episodes as u64);
        let dataset = record(self.task, &request, &|| progress.advance())?;
        progress.finish();
        Ok(dataset.write(self.layout.data(&split.to_string()))?)
    }

    /// What a training leaves.
    fn leaves(&self, learner: Learner) -> [PathBuf; 2] {
        [self.layout.checkpoint(learner), self.layout.picture(&learner.name("training"))]
    }

    fn train(&self, learner: Learner) -> anyhow::Result<()> {
        let demonstrations = Dataset::read(self.layout.data("train"))?;
        let validation = self.validation()?;
        let training = Training {
            config: self.config,
            demonstrations: &demonstrations,
            validation: validation.as_ref(),
            out: &self.layout.checkpoint(learner),
            resume: self.resume(),
        };
        training.run(learner, self.terminal)?;
        self.draw_training(learner)
    }

    fn pairs(&self, reflow: &ReflowConfig, round: usize) -> anyhow::Result<()> {
        let data = DatasetFile::read(self.layout.data("train"))?;
        let (flow, checkpoint) = (round + 1, self.layout.checkpoint(Learner::Flow(round)));
        let round =
            Round { config: self.config, reflow, number: round, checkpoint: &checkpoint, data: &data };
        round.make_pairs(&self.layout.pairs(flow), self.terminal).map(drop)
    }

    fn reflow(&self, reflow: &ReflowConfig, round: usize) -> anyhow::Result<()> {
        let data = DatasetFile::read(self.layout.data("train"))?;
        let (flow, checkpoint) = (round + 1, self.layout.checkpoint(Learner::Flow(round)));
        let pairs = PairSet::read(self.layout.pairs(flow))?;
        let validation = self.validation()?;
        let round =
            Round { config: self.config, reflow, number: round, checkpoint: &checkpoint, data: &data };
        let out = self.layout.checkpoint(Learner::Flow(flow));
        round.train(&pairs, validation.as_ref(), &out, self.resume(), self.terminal)?;
        self.draw_training(Learner::Flow(flow))
    }

    fn validation(&self) -> anyhow::Result<Option<Dataset>> {
        let watch = self.config.data.validation_episodes > 0;
        Ok(watch.then(|| Dataset::read(self.layout.data("validation"))).transpose()?)
    }

    fn resume(&self) -> Resume {
        if self.fresh { Resume::Never } else { Resume::IfSame }
    }

    fn draw_training(&self, learner: Learner) -> anyhow::Result<()> {
        let metrics = std::fs::read_to_string(self.layout.metrics(learner))?;
        let curves = [("loss", curve(&metrics, "loss")), ("D_geo, validation", curve(&metrics, "d_geo"))];
        let title = format!("{}: {}", self.config.name, learner.name("training"));
        self.draw(&learner.name("training"), &training_curve(&title, &curves))
    }

    fn eval(&self, learner: Learner) -> anyhow::Result<()> {
        let section = &self.config.eval;
        // The references integrate nothing: noise levels are visited one by one, and a regressor answers at once.
        let (steps, solver) = match learner {
            Learner::Flow(_) => (section.steps.clone(), section.solver),
            Learner::Baseline => (section.steps.clone(), SolverChoice::default()),
            Learner::Regressor => (vec![1], SolverChoice::default()),
        };
        let inputs = EvalInputs {
            checkpoint: self.layout.checkpoint(learner),
            data: self.layout.data("test"),
            train_data: Some(self.layout.data("train")),
            steps,
            solver,
            unimodal_d_geo: section.unimodal_d_geo,
            seeds: section.seeds,
            device: self.config.device,
        };
        let report = evaluate(&inputs, &inputs.load()?, self.terminal)?;
        OutputFile::claim(&self.layout.eval(learner))?.write_json(&report)?;
        self.draw_scores(&report, learner)
    }

    fn draw_scores(&self, report: &EvalReport, learner: Learner) -> anyhow::Result<()> {
        let title = format!(
            "{}: {} held-out episodes, {} noise seeds",
            learner.name(&self.config.name),
            report.episodes,
            report.seeds.len()
        );
        let trivial: Vec<PredictorCurve<'_>> =
            report.trivial.iter().flat_map(PredictorCurve::trivial).collect();
        let rows: Vec<_> = report.rows.iter().map(|row| (row.steps, &row.scores)).collect();
        self.draw(&learner.name("d_geo_steps"), &d_geo_against_steps(&title, &rows, &trivial))?;
        // The curves in between lie on top of one another.
        let ends: Vec<_> = rows.first().into_iter().chain(rows.last().filter(|_| rows.len() > 1)).collect();
        let labels: Vec<String> = ends.iter().map(|(steps, _)| format!("policy, steps: {steps}")).collect();
        let policy = labels.iter().zip(&ends).map(|(label, (_, scores))| PredictorCurve { label, scores });
        self.draw(
            &learner.name("per_action"),
            &per_action_error(&title, &policy.collect::<Vec<_>>(), &trivial),
        )
    }

    fn rollout(&self) -> anyhow::Result<()> {
        let section = &self.config.rollout;
        let checkpoint = self.layout.checkpoint(Learner::Flow(self.config.flows()));
        let mut policy = LearnedPolicy::load(&checkpoint, self.config.device)?;
        let solver = section.solver.with_steps(section.steps);
        let request = RolloutRequest {
            split: Split::Test,
            seed: self.config.data.seed,
            episodes: section.episodes,
            observation_horizon: policy.sampler().observation_horizon(),
            n_action_steps: section.n_action_steps,
            disturb: section.disturb,
        };
        let pictures = PictureBook::new("learned policy", &self.task.spec());
        let log = OutputFile::claim(&self.layout.log())?;
        let mut witness = Witness::default()
            .with_log(log.path(), section.log_episodes)?
            .with_pictures(pictures, section.picture_episodes);
        let progress = self.terminal.progress("rollouts", section.episodes as u64);
        let mut actor = Actor::Learned(policy.acting(solver));
        let results = run_episodes(self.task, &request, &mut actor, &mut witness, &|| progress.advance())?;
        progress.finish();
        if let Some(pictures) = witness.finish()? {
            OutputFile::claim(&self.layout.picture("episodes"))?.write(&pictures.png()?)?;
        }
        let provenance = Provenance::gather(&format!("{:?}", self.config.device).to_lowercase());
        let name = checkpoint.display().to_string();
        let (task, split) = (&self.config.task, Split::Test.to_string());
        let report = RolloutReport::new(&name, Some(&solver), task, &split, &request, &results, provenance)
            .of_checkpoint(&checkpoint)
            .under_camera(self.config.data.camera);
        OutputFile::claim(&self.layout.rollout())?.write_json(&report)
    }

    fn draw(&self, name: &str, plot: &LinePlot) -> anyhow::Result<()> {
        OutputFile::claim(&self.layout.picture(name))?.write(&encode_png(&plot.draw()?, name)?)
    }
}

/// The points (`update`, `key`) of the lines that hold both.
fn curve(json_lines: &str, key: &str) -> Vec<(f64, f64)> {
    let point = |line: &str| -> Option<(f64, f64)> {
        let line: Value = serde_json::from_str(line).ok()?;
        Some((line.get("update")?.as_f64()?, line.get(key)?.as_f64()?))
    };
    json_lines.lines().filter_map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_are_read_from_the_lines_that_hold_them() {
        let lines = "{\"update\": 1, \"loss\": 2.5}\n{\"update\": 1, \"d_geo\": 0.5}\nhalf a li";
        assert_eq!(curve(lines, "loss"), [(1.0, 2.5)]);
        assert_eq!(curve(lines, "d_geo"), [(1.0, 0.5)]);
        assert!(curve(lines, "other").is_empty());
    }
}
