//! The `gripper` prior, centred at the gripper: H⁰ = H_gripper Exp(ε), ε ~ N(0, diag(σ_ω², σ_ρ²)).

use rand::Rng;
use rand_distr::{Distribution, StandardNormal};
use reseflow_data::{Action, ActionChunk};
use reseflow_lie::{BodyTwist, SE3, Vector3};

use super::check_deviations;
use crate::FlowError;

/// The `gripper` prior: independent for each step, in the gripper's own frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GripperPrior {
    /// Standard deviation of each angular component, radians.
    pub sigma_rotation_rad: f64,
    /// Standard deviation of each linear component, metres.
    pub sigma_translation_m: f64,
    /// Standard deviation of the opening about the current one.
    pub sigma_opening: f64,
}

impl Default for GripperPrior {
    fn default() -> Self {
        Self { sigma_rotation_rad: 0.5, sigma_translation_m: 0.1, sigma_opening: 0.2 }
    }
}

impl GripperPrior {
    /// Checks the standard deviations.
    ///
    /// # Errors
    /// [`FlowError::Config`] naming the first that is negative or not finite, or all where none is greater than 0.
    pub fn validate(&self) -> Result<(), FlowError> {
        let deviations = [
            ("sigma_rotation_rad", self.sigma_rotation_rad),
            ("sigma_translation_m", self.sigma_translation_m),
            ("sigma_opening", self.sigma_opening),
        ];
        check_deviations(&deviations)?;
        if deviations.iter().all(|(_, deviation)| *deviation == 0.0) {
            return Err(FlowError::Config(
                "prior.sigma_rotation_rad, prior.sigma_translation_m and prior.sigma_opening must not all be 0: a flow starts out from \
                 noise"
                    .to_owned(),
            ));
        }
        Ok(())
    }

    /// Draws `horizon` noisy actions about the gripper.
    pub fn sample<R: Rng + ?Sized>(
        &self,
        world_from_gripper: &SE3,
        opening: f64,
        horizon: usize,
        rng: &mut R,
    ) -> ActionChunk {
        let mut normal = |sigma: f64| {
            let draw: f64 = StandardNormal.sample(rng);
            sigma * draw
        };
        let actions = (0..horizon).map(|_| {
            let angular = Vector3::from_fn(|_, _| normal(self.sigma_rotation_rad));
            let linear = Vector3::from_fn(|_, _| normal(self.sigma_translation_m));
            Action {
                world_from_gripper: world_from_gripper.plus(&BodyTwist { angular, linear }),
                opening: opening + normal(self.sigma_opening),
            }
        });
        ActionChunk(actions.collect())
    }
}
