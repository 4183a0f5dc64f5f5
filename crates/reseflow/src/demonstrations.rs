//! Demonstrations: recording the expert's, and replaying stored ones open loop.

use std::path::Path;

use reseflow_data::{Dataset, DatasetMeta, Split, Task};
use reseflow_sim::{CameraSettings, GenerateRequest, SimError, generate};
use serde::Serialize;

use crate::config::PlanChoice;
use crate::error::bad_input;
use crate::metrics::wilson_interval;
use crate::rollouts::{Actor, RolloutRequest, Script, Witness, run_episodes};

/// Which demonstrations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DemonstrationRequest {
    /// The split.
    pub split: Split,
    /// The user's seed.
    pub seed: u64,
    /// Episodes E.
    pub episodes: usize,
    /// The share of them whose scene is disturbed meanwhile.
    pub disturbed_share: f64,
    /// The camera that the task has, for `meta`.
    pub camera: CameraSettings,
}

/// How many stored episodes succeed when their actions are played again.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ReplayCheck {
    /// Episodes replayed.
    pub episodes: usize,
    /// How many succeeded.
    pub successes: usize,
    /// The lower end of Wilson's 95 % interval.
    pub success_low: f64,
    /// The upper end.
    pub success_high: f64,
}

/// Lets the expert demonstrate the task.
///
/// # Errors
/// When the simulator cannot set up a scene, the expert keeps failing, or the task has no disturbed demonstrations.
pub fn record(
    task: &dyn Task,
    request: &DemonstrationRequest,
    progress: &(dyn Fn() + Sync),
) -> anyhow::Result<Dataset> {
    let wanted = GenerateRequest {
        disturbed_share: request.disturbed_share,
        ..GenerateRequest::new(request.split, request.seed, request.episodes)
    };
    let generated = generate(task, &wanted, progress).map_err(|fault| match fault {
        SimError::Setting { .. } => bad_input(fault.to_string()),
        fault => fault.into(),
    })?;
    let spec = task.spec();
    let mut meta = DatasetMeta {
        task: spec.name.clone(),
        split: Some(request.split),
        seeds: generated.keys,
        attempts_dropped: generated.attempts_dropped,
        engine: format!("rapier3d (reseflow-sim {})", env!("CARGO_PKG_VERSION")),
        config: serde_json::to_value(&spec)?,
        ..DatasetMeta::default()
    };
    if request.disturbed_share > 0.0 {
        meta.extra.insert("disturbed_share".to_owned(), request.disturbed_share.into());
    }
    if !request.camera.is_default() {
        meta.extra.insert("camera".to_owned(), serde_json::to_value(request.camera)?);
    }
    Ok(Dataset { episodes: generated.episodes, meta: Some(meta) })
}

/// Plays the actions of the first `episodes` episodes stored in `file` again, in the scenes that they were recorded in.
///
/// # Errors
/// Bad input when the file cannot be read or does not say which scenes its episodes were recorded in.
pub fn replay(
    task: &dyn Task,
    file: &Path,
    episodes: usize,
    witness: &mut Witness,
    progress: &(dyn Fn() + Sync),
) -> anyhow::Result<ReplayCheck> {
    let dataset = Dataset::read(file)?;
    let keys = dataset.meta.as_ref().map(|meta| meta.seeds.as_slice()).unwrap_or_default();
    if keys.len() < episodes || dataset.len() < episodes {
        let place = file.display();
        return Err(bad_input(format!(
            "{place}: expected {episodes} episodes with their `seeds` in `meta`, got {}",
            keys.len()
        )));
    }
    let request = RolloutRequest {
        split: keys.first().map_or(Split::Train, |key| key.split),
        seed: keys.first().map_or(0, |key| key.seed),
        episodes,
        observation_horizon: 1,
        n_action_steps: dataset.steps(),
        plan_choice: PlanChoice::Newest,
        disturb: false,
    };
    let results = run_episodes(
        task,
        &request,
        &mut Actor::Scripted(Script::Replay { keys, episodes: &dataset.episodes }),
        witness,
        progress,
    )?;
    let successes = results.iter().filter(|result| result.outcome.success).count();
    let interval = wilson_interval(successes, episodes);
    Ok(ReplayCheck { episodes, successes, success_low: interval.low, success_high: interval.high })
}
