//! The baseline's model: the sizes of its networks, its diffusion and its objective.

use reseflow_flow::{Diffusion, DiffusionConfig};
use reseflow_net::{DriftNetConfig, Symmetry};
use serde::{Deserialize, Serialize};

use crate::{ModelConfig, TrainError};

/// Everything needed to rebuild the baseline around its weights, and its objective.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EtSeedConfig {
    /// Noise levels, noise and frame.
    pub diffusion: DiffusionConfig,
    /// Sizes of each of the two networks, as those of a flow's.
    pub network: DriftNetConfig,
    /// Share of the training windows that are given to the last, equivariant step, more than 0 and less than 1, as each of the two
    /// networks takes some; the other levels are uniform but for the next share.
    pub last_step_share: f64,
    /// Share of the other windows that are given to the noisiest tenth of the levels. Only there does the noise hide where the trajectory
    /// goes, so that it has to be read from the scene; below, a uniform choice of levels mostly teaches to keep what is there. It is to
    /// the baseline what `train.time.zero_share` is to a flow.
    pub noisiest_share: f64,
    /// Weight of the opening's error.
    pub opening: f64,
}

impl Default for EtSeedConfig {
    fn default() -> Self {
        Self {
            diffusion: DiffusionConfig::default(),
            network: DriftNetConfig::default(),
            last_step_share: 0.1,
            noisiest_share: 0.0,
            opening: 0.25,
        }
    }
}

impl EtSeedConfig {
    /// Checks every value.
    ///
    /// # Errors
    /// What the diffusion or the network refuses, and [`TrainError::Config`] naming a value out of range.
    pub fn validate(&self) -> Result<(), TrainError> {
        Diffusion::new(&self.diffusion)?;
        ModelConfig { network: self.network.clone(), ..ModelConfig::default() }.validate()?;
        if self.network.symmetry != Symmetry::SE3 {
            return Err(TrainError::Config(
                "model.network.symmetry other than \"se3\" is for the flows and the regressor, and the baseline's network is \
                 equivariant; use \"se3\", or leave out the table baseline"
                    .to_owned(),
            ));
        }
        for (key, value, high) in [
            ("last_step_share", self.last_step_share, 1.0),
            ("noisiest_share", self.noisiest_share, 1.0),
            ("opening", self.opening, 1e6),
        ] {
            if !(0.0..=high).contains(&value) {
                let fault = format!("baseline.{key} must lie in 0 to {high}, got {value}");
                return Err(TrainError::Config(fault));
            }
        }
        if self.last_step_share == 0.0 || self.last_step_share == 1.0 {
            return Err(TrainError::Config(format!(
                "baseline.last_step_share must lie between 0 and 1, got {}: one of the two networks would act untrained",
                self.last_step_share
            )));
        }
        Ok(())
    }
}
