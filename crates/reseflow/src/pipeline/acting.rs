//! The stages in which a run's policies act in the simulator.

use std::path::PathBuf;

use reseflow_data::Split;
use serde_json::{Value, json};

use super::stages::Context;
use crate::config::{ExperimentConfig, PlanChoice, RolloutVariant, SolverChoice};
use crate::learners::Learner;
use crate::learning::LearnedPolicy;
use crate::output::OutputFile;
use crate::provenance::Provenance;
use crate::rollouts::{Actor, PictureBook, RolloutReport, RolloutRequest, Witness, run_episodes};

/// A series of rollouts: who acts, and in which way.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RolloutSeries {
    /// The stage's name, and that of its result.
    pub name: String,
    /// What a summary calls it.
    pub title: String,
    /// Who.
    pub learner: Learner,
    /// In which way.
    pub variant: RolloutVariant,
    /// Whether it is logged and pictured.
    pub witnessed: bool,
}

impl RolloutSeries {
    /// Every series that `config` asks for: the last flow in each way, then, in the first way, those beside it.
    pub fn all(config: &ExperimentConfig) -> Vec<Self> {
        let last = Learner::Flow(config.flows());
        let mut series = Vec::new();
        for (place, variant) in config.rollout.variants.iter().copied().enumerate() {
            let name = match place {
                0 => "rollout".to_owned(),
                _ => format!("rollout-{}", variant.name()),
            };
            let title = variant.title().to_owned();
            series.push(Self { name, title, learner: last, variant, witnessed: place == 0 });
        }
        let beside = config.rollout.variants.first().filter(|_| config.rollout.beside);
        if let Some(variant) = beside.copied() {
            let first = Some(Learner::Flow(1)).filter(|first| *first != last);
            for learner in first.into_iter().chain(Learner::references(config)) {
                let (name, title) = match learner {
                    Learner::Flow(flow) => (format!("rollout-flow{flow}"), format!("Flow {flow}")),
                    Learner::Baseline => ("rollout-baseline".to_owned(), "baseline".to_owned()),
                    Learner::Regressor => ("rollout-regressor".to_owned(), "regressor".to_owned()),
                };
                series.push(Self { name, title, learner, variant, witnessed: false });
            }
        }
        series
    }
}

impl Context<'_> {
    /// What a series of rollouts depends on beside the policy.
    pub(super) fn rollout_inputs(&self, series: &RolloutSeries) -> Value {
        let section = &self.config.rollout;
        json!([
            self.config.task,
            self.config.data.seed,
            self.config.data.camera,
            section.episodes,
            self.rollout_solver(series.learner),
            section.n_action_steps,
            section.plan_choice,
            series.variant,
            series.witnessed.then_some([section.log_episodes, section.picture_episodes]),
            self.config.device
        ])
    }

    /// What a series of rollouts leaves.
    pub(super) fn rollout_leaves(&self, series: &RolloutSeries) -> Vec<PathBuf> {
        let mut leaves = vec![self.layout.rollout(series)];
        if series.witnessed {
            leaves.extend([self.layout.log(), self.layout.picture("episodes")]);
        }
        leaves
    }

    /// Lets a policy act.
    pub(super) fn rollout(&self, series: &RolloutSeries) -> anyhow::Result<()> {
        let section = &self.config.rollout;
        let checkpoint = self.layout.checkpoint(series.learner);
        let mut policy = LearnedPolicy::load(&checkpoint, self.config.device)?;
        let (choice, steps) = self.rollout_solver(series.learner);
        let solver = choice.with_steps(steps);
        let request = RolloutRequest {
            split: Split::Test,
            seed: self.config.data.seed,
            episodes: section.episodes,
            observation_horizon: policy.sampler().observation_horizon(),
            n_action_steps: match series.variant {
                RolloutVariant::OpenLoop => self.task.spec().action_steps,
                RolloutVariant::Replan | RolloutVariant::Disturbed => section.n_action_steps,
            },
            plan_choice: match series.variant {
                // There is one plan.
                RolloutVariant::OpenLoop => PlanChoice::Newest,
                RolloutVariant::Replan | RolloutVariant::Disturbed => section.plan_choice,
            },
            disturb: series.variant == RolloutVariant::Disturbed,
        };
        let mut witness = Witness::default();
        if series.witnessed {
            let log = OutputFile::claim(&self.layout.log())?;
            let pictures = PictureBook::new("learned policy", &self.task.spec());
            witness = witness
                .with_log(log.path(), section.log_episodes)?
                .with_pictures(pictures, section.picture_episodes);
        }
        let progress = self.terminal.progress(&series.name, section.episodes as u64);
        let mut actor = Actor::Learned(policy.acting(solver));
        let results = run_episodes(self.task, &request, &mut actor, &mut witness, &|| progress.advance())?;
        progress.finish();
        if let Some(pictures) = witness.finish()? {
            OutputFile::claim(&self.layout.picture("episodes"))?.write(&pictures.png()?)?;
        }
        let provenance = Provenance::gather(self.config.device.name());
        let name = checkpoint.display().to_string();
        let (task, split) = (&self.config.task, Split::Test.to_string());
        let report = RolloutReport::new(&name, Some(&solver), task, &split, &request, &results, provenance)
            .of_checkpoint(&checkpoint)
            .under_camera(self.config.data.camera);
        OutputFile::claim(&self.layout.rollout(series))?.write_json(&report)
    }

    /// How a policy plans when it acts, and in how many steps: the references integrate nothing.
    fn rollout_solver(&self, learner: Learner) -> (SolverChoice, usize) {
        let section = &self.config.rollout;
        match learner {
            Learner::Flow(_) => (section.solver, section.steps),
            Learner::Baseline => {
                let levels = self.config.baseline.as_ref().map_or(1, |baseline| baseline.diffusion.steps);
                (SolverChoice::default(), section.baseline_steps.min(levels))
            }
            Learner::Regressor => (SolverChoice::default(), 1),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use reseflow_train::{BaselineConfig, ReflowConfig};

    #[test]
    fn the_last_flow_acts_in_every_way_and_those_beside_it_in_the_first() {
        let mut config = ExperimentConfig {
            reflow: Some(ReflowConfig::default()),
            baseline: Some(BaselineConfig::default()),
            regressor: true,
            ..ExperimentConfig::default()
        };
        let names = |config: &ExperimentConfig| {
            let all = RolloutSeries::all(config).into_iter();
            all.map(|series| (series.name, series.learner, series.variant)).collect::<Vec<_>>()
        };
        let (last, replan) = (Learner::Flow(2), RolloutVariant::Replan);
        assert_eq!(names(&config), [("rollout".to_owned(), last, replan)]);
        config.rollout.variants = vec![replan, RolloutVariant::Disturbed];
        config.rollout.beside = true;
        let expected = [
            ("rollout", last, replan),
            ("rollout-disturbed", last, RolloutVariant::Disturbed),
            ("rollout-flow1", Learner::Flow(1), replan),
            ("rollout-baseline", Learner::Baseline, replan),
            ("rollout-regressor", Learner::Regressor, replan),
        ];
        assert_eq!(names(&config), expected.map(|(name, who, how)| (name.to_owned(), who, how)));
        let witnessed = RolloutSeries::all(&config).iter().filter(|series| series.witnessed).count();
        assert_eq!(witnessed, 1, "one log, one picture");
        config.reflow = None;
        assert!(names(&config).iter().all(|(name, ..)| name != "rollout-flow1"), "Flow 1 is the last");
    }
}
