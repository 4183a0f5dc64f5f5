//! Demonstrations: the expert's episodes, many at a time, the same bytes for any number of threads.

use rayon::prelude::*;
use reseflow_data::{
    Episode, EpisodeKey, IgnoreEvents, Policy, RolloutConfig, RolloutRecord, Scene, Split, Task, rollout,
};

use crate::error::SimError;

/// What to generate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GenerateRequest {
    /// The split.
    pub split: Split,
    /// The user's seed.
    pub seed: u64,
    /// Episodes E.
    pub episodes: usize,
    /// Threads; `None` uses every core. The result does not depend on it.
    pub threads: Option<usize>,
    /// How often the expert may fail at one episode before that is a fault.
    pub max_attempts: u32,
}

impl GenerateRequest {
    /// E episodes of a split, on every core.
    pub fn new(split: Split, seed: u64, episodes: usize) -> Self {
        Self { split, seed, episodes, threads: None, max_attempts: 20 }
    }
}

/// The expert's successful episodes.
#[derive(Debug, Clone, PartialEq)]
pub struct Generated {
    /// The episodes, in the order of their indices.
    pub episodes: Vec<Episode>,
    /// The key that each episode's scene was drawn from; `seed`, `index` and `attempt` are its seeds.
    pub keys: Vec<EpisodeKey>,
    /// Attempts at which the expert failed; their scenes are not among the episodes.
    pub attempts_dropped: u64,
}

/// Lets the expert act until `request.episodes` episodes have succeeded.
///
/// `progress` is called once for each finished episode, from any thread.
///
/// # Errors
/// A scene that cannot be set up, an expert that fails `max_attempts` times in a row, or threads that do not start.
pub fn generate(
    task: &dyn Task,
    request: &GenerateRequest,
    progress: &(dyn Fn() + Sync),
) -> Result<Generated, SimError> {
    let threads = request.threads.unwrap_or(0);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|source| SimError::Threads { threads, reason: source.to_string() })?;
    let drawn: Vec<(EpisodeKey, Episode)> = pool.install(|| {
        (0..request.episodes as u64)
            .into_par_iter()
            .map(|index| {
                let episode = demonstrate(task, request, index)?;
                progress();
                Ok(episode)
            })
            .collect::<Result<_, SimError>>()
    })?;
    let attempts_dropped = drawn.iter().map(|(key, _)| u64::from(key.attempt)).sum();
    let (keys, episodes) = drawn.into_iter().unzip();
    Ok(Generated { episodes, keys, attempts_dropped })
}

/// The first attempt at one episode at which the expert succeeds.
fn demonstrate(
    task: &dyn Task,
    request: &GenerateRequest,
    index: u64,
) -> Result<(EpisodeKey, Episode), SimError> {
    let name = task.spec().name;
    for attempt in 0..request.max_attempts {
        let key = EpisodeKey { task: name.clone(), split: request.split, seed: request.seed, index, attempt };
        let mut scene = task.reset(&key)?;
        let mut expert = scene.expert();
        let alternative = scene.alternative();
        let record = run_open_loop(task, scene.as_mut(), expert.as_mut())?;
        if record.outcome.success {
            return Ok((key, Episode { alternative, ..record.episode }));
        }
    }
    let attempts = request.max_attempts;
    Err(SimError::TooManyFailures { task: name, index, attempts, allowed: attempts })
}

/// Lets `policy` plan once and act to the end.
fn run_open_loop(
    task: &dyn Task,
    scene: &mut dyn Scene,
    policy: &mut dyn Policy,
) -> Result<RolloutRecord, SimError> {
    let spec = task.spec();
    let config = RolloutConfig {
        observation_horizon: 1,
        n_action_steps: spec.action_steps,
        disturb_before: None,
        policy_seed: 0,
    };
    Ok(rollout(scene, &spec, policy, &config, &mut IgnoreEvents)?)
}
