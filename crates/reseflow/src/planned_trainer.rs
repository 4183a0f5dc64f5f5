//! The interface that the runner expects of `reseflow-train`, until that crate offers it. Nothing here trains or predicts: every
//! call refuses, so that no figure can come from it. Replace `crate::planned_trainer` by `reseflow_train` and delete this file.

use std::path::Path;

use reseflow_data::{ActionChunk, Dataset, ObservationHistory, Plan, Policy, PolicyError};
use serde::{Deserialize, Serialize};

/// The optimisation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TrainConfig {
    /// Optimiser updates.
    pub updates: usize,
    /// Windows an update.
    pub batch_size: usize,
}

impl Default for TrainConfig {
    fn default() -> Self {
        Self { updates: 2000, batch_size: 16 }
    }
}

/// The network and the flow.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ModelConfig {}

/// Why nothing was trained or predicted.
#[derive(Debug, thiserror::Error)]
#[error("this build has no trainer")]
pub struct TrainError;

/// Where to compute.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DeviceKind {
    /// The processor, with the fastest backend.
    #[default]
    Cpu,
    /// burn's flex backend.
    Flex,
    /// burn's ndarray backend.
    Ndarray,
}

/// How an update went.
#[derive(Debug, Clone, Copy)]
pub struct UpdateMetrics {
    /// The update, from 1.
    pub update: usize,
    /// The loss.
    pub loss: f64,
    /// Windows a second.
    pub samples_per_sec: f64,
}

/// How a validation went.
#[derive(Debug, Clone, Copy)]
pub struct ValidationMetrics {
    /// D̄_geo.
    pub d_geo: f64,
}

/// Hears how training goes.
pub trait TrainObserver {
    /// An update was made.
    fn on_update(&mut self, metrics: &UpdateMetrics);
    /// A validation was made.
    fn on_validation(&mut self, metrics: &ValidationMetrics);
}

/// What training left.
#[derive(Debug, Clone, Serialize)]
pub struct TrainSummary {}

/// Refuses.
///
/// # Errors
/// Always.
pub fn train(
    _model: &ModelConfig,
    _train: &TrainConfig,
    _demonstrations: &Dataset,
    _validation: Option<&Dataset>,
    _device: DeviceKind,
    _out: &Path,
    _observer: &mut dyn TrainObserver,
) -> Result<TrainSummary, TrainError> {
    Err(TrainError)
}

/// One drawn trajectory.
#[derive(Debug, Clone, PartialEq)]
pub struct PolicySample {
    /// What the nodes agree on.
    pub consensus: ActionChunk,
    /// Each node's trajectory.
    pub nodes: Vec<ActionChunk>,
    /// Their distance from the consensus, one for each action.
    pub spread: Vec<f64>,
}

/// A trained policy; there is none.
#[derive(Debug)]
pub enum FlowPolicy {}

impl FlowPolicy {
    /// Refuses.
    ///
    /// # Errors
    /// Always.
    pub fn load(_folder: &Path, _device: DeviceKind) -> Result<Self, TrainError> {
        Err(TrainError)
    }

    /// Integration steps of [`Policy::plan`].
    pub fn set_steps(&mut self, _steps: usize) {
        match *self {}
    }

    /// Observation frames O.
    pub fn observation_horizon(&self) -> usize {
        match *self {}
    }

    /// Samples, `[history][seed]`.
    ///
    /// # Errors
    /// Never called.
    pub fn predict(
        &self,
        _histories: &[ObservationHistory],
        _seeds: &[u64],
        _steps: usize,
    ) -> Result<Vec<Vec<PolicySample>>, TrainError> {
        match *self {}
    }
}

impl Policy for FlowPolicy {
    fn name(&self) -> &str {
        match *self {}
    }

    fn reset(&mut self, _seed: u64) {
        match *self {}
    }

    fn plan(&mut self, _history: &ObservationHistory) -> Result<Plan, PolicyError> {
        match *self {}
    }
}
