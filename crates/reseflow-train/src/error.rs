//! What can go wrong in training and in loading what was trained.

use std::path::PathBuf;

use reseflow_data::Window;

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
    /// A training's state that cannot be used or kept.
    #[error("{path}: {fault}")]
    State {
        /// The file or folder.
        path: PathBuf,
        /// What is wrong and what was expected.
        fault: String,
    },
    /// A file cannot be written whole.
    #[error(transparent)]
    Data(#[from] reseflow_data::DataError),
    /// The loss or its gradient stopped being a number.
    #[error("the {what} of update {update} is not finite: shard {shard} held (episode, step) {}", list(.windows))]
    Diverged {
        /// What is not finite.
        what: &'static str,
        /// The update, from 1.
        update: usize,
        /// The part of the batch, from 0.
        shard: usize,
        /// The windows in it.
        windows: Vec<Window>,
    },
    /// Something in a batch cannot be learned from.
    #[error("{fault}: shard {shard} of update {update} held (episode, step) {}", list(.windows))]
    Batch {
        /// What was refused.
        #[source]
        fault: Box<TrainError>,
        /// The update, from 1.
        update: usize,
        /// The part of the batch, from 0.
        shard: usize,
        /// The windows in it.
        windows: Vec<Window>,
    },
    /// There is nothing to learn from.
    #[error("the data set holds no episode")]
    NoData,
    /// An episode without a target.
    #[error(
        "episode {index} holds no action to learn, expected at least one, after a disturbance at least one that answers it"
    )]
    NoActions {
        /// The episode.
        index: usize,
    },
    /// An episode that cannot be compared with from its first step on.
    #[error("episode {index} was disturbed while it was recorded, expected episodes that were not")]
    Disturbed {
        /// The episode.
        index: usize,
    },
    /// Pairs that do not belong to the demonstrations or to the network.
    #[error("pairs: {0}")]
    Pairs(String),
    /// The validation episodes cannot be scored.
    #[error("validation episodes: {0}")]
    Validation(#[source] Box<TrainError>),
    /// A worker thread panicked.
    #[error("a training thread stopped unexpectedly")]
    Worker,
}

fn list(windows: &[Window]) -> String {
    let names: Vec<_> =
        windows.iter().map(|window| format!("({}, {})", window.episode, window.step)).collect();
    names.join(", ")
}
