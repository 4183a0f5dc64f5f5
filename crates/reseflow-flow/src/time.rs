//! Which flow times the objective is asked at.

use rand::{Rng, RngExt};
use serde::{Deserialize, Serialize};

use crate::FlowError;

/// The a of the U's density ∝ e^{at} + e^{a(1−t)}, as Lee, Lin and Fanti found best (*Improving the training of rectified flows*,
/// 2024): the ends are drawn nearly four times as often as the middle.
const STEEPNESS: f64 = 4.0;

/// The density of flow times on \[0, 1).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TimeShape {
    /// Every time equally often.
    #[default]
    Uniform,
    /// Both ends more often than the middle, where a reflowed path is easiest.
    UShaped,
}

/// Flow times with an extra share at t = 0, where a single integration step is taken.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TimeSampling {
    /// Share of the samples drawn at exactly t = 0; the rest lies in \[0, 1).
    pub zero_share: f64,
    /// The density of the rest.
    pub shape: TimeShape,
}

impl Default for TimeSampling {
    fn default() -> Self {
        Self { zero_share: 0.3, shape: TimeShape::Uniform }
    }
}

impl TimeSampling {
    /// Checks the share, and that a shape is left to be drawn from.
    ///
    /// # Errors
    /// [`FlowError::Config`] where it is no share, or where it leaves nothing to the shape.
    pub fn validate(&self) -> Result<(), FlowError> {
        if !(0.0..=1.0).contains(&self.zero_share) {
            return Err(FlowError::Config(format!(
                "time.zero_share must lie in 0 to 1, got {}",
                self.zero_share
            )));
        }
        if self.zero_share == 1.0 && self.shape != TimeShape::Uniform {
            return Err(FlowError::Config(
                "time.shape = \"u_shaped\" has no effect with time.zero_share = 1: every time is 0"
                    .to_owned(),
            ));
        }
        Ok(())
    }

    /// Draws one flow time.
    pub fn sample<R: Rng + ?Sized>(&self, rng: &mut R) -> f64 {
        let (choice, time): (f64, f64) = (rng.random(), rng.random());
        let time = match self.shape {
            TimeShape::Uniform => time,
            TimeShape::UShaped => {
                // The inverse of (e^{4x} − 1)/(e⁴ − 1), mirrored for every other sample.
                let rising = (time * STEEPNESS.exp_m1()).ln_1p() / STEEPNESS;
                let mirrored: bool = rng.random();
                if mirrored { (1.0 - rising).min(1.0_f64.next_down()) } else { rising }
            }
        };
        if choice < self.zero_share { 0.0 } else { time }
    }
}
