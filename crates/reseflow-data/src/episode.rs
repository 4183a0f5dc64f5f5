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
}
