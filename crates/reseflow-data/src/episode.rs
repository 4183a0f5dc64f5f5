//! One recorded demonstration.

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
}
