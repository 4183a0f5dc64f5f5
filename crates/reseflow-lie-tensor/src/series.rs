//! Coefficients that are 0/0 at angle 0, by their power series near it.
//!
//! Both sides of each choice are finite for every row: the closed forms divide by an angle that was set to 1 where the
//! series is taken, and the series are polynomials. Below the threshold four terms are exact to f64 rounding; above it
//! the closed forms lose no more than rounding divided by the angle.

use burn::tensor::{Bool, Tensor};

use crate::constant::constant;

/// Squared angle below which the series are taken.
const SMALL_ANGLE_SQUARED: f64 = 2.5e-3;

/// c₀ + c₁ x + c₂ x² + … by Horner's rule.
pub(crate) fn polynomial(x: Tensor<2>, coefficients: [f64; 4]) -> Tensor<2> {
    let [c0, c1, c2, c3] = coefficients;
    ((x.clone() * c3 + c2) * x.clone() + c1) * x + c0
}

/// Σ xᵢ² along the last axis.
///
/// # Shapes
/// - `x`: `[N, C]`
/// - output: `[N, 1]`
pub(crate) fn squared_norm(x: Tensor<2>) -> Tensor<2> {
    x.clone().mul(x).sum_dim(1)
}

/// √x with gradient 0 at 0.
pub(crate) fn safe_sqrt<const D: usize>(x: Tensor<D>) -> Tensor<D> {
    let zero = x.clone().lower_equal_elem(0.0);
    x.mask_fill(zero.clone(), 1.0).sqrt().mask_fill(zero, 0.0)
}

/// Half-angle functions of a rotation vector ω with θ = ‖ω‖, each `[N, 1]`.
pub(crate) struct HalfAngle {
    /// sin(θ/2) / (θ/2)
    pub(crate) sinc: Tensor<2>,
    /// cos(θ/2)
    pub(crate) cos: Tensor<2>,
    angle_squared: Tensor<2>,
    safe_angle_squared: Tensor<2>,
    small: Tensor<2, Bool>,
}

impl HalfAngle {
    /// From ω, `[N, 3]`.
    pub(crate) fn new(omega: Tensor<2>) -> Self {
        let angle_squared = squared_norm(omega);
        let small = angle_squared.clone().lower_elem(SMALL_ANGLE_SQUARED);
        let safe_angle_squared = angle_squared.clone().mask_fill(small.clone(), 1.0);
        let half = safe_angle_squared.clone().sqrt() * 0.5;
        let sinc_series =
            polynomial(angle_squared.clone(), [1.0, -1.0 / 24.0, 1.0 / 1920.0, -1.0 / 322_560.0]);
        let cos_series = polynomial(angle_squared.clone(), [1.0, -1.0 / 8.0, 1.0 / 384.0, -1.0 / 46_080.0]);
        let sinc = (half.clone().sin() / half.clone()).mask_where(small.clone(), sinc_series);
        let cos = half.cos().mask_where(small.clone(), cos_series);
        Self { sinc, cos, angle_squared, safe_angle_squared, small }
    }

    /// sin θ / θ
    pub(crate) fn sin_over_angle(&self) -> Tensor<2> {
        self.sinc.clone() * self.cos.clone()
    }

    /// (1 − cos θ) / θ²
    pub(crate) fn one_minus_cos_over_angle_squared(&self) -> Tensor<2> {
        self.sinc.clone() * self.sinc.clone() * 0.5
    }

    /// (θ − sin θ) / θ³
    pub(crate) fn angle_minus_sin_over_angle_cubed(&self) -> Tensor<2> {
        let closed = (-self.sin_over_angle() + 1.0) / self.safe_angle_squared.clone();
        self.near_zero(closed, [1.0 / 6.0, -1.0 / 120.0, 1.0 / 5040.0, -1.0 / 362_880.0])
    }

    /// (1 − (θ/2) cot(θ/2)) / θ², singular at θ = 2π
    pub(crate) fn inverse_jacobian_coefficient(&self) -> Tensor<2> {
        let half_angle_cot = self.cos.clone() / self.sinc.clone();
        let closed = (-half_angle_cot + 1.0) / self.safe_angle_squared.clone();
        self.near_zero(closed, [1.0 / 12.0, 1.0 / 720.0, 1.0 / 30_240.0, 1.0 / 1_209_600.0])
    }

    /// θ²
    pub(crate) fn angle_squared(&self) -> Tensor<2> {
        self.angle_squared.clone()
    }

    fn near_zero(&self, closed: Tensor<2>, series: [f64; 4]) -> Tensor<2> {
        closed.mask_where(self.small.clone(), polynomial(self.angle_squared.clone(), series))
    }
}

/// θ / sin(θ/2) from sin²(θ/2) and cos(θ/2) ≥ 0 (up to rounding), each `[N, 1]`: what turns the vector part of a unit
/// quaternion into the rotation vector.
pub(crate) fn angle_over_half_sine(sine_squared: Tensor<2>, cosine: Tensor<2>) -> Tensor<2> {
    let small = sine_squared.clone().lower_elem(SMALL_ANGLE_SQUARED / 4.0);
    let sine = sine_squared.clone().mask_fill(small.clone(), 1.0).sqrt();
    let closed = sine.clone().atan2(cosine) * 2.0 / sine;
    // 2 asin(s) / s
    closed.mask_where(small, polynomial(sine_squared, [2.0, 1.0 / 3.0, 3.0 / 20.0, 5.0 / 56.0]))
}

/// The identity matrix, flat.
///
/// # Shapes
/// - output: `[1, 9]`
pub(crate) fn flat_identity<const E: usize>(like: &Tensor<E>) -> Tensor<2> {
    constant(&[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0], [1, 9], like)
}
