//! Disturbed demonstrations: when the shove comes, and how often the expert looks, drawn from the episode's key.

use rand::RngExt;
use reseflow_data::{Disturbance, EpisodeKey, RolloutConfig, TaskSpec};

/// The expert plans again after at most so many actions.
const LONGEST_PLAN: usize = 3;

/// A shove during a demonstration, and what is done about it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Shove {
    pub(crate) disturbance: Disturbance,
    n_action_steps: usize,
    seed: u64,
}

impl Shove {
    /// What befalls the episode of `key`; `None` where it is left alone.
    ///
    /// The shove comes where the task says that it matters, and the expert notices after one to three actions, like the policies that
    /// will learn from it.
    pub(crate) fn draw(key: &EpisodeKey, share: f64, spec: &TaskSpec) -> Option<Self> {
        // An attempt that fails is made again with a shove, so that the share stays what was asked for.
        let mut rng = EpisodeKey { attempt: 0, ..key.clone() }.rng("disturbance");
        if rng.random::<f64>() >= share {
            return None;
        }
        let before = spec.disturb_before;
        let n_action_steps = rng.random_range(1..=LONGEST_PLAN);
        // What has just been pushed has not moved yet.
        let answered_from = (before / n_action_steps + 1) * n_action_steps;
        let answered_from = answered_from.min(spec.action_steps.saturating_sub(1));
        Some(Self {
            disturbance: Disturbance { before, answered_from },
            n_action_steps,
            seed: disturbance_seed(key),
        })
    }

    /// The rollout in which that happens.
    pub(crate) fn rollout(&self) -> RolloutConfig {
        RolloutConfig {
            observation_horizon: 1,
            n_action_steps: self.n_action_steps,
            disturb_before: Some(self.disturbance.before),
            policy_seed: self.seed,
        }
    }
}

/// The seed with which the scene of `key` is disturbed, if it is, while its demonstration is recorded: for replays.
pub fn disturbance_seed(key: &EpisodeKey) -> u64 {
    key.rng("disturbance seed").random()
}
