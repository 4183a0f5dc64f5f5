//! The Jacobians of SO(3)'s exponential and their inverses, on rotation vectors.
//!
//! Solà, Deray, Atchuthan, *A micro Lie theory*, equations 143–146; Barfoot, *State Estimation for Robotics*, 7.77.

use crate::SO3;
use crate::coefficients::{inverse_jacobian_square, one_minus_cos_over_square, theta_minus_sin_over_cube};
use nalgebra::{Matrix3, Vector3};

impl SO3 {
    /// J_l(ω) = I + ((1 − cos θ)/θ²) \[ω\]× + ((θ − sin θ)/θ³) \[ω\]×², with Exp(ω + δ) ≈ Exp(J_l(ω) δ) Exp(ω).
    pub fn left_jacobian(omega: &Vector3<f64>) -> Matrix3<f64> {
        let theta = omega.norm();
        let hat = omega.cross_matrix();
        Matrix3::identity()
            + hat * one_minus_cos_over_square(theta)
            + hat * hat * theta_minus_sin_over_cube(theta)
    }

    /// J_r(ω) = J_l(−ω) = J_l(ω)ᵀ, with Exp(ω + δ) ≈ Exp(ω) Exp(J_r(ω) δ).
    pub fn right_jacobian(omega: &Vector3<f64>) -> Matrix3<f64> {
        SO3::left_jacobian(&-omega)
    }

    /// J_l(ω)⁻¹ = I − ½ \[ω\]× + ((1 − (θ/2) cot(θ/2))/θ²) \[ω\]×².
    ///
    /// J_l is singular at θ = 2πk, k ≥ 1, which no value of [`SO3::log`] reaches.
    pub fn left_jacobian_inverse(omega: &Vector3<f64>) -> Matrix3<f64> {
        let hat = omega.cross_matrix();
        Matrix3::identity() - hat * 0.5 + hat * hat * inverse_jacobian_square(omega.norm())
    }

    /// J_r(ω)⁻¹ = J_l(−ω)⁻¹, with Log(R Exp(δ)) ≈ Log(R) + J_r(Log R)⁻¹ δ.
    pub fn right_jacobian_inverse(omega: &Vector3<f64>) -> Matrix3<f64> {
        SO3::left_jacobian_inverse(&-omega)
    }
}
