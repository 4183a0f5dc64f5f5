//! What can go wrong around the simulator, said in one sentence.

use reseflow_data::{PolicyError, TaskError};

/// A fault in making episodes. A halted or failed episode is no fault: it is an outcome.
#[derive(Debug, thiserror::Error)]
pub enum SimError {
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
