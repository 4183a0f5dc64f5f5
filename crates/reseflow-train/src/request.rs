//! What a training is asked for.

use std::path::Path;

use reseflow_data::Dataset;

use crate::{DeviceKind, Mixture, ModelConfig, TrainConfig};

/// What to train, on what, from where, and where the checkpoint goes.
#[derive(Debug)]
pub struct TrainRequest<'a, M = ModelConfig> {
    /// The network and what it is made of: a flow's [`ModelConfig`], or the baseline's [`crate::EtSeedConfig`].
    pub model: &'a M,
    /// The optimisation.
    pub train: &'a TrainConfig,
    /// The episodes to learn from.
    pub demonstrations: &'a Dataset,
    /// Pairs to learn from beside the demonstrations, for Flow 2.
    pub mixture: Option<&'a Mixture<'a>>,
    /// Held-out episodes, scored during training.
    pub validation: Option<&'a Dataset>,
    /// The checkpoint whose averaged weights training starts from; without one they are drawn.
    pub start: Option<&'a Path>,
    /// What becomes of the state that an interrupted training left.
    pub resume: Resume,
    /// Where to compute.
    pub device: DeviceKind,
    /// The checkpoint's folder.
    pub out: &'a Path,
}

/// What becomes of the state that an interrupted training left beside the checkpoint's folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Resume {
    /// Training starts anew; the state stays until the first one of its own replaces it.
    #[default]
    Never,
    /// Training goes on from it where it is whole and of the same training, and otherwise starts anew.
    IfSame,
    /// Training goes on from it; one that is damaged or of another training is an error. Where there is none, training starts.
    Always,
}
