//! Which flow times the objective is asked at.

use rand::{Rng, RngExt};
use serde::{Deserialize, Serialize};

use crate::FlowError;

/// Uniform times with an extra share at t = 0, where a single integration step is taken.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TimeSampling {
    /// Share of the samples drawn at exactly t = 0; the rest is uniform on \[0, 1).
    pub zero_share: f64,
}

impl Default for TimeSampling {
    fn default() -> Self {
        Self { zero_share: 0.3 }
    }
}

impl TimeSampling {
    /// Checks the share.
    ///
    /// # Errors
    /// [`FlowError::Config`] where it is no share.
    pub fn validate(&self) -> Result<(), FlowError> {
        if (0.0..=1.0).contains(&self.zero_share) {
            return Ok(());
        }
        Err(FlowError::Config(format!("time.zero_share must lie in 0 to 1, got {}", self.zero_share)))
    }

    /// Draws one flow time.
    pub fn sample<R: Rng + ?Sized>(&self, rng: &mut R) -> f64 {
        let (choice, time): (f64, f64) = (rng.random(), rng.random());
        if choice < self.zero_share { 0.0 } else { time }
    }
}
