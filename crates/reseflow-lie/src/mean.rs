//! Fréchet means: the element with the least weighted sum of squared distances to given ones.
//!
//! Rotations by Riemannian gradient descent (Manton, *A globally convergent numerical algorithm for computing the
//! centre of mass on compact Lie groups*, 2004), started at the chordal mean (Markley et al.,
//! *Averaging quaternions*, 2007). Poses in the product metric that D_geo measures, where the mean of the
//! translations is the arithmetic one.

use crate::{LieError, SE3, SO3};
use nalgebra::{Matrix4, Quaternion, Vector3, Vector4};

/// Norm of the Riemannian gradient, radian, at which the iteration has converged.
const GRADIENT_TOLERANCE_RAD: f64 = 1e-12;
/// Iterations after which it is given up: widely scattered rotations without a clear mean.
const MAXIMUM_ITERATIONS: usize = 1000;

impl SO3 {
    /// The Fréchet mean argmin_M Σ wᵢ ‖Log(M⁻¹ Rᵢ)‖²; weights need not sum to 1.
    ///
    /// It is unique when the rotations lie within π/2 of some rotation; beyond that it is the local minimum next to
    /// the chordal mean.
    ///
    /// # Errors
    ///
    /// No rotations, a weight too many or too few, an invalid weight, a non-finite rotation, or no convergence.
    pub fn frechet_mean(rotations: &[SO3], weights: &[f64]) -> Result<SO3, LieError> {
        let weights = normalised(weights, rotations.len())?;
        if !rotations.iter().all(SO3::is_finite) {
            return Err(LieError::NonFinite { what: "rotations to average" });
        }
        rotation_mean(rotations, &weights)
    }
}

impl SE3 {
    /// The Fréchet mean argmin_M Σ wᵢ D_geo(M, Xᵢ)²; weights need not sum to 1.
    ///
    /// # Errors
    ///
    /// As for [`SO3::frechet_mean`].
    pub fn frechet_mean(poses: &[SE3], weights: &[f64]) -> Result<SE3, LieError> {
        let weights = normalised(weights, poses.len())?;
        if !poses.iter().all(SE3::is_finite) {
            return Err(LieError::NonFinite { what: "poses to average" });
        }
        let rotations: Vec<SO3> = poses.iter().map(|pose| pose.rotation).collect();
        let translation = poses.iter().zip(&weights).map(|(pose, weight)| pose.translation * *weight).sum();
        Ok(SE3::new(rotation_mean(&rotations, &weights)?, translation))
    }
}

/// The weights divided by their sum.
fn normalised(weights: &[f64], elements: usize) -> Result<Vec<f64>, LieError> {
    if elements == 0 {
        return Err(LieError::EmptyMean);
    }
    if weights.len() != elements {
        return Err(LieError::WeightCount { elements, weights: weights.len() });
    }
    let sum: f64 = weights.iter().sum();
    if let Some(&weight) = weights.iter().find(|weight| !weight.is_finite() || **weight < 0.0) {
        return Err(LieError::InvalidWeight { weight, sum });
    }
    if !(sum.is_finite() && sum > 0.0) {
        return Err(LieError::InvalidWeight {
            weight: weights.iter().copied().fold(f64::INFINITY, f64::min),
            sum,
        });
    }
    Ok(weights.iter().map(|weight| weight / sum).collect())
}

/// Steps of M ← M Exp(Σ wᵢ Log(M⁻¹ Rᵢ)). No step size is needed: the Hessian of ½‖Log(M⁻¹R)‖² is at most the identity, so
/// a whole step never raises the objective.
fn rotation_mean(rotations: &[SO3], weights: &[f64]) -> Result<SO3, LieError> {
    let mut mean = chordal_mean(rotations, weights);
    let mut gradient_rad = f64::INFINITY;
    for _ in 0..MAXIMUM_ITERATIONS {
        let body_from_world = mean.inverse();
        let step: Vector3<f64> = rotations
            .iter()
            .zip(weights)
            .map(|(rotation, weight)| (body_from_world * rotation).log() * *weight)
            .sum();
        gradient_rad = step.norm();
        if gradient_rad <= GRADIENT_TOLERANCE_RAD {
            return Ok(mean);
        }
        mean = mean * SO3::exp(&step);
    }
    Err(LieError::MeanNotConverged { iterations: MAXIMUM_ITERATIONS, gradient_rad })
}

/// argmin_M Σ wᵢ ‖M − Rᵢ‖²: the eigenvector of Σ wᵢ qᵢqᵢᵀ with the largest eigenvalue.
fn chordal_mean(rotations: &[SO3], weights: &[f64]) -> SO3 {
    let scatter = rotations.iter().zip(weights).fold(Matrix4::zeros(), |sum, (rotation, weight)| {
        let xyzw = Vector4::from(rotation.quaternion_xyzw());
        sum + xyzw * xyzw.transpose() * *weight
    });
    let eigen = scatter.symmetric_eigen();
    SO3::from_unit(Quaternion::from(eigen.eigenvectors.column(eigen.eigenvalues.imax()).into_owned()))
}
