//! What can go wrong in training and in loading what was trained.

use std::path::PathBuf;

/// A fault of a configuration, a checkpoint or a training run.
#[derive(Debug, thiserror::Error)]
pub enum TrainError {
    /// A configuration value outside its range.
    #[error("train config: {0}")]
    Config(String),
    /// The network refused its input.
    #[error(transparent)]
    Net(#[from] reseflow_net::NetError),
    /// The flow refused its input.
    #[error(transparent)]
    Flow(#[from] reseflow_flow::FlowError),
    /// A file cannot be read or written.
    #[error("{path}: {source}")]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The operating system's reason.
        source: std::io::Error,
    },
    /// A checkpoint that is not whole.
    #[error("{path}: {fault}")]
    Checkpoint {
        /// The file.
        path: PathBuf,
        /// What is wrong and what was expected.
        fault: String,
    },
    /// The loss stopped being a number.
    #[error("the loss of update {update} is not finite")]
    Diverged {
        /// The update, from 1.
        update: usize,
    },
    /// There is nothing to learn from.
    #[error("the data set holds no episode")]
    NoData,
    /// An episode without a target.
    #[error("episode {index} holds no action, expected at least one")]
    NoActions {
        /// The episode.
        index: usize,
    },
    /// A worker thread panicked.
    #[error("a training thread stopped unexpectedly")]
    Worker,
}
