//! Helpers of the integration tests: keys, rollouts, digests.

use std::hash::{DefaultHasher, Hash, Hasher};

use reseflow_data::{
    EpisodeKey, EpisodeObserver, IgnoreEvents, Policy, RolloutConfig, RolloutRecord, Split, Task, rollout,
};

/// The key of attempt 0.
pub(crate) fn key(task: &str, split: Split, seed: u64, index: u64) -> EpisodeKey {
    EpisodeKey { task: task.to_owned(), split, seed, index, attempt: 0 }
}

/// Plans once and acts to the end; `None` lets the expert act.
pub(crate) fn run_observed(
    task: &dyn Task,
    key: &EpisodeKey,
    policy: Option<&mut dyn Policy>,
    disturb_before: Option<usize>,
    observer: &mut dyn EpisodeObserver,
) -> RolloutRecord {
    let spec = task.spec();
    let mut scene = task.reset(key).unwrap();
    let mut expert = scene.expert();
    let config = RolloutConfig {
        observation_horizon: 1,
        n_action_steps: spec.action_steps,
        disturb_before,
        policy_seed: 11,
    };
    rollout(scene.as_mut(), &spec, policy.unwrap_or(expert.as_mut()), &config, observer).unwrap()
}

/// As [`run_observed`], undisturbed, with nobody watching.
pub(crate) fn run(task: &dyn Task, key: &EpisodeKey, policy: Option<&mut dyn Policy>) -> RolloutRecord {
    run_observed(task, key, policy, None, &mut IgnoreEvents)
}

/// A digest of a value's exact content (numbers print so that they read back exactly).
pub(crate) fn digest(value: &impl std::fmt::Debug) -> u64 {
    let mut hasher = DefaultHasher::new();
    format!("{value:?}").hash(&mut hasher);
    hasher.finish()
}
