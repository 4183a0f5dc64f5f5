//! A report's figures for machines: the file `results.json`, from which README.md has its table and its picture.

use serde::{Deserialize, Serialize};

use super::gather::{Eval, Run};
use super::study::learner_title;
use crate::config::PlanChoice;
use crate::evaluation::StepRow;
use crate::learners::Learner;
use crate::metrics::Scores;
use crate::provenance::Provenance;
use crate::rollouts::RolloutReport;

/// The whole file: runs in the report's order. Every number has six digits that count.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Results {
    pub(super) runs: Vec<RunResult>,
}

/// A run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RunResult {
    pub(super) name: String,
    pub(super) task: String,
    /// What sets an ablation apart from the main method.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) variant: Option<String>,
    /// Training demonstrations; `null` where nothing says.
    pub(super) demonstrations: Option<usize>,
    /// The seed of Flow 1's training; `null` where nothing says.
    pub(super) training_seed: Option<u64>,
    /// Whether its scenes have two experts, so that the distance to one of them says little.
    pub(super) two_experts: bool,
    pub(super) made_with: Option<MadeWith>,
    /// What timed single plans, where that is something else than what scored the run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) timed_with: Option<MadeWith>,
    /// D̄_geo of the demonstration whose scene is most alike, on the test split.
    pub(super) nearest_demonstration: Option<ErrorResult>,
    /// Among how many demonstrations, where these are others than were learned from: shipped policies come without theirs, and
    /// disturbed ones are left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) nearest_among: Option<usize>,
    pub(super) policies: Vec<PolicyResult>,
    pub(super) rollouts: Vec<RolloutResult>,
}

/// What scored a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MadeWith {
    pub(super) version: String,
    pub(super) commit: Option<String>,
    pub(super) device: String,
    pub(super) processor: Option<String>,
    pub(super) threads: usize,
}

/// A policy on recorded episodes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PolicyResult {
    /// `Flow 1`, `Flow 2`, `ET-SEED` or `regressor`.
    pub(super) policy: String,
    pub(super) split: String,
    /// Held-out episodes.
    pub(super) episodes: usize,
    /// How many noise seeds.
    pub(super) noise_seeds: usize,
    pub(super) first_noise_seed: Option<u64>,
    pub(super) steps: Vec<StepResult>,
}

/// A policy with one number of integration steps.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StepResult {
    pub(super) steps: usize,
    pub(super) solver: String,
    pub(super) error: ErrorResult,
    /// Milliseconds of one call for one scene, where it was timed.
    pub(super) call_ms: Option<CallMillis>,
    /// D̄_geo to the nearer of two experts, where there are two.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) d_geo_nearer: Option<f64>,
    /// The share of samples that are far from both.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) share_between: Option<f64>,
    /// The shares of samples that are nearer to the one and to the other.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) share_per_mode: Option<[f64; 2]>,
    /// The energy distance between the samples and the two experts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) energy_distance: Option<f64>,
}

/// D̄_geo and its parts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ErrorResult {
    pub(super) d_geo_mean: f64,
    /// The standard deviation over noise seeds.
    pub(super) d_geo_std: Option<f64>,
    /// The 95 % bootstrap interval over episodes.
    pub(super) d_geo_low: Option<f64>,
    pub(super) d_geo_high: Option<f64>,
    pub(super) rotation_rad: f64,
    pub(super) translation_mm: f64,
}

/// The time of a call.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CallMillis {
    pub(super) p50: f64,
    pub(super) p99: f64,
}

/// A policy acting in the simulator.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RolloutResult {
    pub(super) policy: String,
    pub(super) split: String,
    pub(super) steps: Option<usize>,
    /// Actions carried out of each plan of ten.
    pub(super) actions_a_plan: usize,
    #[serde(default)]
    pub(super) plan_choice: PlanChoice,
    pub(super) disturbed: bool,
    pub(super) episodes: usize,
    pub(super) successes: usize,
    /// Wilson's 95 % interval for the share of successes.
    pub(super) success_low: f64,
    pub(super) success_high: f64,
}

impl Results {
    /// What runs of a report say.
    pub(super) fn of<'a>(runs: impl Iterator<Item = &'a Run>) -> Self {
        Self { runs: runs.map(RunResult::of).collect() }
    }

    /// Puts the runs of `newer` where runs of the same names stand, and the others at the end.
    #[cfg(test)]
    pub(super) fn take(&mut self, newer: Self) {
        for run in newer.runs {
            match self.runs.iter_mut().find(|old| old.name == run.name) {
                Some(old) => *old = run,
                None => self.runs.push(run),
            }
        }
    }
}

