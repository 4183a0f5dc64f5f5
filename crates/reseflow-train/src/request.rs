//! What a training is asked for.

use std::path::Path;

use reseflow_data::Dataset;

use crate::{DeviceKind, ModelConfig, TrainConfig};

/// What to train, on what, from where, and where the checkpoint goes.
#[derive(Debug, Clone, Copy)]
pub struct TrainRequest<'a> {
    /// The network and the flow.
    pub model: &'a ModelConfig,
    /// The optimisation.
    pub train: &'a TrainConfig,
    /// The episodes to learn from.
    pub demonstrations: &'a Dataset,
    /// Held-out episodes, scored during training.
    pub validation: Option<&'a Dataset>,
    /// The checkpoint whose averaged weights training starts from; without one they are drawn.
    pub start: Option<&'a Path>,
    /// Where to compute.
    pub device: DeviceKind,
    /// The checkpoint's folder.
    pub out: &'a Path,
}
