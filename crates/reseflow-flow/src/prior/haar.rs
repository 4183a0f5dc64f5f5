//! The `haar` prior: H⁰ = (R_gripper U, c + σ R_gripper n) with U uniform on SO(3), n standard normal and c the cloud's centroid. It
//! knows nothing of where the gripper is, only, for the sake of equivariance, which way its axes point.

use rand::Rng;
use rand_distr::{Distribution, StandardNormal};
use reseflow_data::{Action, ActionChunk};
use reseflow_lie::{SE3, SO3, Vector3};

use super::{PriorFrame, check_deviations};
use crate::{FlowError, LENGTH_SCALE_M};

/// Uniform rotations, and positions about the cloud's centroid; independent for each step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HaarPrior {
    /// Standard deviation of each coordinate about the centroid, metres.
    pub sigma_translation_m: f64,
    /// Standard deviation of the opening about the current one.
    pub sigma_opening: f64,
}

impl Default for HaarPrior {
    fn default() -> Self {
        Self { sigma_translation_m: LENGTH_SCALE_M, sigma_opening: 0.2 }
    }
}

impl HaarPrior {
    /// Checks the standard deviations.
    ///
    /// # Errors
    /// [`FlowError::Config`] naming the first that is negative or not finite.
    pub fn validate(&self) -> Result<(), FlowError> {
        check_deviations(&[
            ("sigma_translation_m", self.sigma_translation_m),
            ("sigma_opening", self.sigma_opening),
        ])
    }

    /// Draws `horizon` noisy actions.
    pub fn sample<R: Rng + ?Sized>(&self, frame: &PriorFrame, horizon: usize, rng: &mut R) -> ActionChunk {
        let axes = frame.world_from_gripper.rotation;
        let actions = (0..horizon).map(|_| {
            let rotation = axes * SO3::sample_haar(rng);
            let mut normal = || -> f64 { StandardNormal.sample(rng) };
            let offset = Vector3::from_fn(|_, _| self.sigma_translation_m * normal());
            let opening = frame.opening + self.sigma_opening * normal();
            let position = frame.centroid_m + axes.act(&offset);
            Action { world_from_gripper: SE3::new(rotation, position), opening }
        });
        ActionChunk(actions.collect())
    }
}
