//! What a series of rollouts amounts to.

use std::collections::BTreeMap;
use std::path::Path;

use reseflow_sim::CameraSettings;
use reseflow_train::Solver;
use serde::{Deserialize, Serialize};

use super::{EpisodeResult, RolloutRequest};
use crate::config::PlanChoice;
use crate::evaluation::checkpoint_config;
use crate::metrics::{mean, quantile, wilson_interval};
use crate::output::Table;
use crate::provenance::Provenance;

/// Wall-clock milliseconds of a call to the policy.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LatencyMillis {
    /// Calls measured.
    pub calls: usize,
    /// The median.
    pub p50: f64,
    /// The 95th percentile.
    pub p95: f64,
    /// The 99th percentile.
    pub p99: f64,
    /// The slowest call.
    pub max: f64,
}

impl LatencyMillis {
    /// Of calls that took so many seconds each; `None` for no call.
    pub fn of(secs: &[f64]) -> Option<Self> {
        let millis: Vec<f64> = secs.iter().map(|secs| 1e3 * secs).collect();
        let at = |q| quantile(&millis, q);
        Some(Self { calls: millis.len(), p50: at(0.5)?, p95: at(0.95)?, p99: at(0.99)?, max: at(1.0)? })
    }
}

/// One episode in a report.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EpisodeLine {
    /// The episode's index under the seed.
    pub index: u64,
    /// How many earlier draws of its scene were dropped.
    pub attempt: u32,
    /// The policy's noise seed.
    pub policy_seed: u64,
    /// Whether the task's criterion holds.
    pub success: bool,
    /// The number that the criterion is about.
    pub measure: f64,
    /// Why it ended early, if it did.
    pub halt: Option<String>,
    /// Action steps executed.
    pub steps: usize,
}

/// The result file of `reseflow rollout`.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct RolloutReport {
    /// Episodes run.
    pub episodes: usize,
    /// How many succeeded.
    pub successes: usize,
    /// Their share.
    pub success_rate: f64,
    /// The lower end of Wilson's 95 % interval for it.
    pub success_low: f64,
    /// The upper end.
    pub success_high: f64,
    /// How often an episode ended early, by reason.
    pub halts: BTreeMap<String, usize>,
    /// What `measure` is, with its unit.
    pub measure_name: String,
    /// Its mean over the episodes.
    pub measure_mean: f64,
    /// Wall-clock time of the policy's calls.
    pub plan_latency_ms: Option<LatencyMillis>,
    /// Who acted.
    pub policy: String,
    /// The task.
    pub task: String,
    /// The split.
    pub split: String,
    /// The seed of the scenes.
    pub seed: u64,
    /// Integration steps; `null` for policies that take none or choose them themselves.
    pub steps: Option<usize>,
    /// How the flow was integrated; `null` for policies that are none.
    #[serde(default)]
    pub solver: Option<String>,
    /// Actions executed before the policy planned again.
    pub n_action_steps: usize,
    /// Which of its plans was carried out.
    #[serde(default)]
    pub plan_choice: PlanChoice,
    /// Whether the object was pushed in mid-episode.
    pub disturbed: bool,
    /// The settings of the camera, where they are not the task's own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub camera: Option<CameraSettings>,
    /// Each episode.
    pub outcomes: Vec<EpisodeLine>,
    /// The checkpoint's whole configuration: its task, its model and how it was trained; `null` where nothing was learned.
    #[serde(default)]
    pub config: serde_json::Value,
    /// Where the figures come from.
    pub provenance: Provenance,
}

impl RolloutReport {
    /// Sums up `results`.
    pub fn new(
        policy: &str,
        solver: Option<&Solver>,
        task: &str,
        split: &str,
        request: &RolloutRequest,
        results: &[EpisodeResult],
        provenance: Provenance,
    ) -> Self {
        let successes = results.iter().filter(|result| result.outcome.success).count();
        let interval = wilson_interval(successes, results.len());
        let mut halts = BTreeMap::new();
        for halt in results.iter().filter_map(|result| result.outcome.halt) {
            *halts.entry(halt.to_string()).or_insert(0) += 1;
        }
        let plan_secs: Vec<f64> = results.iter().flat_map(|result| &result.plan_secs).copied().collect();
        let measures: Vec<f64> = results.iter().map(|result| result.outcome.measure).collect();
        Self {
            episodes: results.len(),
            successes,
            success_rate: successes as f64 / results.len().max(1) as f64,
            success_low: interval.low,
            success_high: interval.high,
            halts,
            measure_name: results
                .first()
                .map(|result| result.outcome.measure_name.clone())
                .unwrap_or_default(),
            measure_mean: mean(&measures).unwrap_or_default(),
            plan_latency_ms: LatencyMillis::of(&plan_secs),
            policy: policy.to_owned(),
            task: task.to_owned(),
            split: split.to_owned(),
            seed: request.seed,
            steps: solver.and_then(uniform_steps),
            solver: solver.map(|solver| solver.name().to_owned()),
            n_action_steps: request.n_action_steps,
            plan_choice: request.plan_choice,
            disturbed: request.disturb,
            camera: None,
            outcomes: results.iter().map(EpisodeLine::of).collect(),
            config: serde_json::Value::Null,
            provenance,
        }
    }

