//! What can go wrong around the simulator, said in one sentence.

use std::fmt::Display;

use reseflow_data::{PolicyError, TaskError};

/// A fault in making episodes. A halted or failed episode is no fault: it is an outcome.
#[derive(Debug, thiserror::Error)]
pub enum SimError {
    /// No task has that name.
    #[error("unknown task `{name}`, expected one of {}", crate::tasks().join(", "))]
    UnknownTask {
        /// The name asked for.
        name: String,
    },
    /// A setting of the world or the camera is out of its range.
    #[error("`{key}` is {got}, expected {expected}")]
    Setting {
        /// The setting.
        key: &'static str,
        /// Its value.
        got: String,
        /// Its range.
        expected: String,
    },
    /// A scene could not be set up.
    #[error(transparent)]
    Task(#[from] TaskError),
    /// The expert could not plan.
    #[error(transparent)]
    Policy(#[from] PolicyError),
    /// The expert failed at every attempt of one episode.
    #[error(
        "task {task}: the expert failed {attempts} times in a row at episode {index}, at most {allowed} are allowed"
    )]
    TooManyFailures {
        /// The task's name.
        task: String,
        /// The episode's index.
        index: u64,
        /// Attempts made.
        attempts: u32,
        /// Attempts allowed.
        allowed: u32,
    },
    /// A file of the stroke library is not as it must be.
    #[error("stroke file {file}: {reason}")]
    StrokeFile {
        /// The file's name.
        file: String,
        /// Which stroke, what was expected and what was got.
        reason: String,
    },
    /// The threads could not be started.
    #[error("cannot start {threads} threads: {reason}")]
    Threads {
        /// Threads asked for.
        threads: usize,
        /// The operating system's reason.
        reason: String,
    },
}

/// Checks one setting.
pub(crate) fn expect(
    holds: bool,
    key: &'static str,
    got: impl Display,
    expected: impl Into<String>,
) -> Result<(), SimError> {
    if holds {
        return Ok(());
    }
    Err(SimError::Setting { key, got: got.to_string(), expected: expected.into() })
}
