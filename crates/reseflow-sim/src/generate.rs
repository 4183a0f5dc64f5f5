//! Demonstrations: the expert's episodes, many at a time, the same bytes for any number of threads.

use rayon::prelude::*;
use reseflow_data::{Episode, EpisodeKey, IgnoreEvents, RolloutConfig, Split, Task, rollout};

use crate::disturbed::Shove;
use crate::error::{SimError, expect};

/// What to generate.
#[derive(Debug, Clone, Copy, PartialEq)]
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
    /// The share of episodes, from 0 to 1, whose scene is disturbed meanwhile, so that they show how to begin anew.
    pub disturbed_share: f64,
}

impl GenerateRequest {
    /// E episodes of a split, on every core, undisturbed.
    pub fn new(split: Split, seed: u64, episodes: usize) -> Self {
        Self { split, seed, episodes, threads: None, max_attempts: 20, disturbed_share: 0.0 }
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
/// A scene that cannot be set up, an expert that fails `max_attempts` times in a row, a share that is none or one of disturbed
/// episodes where there are two experts, or threads that do not start.
pub fn generate(
    task: &dyn Task,
    request: &GenerateRequest,
    progress: &(dyn Fn() + Sync),
) -> Result<Generated, SimError> {
    let share = request.disturbed_share;
    expect((0.0..=1.0).contains(&share), "disturbed_share", share, "a share from 0 to 1")?;
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
    let spec = task.spec();
    let name = &spec.name;
    for attempt in 0..request.max_attempts {
        let key = EpisodeKey { task: name.clone(), split: request.split, seed: request.seed, index, attempt };
        let mut scene = task.reset(&key)?;
        let mut expert = scene.expert();
        let alternative = scene.alternative();
        if alternative.is_some() && request.disturbed_share > 0.0 {
            let share = request.disturbed_share.to_string();
            let expected = format!("0 for {name}: what its other expert would do then is not known");
            return Err(SimError::Setting { key: "disturbed_share", got: share, expected });
        }
        let shove = Shove::draw(&key, request.disturbed_share, &spec);
        let config = match &shove {
            Some(shove) => shove.rollout(),
            None => RolloutConfig {
                observation_horizon: 1,
                n_action_steps: spec.action_steps,
                disturb_before: None,
                policy_seed: 0,
            },
        };
        let record = rollout(scene.as_mut(), &spec, expert.as_mut(), &config, &mut IgnoreEvents)?;
        if record.outcome.success {
            let disturbance = shove.map(|shove| shove.disturbance);
            return Ok((key, Episode { alternative, disturbance, ..record.episode }));
        }
    }
    let attempts = request.max_attempts;
    Err(SimError::TooManyFailures { task: name.clone(), index, attempts, allowed: attempts })
}
