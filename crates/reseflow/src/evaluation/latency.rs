//! How long single plans take: one scene, one noise seed, as when acting.

use reseflow_data::{Dataset, ObservationHistory};
use reseflow_train::Solver;

use super::PlanLatency;
use crate::learning::LearnedPolicy;
use crate::rollouts::{FIRST_SEED, LatencyMillis};

/// Plans before the first one that counts.
const WARM_UP: usize = 3;
/// Evaluations of the network to spend, at the least [`FEWEST_PLANS`] plans and at most [`MOST_PLANS`].
const EVALUATIONS: usize = 600;
const FEWEST_PLANS: usize = 20;
const MOST_PLANS: usize = 200;

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
