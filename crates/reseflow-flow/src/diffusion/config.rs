//! The keys of the diffusion: how many steps, how much noise, in which frame.

use serde::{Deserialize, Serialize};

use crate::FlowError;

/// The most steps that a configuration may ask for.
const MOST_STEPS: usize = 10_000;

/// Where the identity is that noise gathers about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DiffusionFrame {
    /// At the gripper's latest pose: noise and targets move with the scene.
    #[default]
    Gripper,
    /// At the world's origin, as published; kept to show that an invariant network cannot follow there.
    World,
}

/// The diffusion of the baseline.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DiffusionConfig {
    /// Noise levels K.
    pub steps: usize,
    /// γ of each angular component, radians.
    pub sigma_rotation_rad: f64,
    /// γ of each linear component, metres.
    pub sigma_translation_m: f64,
    /// γ of the opening.
    pub sigma_opening: f64,
    /// The frame of what is diffused.
    pub frame: DiffusionFrame,
    /// Whether every step but the last adds the posterior's noise to its mean.
    pub stochastic: bool,
}

impl Default for DiffusionConfig {
    fn default() -> Self {
        Self {
            steps: 100,
            sigma_rotation_rad: 0.05,
            sigma_translation_m: 0.03,
            sigma_opening: 0.05,
            frame: DiffusionFrame::Gripper,
            stochastic: false,
        }
    }
}

impl DiffusionConfig {
    /// Checks every value.
    ///
    /// # Errors
    /// [`FlowError::Config`] naming the first that is out of range.
    pub fn validate(&self) -> Result<(), FlowError> {
        if !(2..=MOST_STEPS).contains(&self.steps) {
            return Err(FlowError::Config(format!(
                "diffusion.steps must lie in 2 to {MOST_STEPS} (all but one are invariant, one is equivariant), got {}",
                self.steps
            )));
        }
        for (key, sigma) in [
            ("sigma_rotation_rad", self.sigma_rotation_rad),
            ("sigma_translation_m", self.sigma_translation_m),
            ("sigma_opening", self.sigma_opening),
        ] {
            if !(0.0..=1.0).contains(&sigma) {
                return Err(FlowError::Config(format!("diffusion.{key} must lie in 0 to 1, got {sigma}")));
            }
        }
        Ok(())
    }
}
