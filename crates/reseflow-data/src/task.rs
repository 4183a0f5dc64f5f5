//! The task trait: what a simulator offers to everyone above it.

use serde::{Deserialize, Serialize};

use crate::{EpisodeKey, Scene};

/// What is fixed about a task, whatever the episode.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TaskSpec {
    /// The registered name, as on the command line.
    pub name: String,
    /// One sentence on what is to be done and when it counts as done.
    pub description: String,
    /// Points per cloud, N.
    pub points: usize,
    /// Action steps per episode, T.
    pub action_steps: usize,
    /// Control ticks per action step.
    pub ticks_per_action: usize,
    /// Length of one control tick, nanoseconds.
    pub tick_nanos: i64,
    /// The action step before which a disturbance matters most: later ones find the work done, or the object held.
    pub disturb_before: usize,
}

/// Why a scene could not be set up.
#[derive(Debug, thiserror::Error)]
#[error("cannot set up {task} episode {index}: {reason}")]
pub struct TaskError {
    /// The task's name.
    pub task: String,
    /// The episode's index.
    pub index: u64,
    /// What was expected and what was got.
    pub reason: String,
}

/// A family of scenes with a goal.
pub trait Task: Send + Sync {
    /// What is fixed about the task.
    fn spec(&self) -> TaskSpec;

    /// Builds the scene that `key` names. The same key gives the same scene, bit for bit.
    ///
    /// # Errors
    /// When no valid scene can be drawn for this key.
    fn reset(&self, key: &EpisodeKey) -> Result<Box<dyn Scene>, TaskError>;
}
