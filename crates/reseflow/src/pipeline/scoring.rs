//! The stages that score a run's policies on recorded episodes.

use std::path::PathBuf;

use reseflow_data::Dataset;
use serde_json::{Value, json};

use super::stages::Context;
use super::summary::read;
use crate::config::{EvalConfig, EvalSplit, SamplersConfig, SolverChoice};
use crate::evaluation::{EvalInputs, EvalReport, SamplersReport, compare_samplers, compare_turned, evaluate};
use crate::learners::Learner;
use crate::learning::load_flow;
use crate::output::OutputFile;
use crate::plot::{PredictorCurve, d_geo_against_steps, per_action_error};

impl Context<'_> {
    /// What a scoring of `learner` on `split` depends on beside the policy and the data.
    pub(super) fn eval_inputs(&self, learner: Learner, split: EvalSplit) -> Value {
        let section = &self.config.eval;
        let (steps, solver) = eval_solver(section, learner, split);
        json!([
            steps,
            section.seeds,
            solver,
            section.unimodal_d_geo,
            (learner == Learner::Baseline).then_some(section.baseline_episodes),
            self.config.device
        ])
    }

    /// What a scoring leaves.
    pub(super) fn scores(&self, learner: Learner, split: EvalSplit) -> Vec<PathBuf> {
        let mut leaves = vec![self.layout.eval(learner, split)];
        if split == EvalSplit::Test {
            leaves.extend(PICTURES.map(|name| self.layout.picture(&learner.name(name))));
        }
        leaves
    }

    /// Scores a policy.
    pub(super) fn eval(&self, learner: Learner, split: EvalSplit) -> anyhow::Result<()> {
        let section = &self.config.eval;
        let (steps, solver) = eval_solver(section, learner, split);
        let inputs = EvalInputs {
            checkpoint: self.layout.checkpoint(learner),
            data: self.layout.data(split.name()),
            episodes: section.baseline_episodes.filter(|_| learner == Learner::Baseline),
            train_data: Some(self.layout.data("train")),
            steps,
            solver,
            unimodal_d_geo: section.unimodal_d_geo,
            seeds: section.seeds,
            device: self.config.device,
        };
        let loaded = inputs.load()?;
        let mut report = evaluate(&inputs, &loaded, self.terminal)?;
        if split == EvalSplit::Turned {
            let on_test: EvalReport = read(&self.layout.eval(learner, EvalSplit::Test))?;
            let test = self.layout.data(EvalSplit::Test.name());
            report.turned = Some(compare_turned(&inputs, &loaded, &report, &test, &on_test)?);
        }
        OutputFile::claim(&self.layout.eval(learner, split))?.write_json(&report)?;
        if split == EvalSplit::Test { self.draw_scores(&report, learner) } else { Ok(()) }
    }

    /// Compares solvers on Flow 1 and on the last flow.
    pub(super) fn compare_samplers(&self, config: &SamplersConfig) -> anyhow::Result<()> {
        let mut test = Dataset::read(self.layout.data(EvalSplit::Test.name()))?;
        test.episodes.truncate(config.episodes);
        let mut report = SamplersReport::new(config, test.len(), self.config.device.name());
        for flow in self.compared_flows() {
            let policy = load_flow(&self.layout.checkpoint(Learner::Flow(flow)), self.config.device)?;
            report.flows.push(compare_samplers(&policy, flow, &test, config, self.terminal)?);
        }
        OutputFile::claim(&self.layout.samplers())?.write_json(&report)
    }

    /// The flows that solvers are compared on.
    pub(super) fn compared_flows(&self) -> Vec<usize> {
        let last = self.config.flows();
        if last == 1 { vec![1] } else { vec![1, last] }
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
        let [over_steps, per_action] = PICTURES.map(|name| learner.name(name));
        self.draw(&over_steps, &d_geo_against_steps(&title, &rows, &trivial))?;
        // The curves in between lie on top of one another.
        let ends: Vec<_> = rows.first().into_iter().chain(rows.last().filter(|_| rows.len() > 1)).collect();
        let labels: Vec<String> = ends.iter().map(|(steps, _)| format!("policy, steps: {steps}")).collect();
        let policy = labels.iter().zip(&ends).map(|(label, (_, scores))| PredictorCurve { label, scores });
        self.draw(&per_action, &per_action_error(&title, &policy.collect::<Vec<_>>(), &trivial))
    }
}

/// In how many steps a policy is scored on a split, and how: the references integrate nothing, as noise levels are visited one by one and a
/// regressor answers at once.
pub(super) fn eval_solver(
    section: &EvalConfig,
    learner: Learner,
    split: EvalSplit,
) -> (Vec<usize>, SolverChoice) {
    let steps = section.steps_on(split).to_vec();
    match learner {
        Learner::Flow(_) => (steps, section.solver),
        Learner::Baseline => (steps, SolverChoice::default()),
        Learner::Regressor => (vec![1], SolverChoice::default()),
    }
}

/// The pictures of a scoring on the test split.
const PICTURES: [&str; 2] = ["d_geo_steps", "per_action"];
