//! Rotations: the exponential, the logarithm and the left Jacobian of SO(3).
//!
//! Formulas as in Solà, Deray, Atchuthan 2018, "A micro Lie theory for state estimation in robotics"; equation numbers
//! refer to it.

use burn::tensor::Tensor;

use crate::constant::constant;
use crate::quaternion;
use crate::series::{HalfAngle, flat_identity};

/// Row i is the i-th generator of so(3), row-major.
const GENERATORS: [[f64; 9]; 3] = [
    [0., 0., 0., 0., 0., -1., 0., 1., 0.],
    [0., 0., 1., 0., 0., 0., -1., 0., 0.],
    [0., -1., 0., 1., 0., 0., 0., 0., 0.],
];

/// The skew matrix ω̂ with ω̂ x = ω × x.
///
/// # Shapes
/// - `omega`: `[N, 3]`
/// - output: `[N, 3, 3]`
pub fn hat(omega: Tensor<2>) -> Tensor<3> {
    let [n, _] = omega.dims();
    flat_hat(omega).reshape([n, 3, 3])
}

/// Exp: the rotation by ‖ω‖ about ω (eq. 132), through the unit quaternion (ω/2 · sinc(θ/2), cos(θ/2)).
///
/// # Shapes
/// - `omega`: `[N, 3]`, rad, any length
/// - output: `[N, 3, 3]`
pub fn exp(omega: Tensor<2>) -> Tensor<3> {
    let half = HalfAngle::new(omega.clone());
    let vector = omega * (half.sinc * 0.5);
    quaternion::to_matrix(Tensor::cat(vec![vector, half.cos], 1))
}

/// Log: the rotation vector of norm at most π (up to rounding; eq. 133), through the quaternion and `atan2`.
///
/// At a half-turn ±ω are equally good; the one whose first non-zero component, in the order x, y, z, is positive is
/// taken (see [`quaternion::from_matrix`]), and the gradient is that of this branch. For a relative rotation RₐᵀR_b
/// the choice is made in body coordinates, so it does not depend on the world frame.
///
/// # Shapes
/// - `rotation`: `[N, 3, 3]`
/// - output: `[N, 3]`, rad
pub fn log(rotation: Tensor<3>) -> Tensor<2> {
    quaternion::to_rotation_vector(quaternion::from_matrix(rotation))
}

/// Rₐ R_b: `a_from_b` and `b_from_c` give `a_from_c`.
///
/// Here as everywhere below, 3 × 3 products are one broadcast product and one sum: a batched matrix product costs a
/// kernel launch for each of its N small matrices, several times as much.
///
/// # Shapes
/// - `a`, `b`: `[N, 3, 3]`
/// - output: `[N, 3, 3]`
pub fn compose(a: Tensor<3>, b: Tensor<3>) -> Tensor<3> {
    let [n, _, _] = a.dims();
    a.reshape([n, 3, 3, 1]).mul(b.reshape([n, 1, 3, 3])).sum_dim(2).reshape([n, 3, 3])
}

/// R_b seen from R_a: RₐᵀR_b.
///
/// # Shapes
/// - `start`, `end`: `[N, 3, 3]`
/// - output: `[N, 3, 3]`
pub fn between(start: Tensor<3>, end: Tensor<3>) -> Tensor<3> {
    let [n, _, _] = start.dims();
    start.reshape([n, 3, 3, 1]).mul(end.reshape([n, 3, 1, 3])).sum_dim(1).reshape([n, 3, 3])
}

/// R⁻¹ = Rᵀ.
///
/// # Shapes
/// - `rotation`: `[N, 3, 3]`
/// - output: `[N, 3, 3]`
pub fn inverse(rotation: Tensor<3>) -> Tensor<3> {
    rotation.swap_dims(1, 2)
}

/// R x.
///
/// # Shapes
/// - `rotation`: `[N, 3, 3]`
/// - `vector`: `[N, 3]`
/// - output: `[N, 3]`
pub fn act(rotation: Tensor<3>, vector: Tensor<2>) -> Tensor<2> {
    let [n, _] = vector.dims();
    rotation.mul(vector.reshape([n, 1, 3])).sum_dim(2).reshape([n, 3])
}

/// R⁻¹ x = Rᵀ x.
///
/// # Shapes
/// - `rotation`: `[N, 3, 3]`
/// - `vector`: `[N, 3]`
/// - output: `[N, 3]`
pub fn act_inverse(rotation: Tensor<3>, vector: Tensor<2>) -> Tensor<2> {
    let [n, _] = vector.dims();
    rotation.mul(vector.reshape([n, 3, 1])).sum_dim(1).reshape([n, 3])
}

/// The left Jacobian J_l(ω), with Exp(ω + δ) ≈ Exp(J_l(ω) δ) Exp(ω) (eq. 145).
///
/// J_l = (sin θ/θ) I + ((1 − cos θ)/θ²) ω̂ + ((θ − sin θ)/θ³) ω ωᵀ.
///
/// # Shapes
/// - `omega`: `[N, 3]`, rad
/// - output: `[N, 3, 3]`
pub fn left_jacobian(omega: Tensor<2>) -> Tensor<3> {
    let half = HalfAngle::new(omega.clone());
    axisymmetric(
        half.sin_over_angle(),
        half.one_minus_cos_over_angle_squared().mul(omega.clone()),
        half.angle_minus_sin_over_angle_cubed(),
        omega,
    )
}

/// The inverse of the left Jacobian for ‖ω‖ < 2π (eq. 146).
///
/// J_l⁻¹ = (1 − D θ²) I − ω̂/2 + D ω ωᵀ with D = (1 − (θ/2) cot(θ/2))/θ².
///
/// # Shapes
/// - `omega`: `[N, 3]`, rad
/// - output: `[N, 3, 3]`
pub fn left_jacobian_inverse(omega: Tensor<2>) -> Tensor<3> {
    let half = HalfAngle::new(omega.clone());
    let outer = half.inverse_jacobian_coefficient();
    let diagonal = -(outer.clone() * half.angle_squared()) + 1.0;
    axisymmetric(diagonal, omega.clone() * -0.5, outer, omega)
}

/// a I + v̂ + c ω ωᵀ, with a and c `[N, 1]`.
fn axisymmetric(diagonal: Tensor<2>, skew: Tensor<2>, outer: Tensor<2>, omega: Tensor<2>) -> Tensor<3> {
    let [n, _] = omega.dims();
    let scaled = (outer * omega.clone()).reshape([n, 3, 1]);
    let flat = diagonal * flat_identity(&omega) + flat_hat(skew);
    flat.reshape([n, 3, 3]) + scaled * omega.reshape([n, 1, 3])
}

fn flat_hat(omega: Tensor<2>) -> Tensor<2> {
    let generators = constant(GENERATORS.as_flattened(), [3, 9], &omega);
    omega.matmul(generators)
}
