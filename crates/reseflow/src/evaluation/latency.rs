//! How long single plans take: one scene, one noise seed, as when acting.

use std::path::Path;

use anyhow::Context;
use reseflow_data::{Dataset, ObservationHistory};
use reseflow_train::{DeviceKind, Solver, WEIGHTS};
use serde::{Deserialize, Serialize};

use crate::learning::LearnedPolicy;
use crate::output::Table;
use crate::provenance::{Provenance, content_hash};
use crate::rollouts::{FIRST_SEED, LatencyMillis};

/// Plans before the first one that counts.
const WARM_UP: usize = 3;
/// Evaluations of the network to spend, at the least [`FEWEST_PLANS`] plans and at most [`MOST_PLANS`].
const EVALUATIONS: usize = 600;
const FEWEST_PLANS: usize = 20;
const MOST_PLANS: usize = 200;

/// The wall-clock time of single plans, graph building included.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlanLatency {
    /// Graph and encoder, once an observation; of a flow or regressor.
    pub encoder_ms: Option<LatencyMillis>,
    /// Noise and all steps.
    pub decoder_ms: Option<LatencyMillis>,
    /// All of it.
    pub whole_ms: LatencyMillis,
}

/// What a policy's plans take with one number of steps.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LatencyRow {
    /// The policy: its folder, or in a run `flow1`, `flow2`, …, `etseed` or `regressor`.
    pub policy: String,
    /// Integration steps; of the baseline, noise levels visited.
    pub steps: usize,
    /// The solver.
    pub solver: String,
    /// The content hash of the policy's weights, so that nobody takes these times for another's.
    pub weights: String,
    /// The times.
    #[serde(flatten)]
    pub latency: PlanLatency,
}

/// The result of timing, of `reseflow bench` and of a run.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct LatencyReport {
    /// The folder of the run, or the policy.
    pub of: String,
    /// One row for each policy and number of steps.
    pub rows: Vec<LatencyRow>,
    /// Where the figures come from.
    pub provenance: Provenance,
}

impl LatencyReport {
    /// Nothing yet, on `device`.
    pub fn new(of: &str, device: DeviceKind) -> Self {
        Self { of: of.to_owned(), rows: Vec::new(), provenance: Provenance::gather(device.name()) }
    }

    /// The figures as a table.
    pub fn table(&self) -> Table {
        let mut table =
            Table::figures(["ms", "steps", "calls", "encoder", "decoder", "median", "p95", "p99", "slowest"]);
        for LatencyRow { policy, steps, latency, .. } in &self.rows {
            let PlanLatency { encoder_ms, decoder_ms, whole_ms } = latency;
            let median = |part: &Option<LatencyMillis>| {
                part.as_ref().map_or_else(|| "–".to_owned(), |part| format!("{:.2}", part.p50))
            };
            let LatencyMillis { calls, p50, p95, p99, max } = whole_ms;
            table.row([
                policy.clone(),
                steps.to_string(),
                calls.to_string(),
                median(encoder_ms),
                median(decoder_ms),
                format!("{p50:.2}"),
                format!("{p95:.2}"),
                format!("{p99:.2}"),
                format!("{max:.2}"),
            ]);
        }
        table
    }
}

/// Times plans of `policy`, called `name` and loaded from `checkpoint`, with each of the `solvers`.
///
/// # Errors
/// When the data or a solver does not fit the policy.
pub fn time_plans(
    name: &str,
    checkpoint: &Path,
    policy: &LearnedPolicy,
    dataset: &Dataset,
    solvers: &[Solver],
) -> anyhow::Result<Vec<LatencyRow>> {
    let mut rows = Vec::with_capacity(solvers.len());
    let Some(first) = dataset.episodes.first() else { return Ok(rows) };
    let history = ObservationHistory::at_step(&first.observations, 0, policy.sampler().observation_horizon());
    let weights =
        content_hash(&checkpoint.join(WEIGHTS)).with_context(|| checkpoint.display().to_string())?;
    for solver in solvers {
        let drawn = policy.sampler().sample(std::slice::from_ref(&history), &[FIRST_SEED], solver)?;
        if let Some(latency) = plan_latency(policy, dataset, solver, drawn.evaluations)? {
            let (steps, solver) = (drawn.steps, solver.name().to_owned());
            let (policy, weights) = (name.to_owned(), weights.clone());
            rows.push(LatencyRow { policy, steps, solver, weights, latency });
        }
    }
    Ok(rows)
}

/// Times plans with `solver`, which takes so many `evaluations` each, from the episodes' first observations one after another.
///
/// # Errors
/// When the data does not fit the policy.
pub(super) fn plan_latency(
    policy: &LearnedPolicy,
    dataset: &Dataset,
    solver: &Solver,
    evaluations: usize,
) -> anyhow::Result<Option<PlanLatency>> {
    let horizon = policy.sampler().observation_horizon();
    let plans = (EVALUATIONS / evaluations.max(1)).clamp(FEWEST_PLANS, MOST_PLANS);
    let (mut encoder, mut decoder, mut whole) = (Vec::new(), Vec::new(), Vec::new());
    let scenes = dataset.episodes.iter().cycle().take(WARM_UP + plans);
    for (place, episode) in scenes.enumerate() {
        let history = ObservationHistory::at_step(&episode.observations, 0, horizon);
        let (parts, secs) = policy.time_plan(&history, FIRST_SEED, solver)?;
        if place >= WARM_UP {
            whole.push(secs);
            encoder.extend(parts.map(|parts| parts.encoder_secs));
            decoder.extend(parts.map(|parts| parts.decoder_secs));
        }
    }
    let whole = LatencyMillis::of(&whole);
    Ok(whole.map(|whole_ms| PlanLatency {
        encoder_ms: LatencyMillis::of(&encoder),
        decoder_ms: LatencyMillis::of(&decoder),
        whole_ms,
    }))
}
