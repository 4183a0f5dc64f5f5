//! The Jacobians of SE(3)'s exponential and their inverses, on twists (ω, ρ).
//!
//! Barfoot, *State Estimation for Robotics*, 7.85–7.95, reordered to angular first.

use crate::coefficients::{second_order_coupling, theta_minus_sin_over_cube, third_order_coupling};
use crate::{BodyTwist, SE3, SO3};
use nalgebra::{Matrix3, Matrix6};

impl SE3 {
    /// J_l(ξ) = \[J_l(ω), 0; Q(ω, ρ), J_l(ω)\] = Σ ad_ξⁿ/(n + 1)!, with Exp(ξ + δ) ≈ Exp(J_l(ξ) δ) Exp(ξ).
    pub fn left_jacobian(twist: &BodyTwist) -> Matrix6<f64> {
        lower_triangular(&SO3::left_jacobian(&twist.angular), &coupling(twist))
    }

    /// J_r(ξ) = J_l(−ξ) = Ad_{Exp(−ξ)} J_l(ξ), with Exp(ξ + δ) ≈ Exp(ξ) Exp(J_r(ξ) δ).
    pub fn right_jacobian(twist: &BodyTwist) -> Matrix6<f64> {
        SE3::left_jacobian(&-*twist)
    }

    /// J_l(ξ)⁻¹ = \[J, 0; −J Q J, J\] with J = J_l(ω)⁻¹; singular at ‖ω‖ = 2πk, k ≥ 1.
    pub fn left_jacobian_inverse(twist: &BodyTwist) -> Matrix6<f64> {
        let rotation_inverse = SO3::left_jacobian_inverse(&twist.angular);
        lower_triangular(&rotation_inverse, &-(rotation_inverse * coupling(twist) * rotation_inverse))
    }

    /// J_r(ξ)⁻¹ = J_l(−ξ)⁻¹, with Log(X Exp(δ)) ≈ Log(X) + J_r(Log X)⁻¹ δ.
    pub fn right_jacobian_inverse(twist: &BodyTwist) -> Matrix6<f64> {
        SE3::left_jacobian_inverse(&-*twist)
    }
}

/// \[D, 0; C, D\].
fn lower_triangular(diagonal: &Matrix3<f64>, corner: &Matrix3<f64>) -> Matrix6<f64> {
    let mut matrix = Matrix6::zeros();
    matrix.fixed_view_mut::<3, 3>(0, 0).copy_from(diagonal);
    matrix.fixed_view_mut::<3, 3>(3, 0).copy_from(corner);
    matrix.fixed_view_mut::<3, 3>(3, 3).copy_from(diagonal);
    matrix
}

/// Q(ω, ρ), Barfoot's 7.86b, with W = \[ω\]× and P = \[ρ\]×:
/// ½P + ((θ − sin θ)/θ³)(WP + PW + WPW) + ((θ² + 2 cos θ − 2)/(2θ⁴))(W²P + PW² − 3WPW)
/// + ((2θ − 3 sin θ + θ cos θ)/(2θ⁵))(WPW² + W²PW).
fn coupling(twist: &BodyTwist) -> Matrix3<f64> {
    let theta = twist.angular.norm();
    let w = twist.angular.cross_matrix();
    let p = twist.linear.cross_matrix();
    let (wp, pw) = (w * p, p * w);
    let wpw = wp * w;
    p * 0.5
        + (wp + pw + wpw) * theta_minus_sin_over_cube(theta)
        + (w * wp + pw * w - wpw * 3.0) * second_order_coupling(theta)
        + (wpw * w + w * wpw) * third_order_coupling(theta)
}