impl RunResult {
    fn of(run: &Run) -> Self {
        let trivial = run.evals.iter().find(|eval| eval.split == "test" && eval.report.trivial.is_some());
        let trivial = trivial.and_then(|eval| eval.report.trivial.as_ref());
        let among = trivial.map(|trivial| trivial.training_episodes);
        let acting = run.acting.iter();
        let made_with = run.provenance().map(MadeWith::of);
        Self {
            name: run.name.clone(),
            task: run.task.clone(),
            variant: run.variant.clone(),
            demonstrations: run.demonstrations,
            training_seed: run.training_seed,
            two_experts: run.has_modes(),
            timed_with: run
                .timed_with
                .as_ref()
                .map(MadeWith::of)
                .filter(|with| made_with.as_ref() != Some(with)),
            made_with,
            nearest_demonstration: trivial.map(|trivial| ErrorResult::of(&trivial.nearest_demonstration)),
            nearest_among: among.filter(|_| among != run.demonstrations),
            policies: run.evals.iter().map(PolicyResult::of).collect(),
            rollouts: acting.map(|acting| RolloutResult::of(acting.learner, &acting.report)).collect(),
        }
    }

    /// The scores of a policy on the test split.
    pub(super) fn on_test(&self, learner: Learner) -> Option<&PolicyResult> {
        let title = learner_title(learner);
        self.policies.iter().find(|policy| policy.policy == title && policy.split == "test")
    }
}

impl MadeWith {
    fn of(provenance: &Provenance) -> Self {
        let Provenance { version, commit, device, processor, threads, .. } = provenance.clone();
        Self { version, commit, device, processor, threads }
    }
}

impl PolicyResult {
    fn of(eval: &Eval) -> Self {
        Self {
            policy: learner_title(eval.learner),
            split: eval.split.clone(),
            episodes: eval.report.episodes,
            noise_seeds: eval.report.seeds.len(),
            first_noise_seed: eval.report.seeds.first().copied(),
            steps: eval.report.rows.iter().map(StepResult::of).collect(),
        }
    }

    /// The row with the fewest steps.
    pub(super) fn fewest(&self) -> Option<&StepResult> {
        self.steps.iter().min_by_key(|row| row.steps)
    }

    /// The row with the most steps.
    pub(super) fn most(&self) -> Option<&StepResult> {
        self.steps.iter().max_by_key(|row| row.steps)
    }
}

impl StepResult {
    fn of(row: &StepRow) -> Self {
        let call = row.latency.as_ref().map(|latency| &latency.whole_ms);
        Self {
            steps: row.steps,
            solver: row.solver.clone(),
            error: ErrorResult::of(&row.scores),
            call_ms: call.map(|call| CallMillis { p50: rounded(call.p50), p99: rounded(call.p99) }),
            d_geo_nearer: row.modes.as_ref().map(|modes| rounded(modes.d_geo_nearer)),
            share_between: row.modes.as_ref().map(|modes| rounded(modes.share_between)),
            share_per_mode: row.modes.as_ref().map(|modes| modes.share_per_mode.map(rounded)),
            energy_distance: row.modes.as_ref().and_then(|modes| modes.energy_distance).map(rounded),
        }
    }
}

impl ErrorResult {
    fn of(scores: &Scores) -> Self {
        Self {
            d_geo_mean: rounded(scores.d_geo_mean),
            d_geo_std: scores.d_geo_std.map(rounded),
            d_geo_low: scores.d_geo_low.map(rounded),
            d_geo_high: scores.d_geo_high.map(rounded),
            rotation_rad: rounded(scores.rotation_rad),
            translation_mm: rounded(1e3 * scores.translation_m),
        }
    }
}

impl RolloutResult {
    fn of(learner: Learner, report: &RolloutReport) -> Self {
        Self {
            policy: learner_title(learner),
            split: report.split.clone(),
            steps: report.steps,
            actions_a_plan: report.n_action_steps,
            plan_choice: report.plan_choice,
            disturbed: report.disturbed,
            episodes: report.episodes,
            successes: report.successes,
            success_low: rounded(report.success_low),
            success_high: rounded(report.success_high),
        }
    }
}

/// Six digits that count: what a file can hold and give back unchanged.
fn rounded(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_six_digits_and_survive_the_file() {
        for value in [1.882_206_218e-6, 0.014_603_098_493, 72.594_449_9, 0.0, 1.0, -3.0e10] {
            let short = rounded(value);
            assert!((short - value).abs() <= 5.1e-6 * value.abs(), "{value} became {short}");
            let text = serde_json::to_string(&short).unwrap();
            assert_eq!(serde_json::from_str::<f64>(&text).unwrap(), short, "{text}");
        }
    }
}
