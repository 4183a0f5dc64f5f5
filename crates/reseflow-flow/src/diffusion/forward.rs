//! The forward process X^k = Exp(γ √(1 − ᾱ_k) ε) F(√ᾱ_k), F(s) = Exp((1 − s) Log((X⁰)⁻¹)) X⁰ (ET-SEED's, with its H being our X), and
//! one step back.

use std::f64::consts::{FRAC_PI_2, TAU};

use rand::Rng;
use rand_distr::{Distribution, StandardNormal};
use reseflow_lie::{BodyTwist, SE3, SO3, SpatialTwist, Vector3};

use super::{AnchoredAction, AnchoredChunk, CosineSchedule, DiffusionConfig};
use crate::FlowError;

/// A diffusion with its schedule.
#[derive(Debug, Clone, PartialEq)]
pub struct Diffusion {
    config: DiffusionConfig,
    schedule: CosineSchedule,
}

impl Diffusion {
    /// The diffusion of a configuration.
    ///
    /// # Errors
    /// As [`DiffusionConfig::validate`].
    pub fn new(config: &DiffusionConfig) -> Result<Self, FlowError> {
        config.validate()?;
        Ok(Self { config: *config, schedule: CosineSchedule::new(config.steps) })
    }

    /// What it was made from.
    pub fn config(&self) -> &DiffusionConfig {
        &self.config
    }

    /// How the noise grows.
    pub fn schedule(&self) -> &CosineSchedule {
        &self.schedule
    }

    /// Draws X^K: noise about the identity, independent for each of `horizon` actions.
    pub fn draw<R: Rng + ?Sized>(&self, horizon: usize, rng: &mut R) -> AnchoredChunk {
        let still = AnchoredAction { anchor_from_gripper: SE3::identity(), opening: 0.0 };
        let deviation = self.schedule.noise(self.schedule.steps());
        AnchoredChunk((0..horizon).map(|_| self.scattered(&still, deviation, rng)).collect())
    }

    /// F(√ᾱ_k): the clean action moved towards the identity, without noise.
    pub fn shrunk(&self, clean: &AnchoredAction, level: usize) -> AnchoredAction {
        let signal = self.schedule.signal(level);
        AnchoredAction {
            anchor_from_gripper: SE3::exp(&(clean.anchor_from_gripper.log() * signal)),
            opening: clean.opening * signal,
        }
    }

    /// Draws X^k where X⁰ is `clean`.
    pub fn noised<R: Rng + ?Sized>(&self, clean: &AnchoredChunk, level: usize, rng: &mut R) -> AnchoredChunk {
        let deviation = self.schedule.noise(level);
        AnchoredChunk(
            clean
                .0
                .iter()
                .map(|action| self.scattered(&self.shrunk(action, level), deviation, rng))
                .collect(),
        )
    }

    /// X^to = Exp(λ₀ Log X̂⁰ + λ₁ Log X^from): the mean of the posterior, with the Log X̂⁰ that is nearest to Log X^from.
    pub fn posterior_mean(
        &self,
        noisy: &AnchoredAction,
        clean: &AnchoredAction,
        from: usize,
        to: usize,
    ) -> AnchoredAction {
        let weights = self.schedule.posterior(from, to);
        let state = noisy.anchor_from_gripper.log();
        let twist = log_near(&clean.anchor_from_gripper, &state) * weights.clean + state * weights.noisy;
        AnchoredAction {
            anchor_from_gripper: SE3::exp(&twist),
            opening: clean.opening * weights.clean + noisy.opening * weights.noisy,
        }
    }

    /// `action` with noise of `deviation` · γ in the anchor's axes.
    pub(super) fn scattered<R: Rng + ?Sized>(
        &self,
        action: &AnchoredAction,
        deviation: f64,
        rng: &mut R,
    ) -> AnchoredAction {
        let mut normal = |gamma: f64| {
            let draw: f64 = StandardNormal.sample(rng);
            gamma * deviation * draw
        };
        let angular = Vector3::from_fn(|_, _| normal(self.config.sigma_rotation_rad));
        let linear = Vector3::from_fn(|_, _| normal(self.config.sigma_translation_m));
        AnchoredAction {
            anchor_from_gripper: action.anchor_from_gripper.plus_spatial(&SpatialTwist { angular, linear }),
            opening: action.opening + normal(self.config.sigma_opening),
        }
    }
}

/// The logarithm of `pose` whose rotation vector is nearest to that of `near`: the principal one, or the other way round.
///
/// Where an estimate crosses half a turn, the principal one would jump to the other side, and the mean of the two be neither.
fn log_near(pose: &SE3, near: &BodyTwist) -> BodyTwist {
    let principal = pose.log();
    let angle = principal.angular.norm();
    if angle < FRAC_PI_2 {
        return principal;
    }
    let other = principal.angular * (1.0 - TAU / angle);
    if (other - near.angular).norm_squared() >= (principal.angular - near.angular).norm_squared() {
        return principal;
    }
    BodyTwist::new(other, SO3::left_jacobian_inverse(&other) * pose.translation)
}
