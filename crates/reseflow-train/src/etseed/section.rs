//! The table `[baseline]` of an experiment: what is the baseline's own, beside the network and the training that it shares with Flow 1.

use reseflow_flow::DiffusionConfig;
use serde::{Deserialize, Serialize};

use super::config::EtSeedConfig;
use crate::config::check_warmup;
use crate::{ModelConfig, TrainConfig, TrainError};

/// How the baseline is trained. What is not said here is as in the training of Flow 1, the sizes of its networks included.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BaselineConfig {
    /// Optimiser updates.
    pub updates: usize,
    /// Peak learning rate.
    pub learning_rate: f64,
    /// Updates of linear warm-up.
    pub warmup: usize,
    /// Share of the training windows that are given to the last, equivariant step.
    pub last_step_share: f64,
    /// Share of the other windows that are given to the noisiest tenth of the levels; the rest are uniform.
    pub noisiest_share: f64,
    /// Weight of the opening's error.
    pub opening: f64,
    /// Noise levels, noise and frame.
    pub diffusion: DiffusionConfig,
}

/// The peak learning rate where nothing is said. What a flow learns best with, twice as much, gains the baseline nothing.
const LEARNING_RATE: f64 = 2e-3;

impl Default for BaselineConfig {
    fn default() -> Self {
        let TrainConfig { updates, warmup, .. } = TrainConfig::default();
        let EtSeedConfig { last_step_share, noisiest_share, opening, diffusion, .. } =
            EtSeedConfig::default();
        let learning_rate = LEARNING_RATE;
        Self { updates, learning_rate, warmup, last_step_share, noisiest_share, opening, diffusion }
    }
}

impl BaselineConfig {
    /// Checks every value; `model` and `train` are Flow 1's.
    ///
    /// # Errors
    /// [`TrainError::Config`] and [`TrainError::Flow`], naming what is out of range.
    pub fn validate(&self, model: &ModelConfig, train: &TrainConfig) -> Result<(), TrainError> {
        if self.updates == 0 {
            return Err(TrainError::Config("baseline.updates must be at least 1, got 0".to_owned()));
        }
        if !(0.0..=1.0).contains(&self.learning_rate) {
            let fault = format!("baseline.learning_rate must lie in 0 to 1, got {}", self.learning_rate);
            return Err(TrainError::Config(fault));
        }
        check_warmup("baseline", self.warmup, self.updates)?;
        self.model(model).validate()?;
        self.training(train).validate()
    }

    /// The networks and the diffusion; `base` is Flow 1's.
    pub fn model(&self, base: &ModelConfig) -> EtSeedConfig {
        let Self { last_step_share, noisiest_share, opening, diffusion, .. } = *self;
        EtSeedConfig { diffusion, network: base.network.clone(), last_step_share, noisiest_share, opening }
    }

    /// The optimisation: that of Flow 1 but for what this table says.
    pub fn training(&self, base: &TrainConfig) -> TrainConfig {
        let Self { updates, learning_rate, warmup, .. } = *self;
        TrainConfig { updates, learning_rate, warmup, ..base.clone() }
    }
}
