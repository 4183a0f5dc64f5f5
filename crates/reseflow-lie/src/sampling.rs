//! Random rotations and poses: uniform (Haar) and concentrated Gaussian.
//!
//! Haar: Shoemake, *Uniform random rotations*, 1992 (a uniform unit quaternion). Concentrated Gaussian: Barfoot and
//! Furgale, *Associating uncertainty with three-dimensional poses*, 2014, with the noise on the body side.

use crate::{BodyTwist, SE3, SO3};
use nalgebra::{Quaternion, Vector3};
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

/// Squared norm below which a normal quaternion is drawn again: its direction would be rounding.
const DEGENERATE_SQUARED: f64 = 1e-20;

impl SO3 {
    /// A rotation drawn uniformly: its law is unchanged by turning it from either side.
    pub fn sample_haar<R: Rng + ?Sized>(rng: &mut R) -> SO3 {
        loop {
            let xyz = standard_normal3(rng);
            let quaternion = Quaternion::from_parts(StandardNormal.sample(rng), xyz);
            if quaternion.norm_squared() > DEGENERATE_SQUARED {
                return SO3::from_unit(quaternion);
            }
        }
    }

    /// `mean` Exp(ε), ε ~ N(0, σ² I): a rotation scattered about `mean` by `sigma` radian on each body axis.
    pub fn sample_gaussian<R: Rng + ?Sized>(mean: &SO3, sigma: f64, rng: &mut R) -> SO3 {
        mean.compose(&SO3::exp(&(standard_normal3(rng) * sigma)))
    }
}

impl SE3 {
    /// `mean` Exp(ε), ε = (ω, ρ) ~ N(0, diag(σ_ω², σ_ρ²)): a pose scattered about `mean` in its body frame.
    ///
    /// `sigma_angular` in radian and `sigma_linear` in metre are the deviations on each axis. Because the noise is in
    /// body coordinates, the same random numbers about g·`mean` give g times the sample.
    pub fn sample_gaussian<R: Rng + ?Sized>(
        mean: &SE3,
        sigma_angular: f64,
        sigma_linear: f64,
        rng: &mut R,
    ) -> SE3 {
        let angular = standard_normal3(rng) * sigma_angular;
        let linear = standard_normal3(rng) * sigma_linear;
        mean.plus(&BodyTwist::new(angular, linear))
    }
}

fn standard_normal3<R: Rng + ?Sized>(rng: &mut R) -> Vector3<f64> {
    let [x, y, z] = std::array::from_fn(|_| StandardNormal.sample(rng));
    Vector3::new(x, y, z)
}
