//! Policies that need no network: a list of commands, and standing still.

use reseflow_data::{Action, ActionChunk, ObservationHistory, Plan, Policy, PolicyError};

/// Plays a fixed list of commands, one per action step: an expert, or the replay of a stored episode.
#[derive(Debug, Clone)]
pub struct Scripted {
    name: String,
    actions: Vec<Action>,
}

impl Scripted {
    /// The policy named `name` that commands `actions[s]` at action step `s`, and the last of them ever after.
    pub fn new(name: impl Into<String>, actions: Vec<Action>) -> Self {
        Self { name: name.into(), actions }
    }
}

impl Policy for Scripted {
    fn name(&self) -> &str {
        &self.name
    }

    fn reset(&mut self, _seed: u64) {}

    fn plan(&mut self, history: &ObservationHistory) -> Result<Plan, PolicyError> {
        let Some(last) = self.actions.last() else {
            return Err(PolicyError { policy: self.name.clone(), reason: "it holds no action".to_owned() });
        };
        let rest = self.actions.get(history.elapsed_steps()..).unwrap_or_default();
        let actions = if rest.is_empty() { vec![*last] } else { rest.to_vec() };
        Ok(Plan { actions: ActionChunk(actions), uncertainty: None })
    }
}

/// Commands the gripper to stay where it is: the null policy, which must solve nothing.
#[derive(Debug, Clone, Copy, Default)]
pub struct Still;

impl Policy for Still {
    fn name(&self) -> &str {
        "still"
    }

    fn reset(&mut self, _seed: u64) {}

    fn plan(&mut self, history: &ObservationHistory) -> Result<Plan, PolicyError> {
        let now = history.latest();
        let stay = Action { world_from_gripper: now.world_from_gripper, opening: now.gripper_opening };
        Ok(Plan { actions: ActionChunk(vec![stay]), uncertainty: None })
    }
}