    /// With the configuration that lies in the checkpoint's folder.
    pub fn of_checkpoint(mut self, checkpoint: &Path) -> Self {
        self.config = checkpoint_config(checkpoint);
        self
    }

    /// With the camera that the task had.
    pub fn under_camera(mut self, camera: CameraSettings) -> Self {
        self.camera = (!camera.is_default()).then_some(camera);
        self
    }

    /// The figures as a table.
    pub fn table(&self) -> Table {
        let mut table =
            Table::facts("rollout", &format!("{} on {} ({})", self.policy, self.task, self.split));
        table.fact("successes", format!("{} of {}", self.successes, self.episodes));
        let [rate, low, high] = [self.success_rate, self.success_low, self.success_high]
            .map(|share| format!("{:.1} %", 100.0 * share));
        table.fact("rate (95 %, Wilson)", format!("{rate} ({low} to {high})"));
        table.fact(&format!("mean {}", self.measure_name), format!("{:.3}", self.measure_mean));
        for (halt, count) in &self.halts {
            table.fact(&format!("ended early: {halt}"), count);
        }
        if let Some(LatencyMillis { p50, p95, p99, calls, .. }) = &self.plan_latency_ms {
            let text = format!("{p50:.2} / {p95:.2} / {p99:.2} ms ({calls} calls)");
            table.fact("plan latency p50 / p95 / p99", text);
        }
        table
    }
}

/// The steps of a solver that takes as many as it is told to.
fn uniform_steps(solver: &Solver) -> Option<usize> {
    match *solver {
        Solver::Euler { steps }
        | Solver::Midpoint { steps }
        | Solver::Heun { steps }
        | Solver::Rk4 { steps } => Some(steps),
        Solver::DormandPrince(_) => None,
    }
}

impl EpisodeLine {
    fn of(result: &EpisodeResult) -> Self {
        Self {
            index: result.key.index,
            attempt: result.key.attempt,
            policy_seed: result.policy_seed,
            success: result.outcome.success,
            measure: result.outcome.measure,
            halt: result.outcome.halt.map(|halt| halt.to_string()),
            steps: result.steps,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use reseflow_data::{EpisodeKey, Halt, Outcome, Split};

    #[test]
    fn counts_successes_halts_and_time() {
        let request = RolloutRequest {
            split: Split::Test,
            seed: 1,
            episodes: 4,
            observation_horizon: 2,
            n_action_steps: 3,
            plan_choice: PlanChoice::Newest,
            disturb: false,
        };
        let result = |index: u64, success: bool, halt| EpisodeResult {
            key: EpisodeKey { task: "t".to_owned(), split: Split::Test, seed: 1, index, attempt: 0 },
            policy_seed: index,
            outcome: Outcome { success, measure: index as f64, measure_name: "turned_rad".to_owned(), halt },
            steps: 10,
            plan_secs: vec![0.001 * (index + 1) as f64],
        };
        let results = [
            result(0, true, None),
            result(1, true, None),
            result(2, false, Some(Halt::OutOfReach)),
            result(3, true, None),
        ];
        let solver = Solver::Rk4 { steps: 4 };
        let report = RolloutReport::new(
            "p",
            Some(&solver),
            "t",
            "test",
            &request,
            &results,
            Provenance::gather("cpu"),
        );
        assert_eq!((report.steps, report.solver.as_deref()), (Some(4), Some("rk4")));
        assert_eq!((report.episodes, report.successes, report.success_rate), (4, 3, 0.75));
        assert!(report.success_low < 0.75 && report.success_high > 0.75);
        assert_eq!(report.halts.values().sum::<usize>(), 1);
        assert_eq!(report.measure_mean, 1.5);
        let latency = report.plan_latency_ms.clone().unwrap();
        assert!((latency.p50 - 2.5).abs() < 1e-9 && (latency.max - 4.0).abs() < 1e-9);
        let json = serde_json::to_value(&report).unwrap();
        for key in ["episodes", "successes", "success_low", "success_high", "outcomes", "halts"] {
            assert!(json.get(key).is_some(), "{key}");
        }
        assert!(report.table().to_string().contains("3 of 4"));
    }
}
