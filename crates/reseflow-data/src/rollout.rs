//! The loop that lets a policy act in a scene: observe, plan, act, observe again.

use crate::{
    Action, Episode, Halt, Observation, ObservationHistory, Outcome, Plan, Policy, PolicyError, Scene,
    TaskSpec, Tick,
};

/// How a policy is run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RolloutConfig {
    /// Observation frames O that the policy is shown.
    pub observation_horizon: usize,
    /// Actions executed before the policy plans again.
    pub n_action_steps: usize,
    /// The last action step before which the scene is disturbed, if it is; before the task's own step
    /// ([`TaskSpec::disturb_before`]) where that comes first.
    pub disturb_before: Option<usize>,
    /// Names the policy's random stream.
    pub policy_seed: u64,
}

/// Hears what happens during a rollout; for logs and pictures. Every method has an empty default.
pub trait EpisodeObserver {
    /// A frame was handed to the history, at the start of action step `step`.
    fn on_observation(&mut self, _step: usize, _observation: &Observation, _scene: &dyn Scene) {}
    /// The policy planned at action step `step`.
    fn on_plan(&mut self, _step: usize, _plan: &Plan) {}
    /// A control tick has passed.
    fn on_tick(&mut self, _tick: &Tick, _scene: &mut dyn Scene) {}
    /// The episode was judged.
    fn on_outcome(&mut self, _outcome: &Outcome) {}
}

/// An observer that does nothing.
pub struct IgnoreEvents;

impl EpisodeObserver for IgnoreEvents {}

/// What a rollout leaves behind.
#[derive(Debug, Clone)]
pub struct RolloutRecord {
    /// Frames and executed commands; shorter than T steps where the episode was halted.
    pub episode: Episode,
    /// How it ended.
    pub outcome: Outcome,
    /// Wall-clock seconds of each call to the policy.
    pub plan_secs: Vec<f64>,
}

/// Runs `policy` in `scene` until the task's last action step or a halt, then judges.
///
/// Between action steps the command moves along the screw geodesic, one control tick at a time. The first segment starts at the
/// gripper's reached pose.
///
/// # Errors
/// When the policy cannot plan. A halt is no error: it ends the episode and is in the outcome.
pub fn rollout(
    scene: &mut dyn Scene,
    spec: &TaskSpec,
    policy: &mut dyn Policy,
    config: &RolloutConfig,
    observer: &mut dyn EpisodeObserver,
) -> Result<RolloutRecord, PolicyError> {
    policy.reset(config.policy_seed);
    let first = scene.observe();
    let mut command = Action { world_from_gripper: first.world_from_gripper, opening: first.gripper_opening };
    let mut history = ObservationHistory::new(first, config.observation_horizon);
    let mut episode =
        Episode { observations: Vec::new(), actions: Vec::new(), alternative: None, disturbance: None };
    let mut plan_secs = Vec::new();
    let mut pending: std::collections::VecDeque<Action> = Default::default();
    let mut halt = None;
    let disturb_before = config.disturb_before.map(|latest| latest.min(spec.disturb_before));

    for step in 0..spec.action_steps {
        if disturb_before == Some(step) {
            scene.disturb(config.policy_seed);
        }
        if step > 0 {
            history.push(scene.observe());
        }
        observer.on_observation(step, history.latest(), scene);
        if pending.is_empty() {
            let started = std::time::Instant::now();
            let plan = policy.plan(&history)?;
            plan_secs.push(started.elapsed().as_secs_f64());
            observer.on_plan(step, &plan);
            pending.extend(plan.actions.iter().take(config.n_action_steps.max(1)));
        }
        let Some(target) = pending.pop_front() else {
            return Err(PolicyError {
                policy: policy.name().to_owned(),
                reason: "its plan holds no action".to_owned(),
            });
        };
        episode.observations.push(history.latest().clone());
        episode.actions.push(target);
        if let Err(reason) = follow(scene, spec, &command, &target, observer) {
            halt = Some(reason);
            break;
        }
        command = target;
    }

    let mut outcome = scene.judge();
    if halt.is_some() {
        outcome.success = false;
        outcome.halt = halt;
    }
    observer.on_outcome(&outcome);
    Ok(RolloutRecord { episode, outcome, plan_secs })
}

/// Moves the command from `start` to `target` over one action step.
fn follow(
    scene: &mut dyn Scene,
    spec: &TaskSpec,
    start: &Action,
    target: &Action,
    observer: &mut dyn EpisodeObserver,
) -> Result<(), Halt> {
    let finite = target.opening.is_finite() && target.world_from_gripper.is_finite();
    if !finite {
        return Err(Halt::NonFiniteAction);
    }
    for tick in 1..=spec.ticks_per_action {
        // The last command is the recorded action to the last bit.
        let command = if tick == spec.ticks_per_action {
            *target
        } else {
            start.interpolate(target, tick as f64 / spec.ticks_per_action as f64)
        };
        let report = scene.tick(&command)?;
        observer.on_tick(&report, scene);
    }
    Ok(())
}
