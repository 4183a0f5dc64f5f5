//! Running E episodes of a task with one policy.

use rayon::prelude::*;
use reseflow_data::{
    Episode, EpisodeKey, EpisodeObserver, IgnoreEvents, Outcome, Policy, RolloutConfig, Scene, Split, Task,
    TaskError, TaskSpec, rollout,
};
use reseflow_sim::{Scripted, Still, disturbance_seed};

use super::plan_choice::Chooser;
use super::{FIRST_SEED, Witness};
use crate::config::PlanChoice;

/// How often a scene may be drawn anew where a key gives none.
const MAX_DRAWS: u32 = 20;

/// Who acts.
pub enum Actor<'a> {
    /// Somebody who needs no network; episodes then run in parallel.
    Scripted(Script<'a>),
    /// A learned policy.
    Learned(&'a mut dyn Policy),
}

/// Who acts without a network.
pub enum Script<'a> {
    /// The scene's own expert.
    Expert,
    /// Nobody: the gripper stays where it is.
    Still,
    /// The stored actions of episode `i`, open loop, in the scene that `keys[i]` names, disturbed again where it was.
    Replay {
        /// Which scenes.
        keys: &'a [EpisodeKey],
        /// What was recorded in each.
        episodes: &'a [Episode],
    },
}

/// Which episodes, and how.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RolloutRequest {
    /// The split.
    pub split: Split,
    /// The user's seed.
    pub seed: u64,
    /// Episodes E.
    pub episodes: usize,
    /// Observation frames O.
    pub observation_horizon: usize,
    /// Actions executed before the policy plans again.
    pub n_action_steps: usize,
    /// Which of the plans that a learned policy has made is carried out.
    pub plan_choice: PlanChoice,
    /// Whether each episode is disturbed, before the action step that the task names.
    pub disturb: bool,
}

/// How one episode went.
#[derive(Debug, Clone)]
pub struct EpisodeResult {
    /// The scene's key.
    pub key: EpisodeKey,
    /// The policy's noise seed.
    pub policy_seed: u64,
    /// How it ended.
    pub outcome: Outcome,
    /// Action steps executed.
    pub steps: usize,
    /// Wall-clock seconds of each call to the policy.
    pub plan_secs: Vec<f64>,
}

/// Runs the episodes; the result is in the order of their indices and does not depend on the number of threads.
///
/// `progress` is called once for each finished episode, from any thread.
///
/// # Errors
/// A scene that cannot be set up or a policy that cannot plan.
pub fn run_episodes(
    task: &dyn Task,
    request: &RolloutRequest,
    actor: &mut Actor<'_>,
    witness: &mut Witness,
    progress: &(dyn Fn() + Sync),
) -> anyhow::Result<Vec<EpisodeResult>> {
    let runner = Runner { task, spec: task.spec(), request, progress };
    let watched = witness.episodes().min(request.episodes);
    match actor {
        Actor::Learned(policy) => (0..request.episodes)
            .map(|index| {
                let (key, mut scene) = runner.draw(index)?;
                let observer: &mut dyn EpisodeObserver =
                    if index < watched { witness } else { &mut IgnoreEvents };
                let mut policy = Chooser::new(*policy, request.plan_choice, request.n_action_steps);
                runner.run(key, scene.as_mut(), &mut policy, &runner.config(index), observer)
            })
            .collect(),
        Actor::Scripted(script) => {
            let script: &Script<'_> = script;
            let mut results = Vec::with_capacity(request.episodes);
            for index in 0..watched {
                results.push(runner.run_scripted(index, script, witness)?);
            }
            let unwatched: anyhow::Result<Vec<EpisodeResult>> = (watched..request.episodes)
                .into_par_iter()
                .map(|index| runner.run_scripted(index, script, &mut IgnoreEvents))
                .collect();
            results.extend(unwatched?);
            Ok(results)
        }
    }
}

struct Runner<'a> {
    task: &'a dyn Task,
    spec: TaskSpec,
    request: &'a RolloutRequest,
    progress: &'a (dyn Fn() + Sync),
}

impl Runner<'_> {
    /// The scene of episode `index`.
    fn draw(&self, index: usize) -> Result<(EpisodeKey, Box<dyn Scene>), TaskError> {
        let RolloutRequest { split, seed, .. } = *self.request;
        let mut key =
            EpisodeKey { task: self.spec.name.clone(), split, seed, index: index as u64, attempt: 0 };
        loop {
            match self.task.reset(&key) {
                Ok(scene) => return Ok((key, scene)),
                Err(_) if key.attempt + 1 < MAX_DRAWS => key.attempt += 1,
                Err(fault) => return Err(fault),
            }
        }
    }

    fn run_scripted(
        &self,
        index: usize,
        script: &Script<'_>,
        observer: &mut dyn EpisodeObserver,
    ) -> anyhow::Result<EpisodeResult> {
        if let Script::Replay { keys, episodes } = script {
            let (key, episode) = (keys[index].clone(), &episodes[index]);
            let mut scene = self.task.reset(&key)?;
            let mut replay = Scripted::new("replay", episode.actions.clone());
            let config = RolloutConfig {
                disturb_before: episode.disturbance.map(|disturbance| disturbance.before),
                policy_seed: disturbance_seed(&key),
                ..self.config(index)
            };
            return self.run(key, scene.as_mut(), &mut replay, &config, observer);
        }
        let (key, mut scene) = self.draw(index)?;
        match script {
            Script::Expert => {
                let mut expert = scene.expert();
                self.run(key, scene.as_mut(), expert.as_mut(), &self.config(index), observer)
            }
            _ => self.run(key, scene.as_mut(), &mut Still, &self.config(index), observer),
        }
    }

    /// How episode `index` is run.
    fn config(&self, index: usize) -> RolloutConfig {
        RolloutConfig {
            observation_horizon: self.request.observation_horizon,
            n_action_steps: self.request.n_action_steps,
            disturb_before: self.request.disturb.then_some(self.spec.disturb_before),
            policy_seed: FIRST_SEED + index as u64,
        }
    }

    fn run(
        &self,
        key: EpisodeKey,
        scene: &mut dyn Scene,
        policy: &mut dyn Policy,
        config: &RolloutConfig,
        observer: &mut dyn EpisodeObserver,
    ) -> anyhow::Result<EpisodeResult> {
        let record = rollout(scene, &self.spec, policy, config, observer)?;
        (self.progress)();
        Ok(EpisodeResult {
            key,
            policy_seed: config.policy_seed,
            outcome: record.outcome,
            steps: record.episode.actions.len(),
            plan_secs: record.plan_secs,
        })
    }
}
