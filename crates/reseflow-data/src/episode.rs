//! One recorded demonstration.

use reseflow_lie::SE3;

use crate::{Action, Observation};

/// A recorded episode of T action steps.
///
/// `actions[s]` is the command in force at the end of action step `s`, given `observations[s]`, the frame at its start.
#[derive(Debug, Clone, PartialEq)]
pub struct Episode {
    /// The frame at the start of each action step, T of them.
    pub observations: Vec<Observation>,
    /// The command in force at the end of each action step, T of them.
    pub actions: Vec<Action>,
    /// The commanded poses of another expert, as good as this one, where the task leaves a choice: T of them, with the
    /// openings of `actions`.
    pub alternative: Option<Vec<SE3>>,
    /// How the scene was disturbed meanwhile, where it was.
    pub disturbance: Option<Disturbance>,
}

/// When a scene was disturbed, and since when the actions answer that.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Disturbance {
    /// The action step before which the scene was disturbed.
    pub before: usize,
    /// The first action step after it at which the expert planned: what it did until then does not suit what was to come.
    pub answered_from: usize,
}

impl Episode {
    /// The first action step from which on the actions suit what is seen: 0, or where a disturbance was answered.
    pub fn first_step(&self) -> usize {
        self.disturbance.map_or(0, |disturbance| disturbance.answered_from)
    }
}
