//! Unit quaternions (x, y, z, w) and rotation matrices.
//!
//! Both ways are linear maps between the nine entries of R and the sixteen of 4 q qᵀ, so each is one matrix product
//! (Bar-Itzhack 2000, "New method for extracting the quaternion from a rotation matrix"; the row with the largest
//! diagonal entry is Shepperd's choice, 1978).

use burn::tensor::{Tensor, s};

use crate::constant::{constant, epsilon};
use crate::series::{angle_over_half_sine, squared_norm};

/// Column j holds what each entry of R, row-major, contributes to entry j of 4 q qᵀ, row-major.
const QUATERNION_OUTER_FROM_MATRIX: [[f64; 16]; 9] = [
    [1., 0., 0., 0., 0., -1., 0., 0., 0., 0., -1., 0., 0., 0., 0., 1.], // R₀₀
    [0., 1., 0., 0., 1., 0., 0., 0., 0., 0., 0., -1., 0., 0., -1., 0.], // R₀₁
    [0., 0., 1., 0., 0., 0., 0., 1., 1., 0., 0., 0., 0., 1., 0., 0.],   // R₀₂
    [0., 1., 0., 0., 1., 0., 0., 0., 0., 0., 0., 1., 0., 0., 1., 0.],   // R₁₀
    [-1., 0., 0., 0., 0., 1., 0., 0., 0., 0., -1., 0., 0., 0., 0., 1.], // R₁₁
    [0., 0., 0., -1., 0., 0., 1., 0., 0., 1., 0., 0., -1., 0., 0., 0.], // R₁₂
    [0., 0., 1., 0., 0., 0., 0., -1., 1., 0., 0., 0., 0., -1., 0., 0.], // R₂₀
    [0., 0., 0., 1., 0., 0., 1., 0., 0., 1., 0., 0., 1., 0., 0., 0.],   // R₂₁
    [-1., 0., 0., 0., 0., -1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.], // R₂₂
];

/// Row-major identity: the part of 4 q qᵀ that does not depend on R.
const IDENTITY: [f64; 16] = [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.];

/// |w| at or below which a rotation counts as a half-turn, and a component of its axis as zero. The scalar group in
/// `reseflow-lie` has the same; float types that are coarser take this many roundings instead.
const HALF_TURN_TOLERANCE: f64 = 1e-13;
const AXIS_TOLERANCE: f64 = 1e-7;
const ROUNDINGS: f64 = 16.0;

/// The unit quaternion of a rotation, with w ≥ 0 but for rounding at a half-turn.
///
/// Row i of 4 q qᵀ is 4 qᵢ q. The row with the largest diagonal entry is gathered and normalised; its norm is at least
/// 1 whatever the matrix, so nothing can divide by zero, and the other rows get no gradient.
///
/// At a half-turn q and −q are equally good. There (w = 0 up to rounding) the first non-zero component in the order
/// x, y, z is positive. Rounding counts as none, so that the choice does not hang on the last bit.
///
/// # Shapes
/// - `rotation`: `[N, 3, 3]`
/// - output: `[N, 4]`, order x, y, z, w
pub fn from_matrix(rotation: Tensor<3>) -> Tensor<2> {
    let [n, _, _] = rotation.dims();
    let map = constant(QUATERNION_OUTER_FROM_MATRIX.as_flattened(), [9, 16], &rotation);
    let offset = constant(&IDENTITY, [1, 16], &rotation);
    let outer = rotation.reshape([n, 9]).matmul(map) + offset;
    let largest = outer.clone().detach().slice(s![.., 0..16;5]).argmax(1);
    let row = largest.reshape([n, 1, 1]).repeat_dim(2, 4);
    let scaled = outer.reshape([n, 4, 4]).gather(1, row).reshape([n, 4]);
    let quaternion = scaled.clone() / squared_norm(scaled).sqrt();
    let sign = branch_sign(quaternion.clone().detach());
    quaternion * sign
}

/// −1 where q has to be negated to be the one that [`from_matrix`] documents, else 1; `[N, 1]`.
fn branch_sign(quaternion: Tensor<2>) -> Tensor<2> {
    let rounding = ROUNDINGS * epsilon(quaternion.dtype());
    let (axis, half_turn) = (AXIS_TOLERANCE.max(rounding), HALF_TURN_TOLERANCE.max(rounding));
    let tolerance = constant(&[axis, axis, axis, half_turn], [1, 4], &quaternion);
    let vanishes = quaternion.clone().abs().lower_equal(tolerance.expand(quaternion.dims()));
    // A sum of signs in which each component outweighs all that come after it: w, then x, y, z.
    let weights = constant(&[4.0, 2.0, 1.0, 8.0], [4, 1], &quaternion);
    let decisive = quaternion.sign().mask_fill(vanishes, 0.0).matmul(weights);
    decisive.ones_like().mask_fill(decisive.lower_elem(0.0), -1.0)
}

/// The rotation matrix of a unit quaternion.
///
/// R = (w² − v·v) I + 2 v vᵀ + 2 w v̂ for q = (v, w).
///
/// # Shapes
/// - `quaternion`: `[N, 4]`, order x, y, z, w, of norm 1
/// - output: `[N, 3, 3]`
pub fn to_matrix(quaternion: Tensor<2>) -> Tensor<3> {
    let [n, _] = quaternion.dims();
    let outer = quaternion.clone().reshape([n, 4, 1]).mul(quaternion.reshape([n, 1, 4]));
    let map = constant(QUATERNION_OUTER_FROM_MATRIX.as_flattened(), [9, 16], &outer).transpose();
    outer.reshape([n, 16]).matmul(map).reshape([n, 3, 3])
}

/// The rotation vector of a unit quaternion as [`from_matrix`] gives it: 2 atan2(‖v‖, w) v / ‖v‖, of norm at most π (up to rounding).
///
/// # Shapes
/// - `quaternion`: `[N, 4]`, order x, y, z, w, of norm 1
/// - output: `[N, 3]`, rad
pub fn to_rotation_vector(quaternion: Tensor<2>) -> Tensor<2> {
    let [vector, scalar] = split(quaternion);
    let factor = angle_over_half_sine(squared_norm(vector.clone()), scalar);
    vector * factor
}

/// The vector part `[N, 3]` and the scalar part `[N, 1]`.
pub(crate) fn split(quaternion: Tensor<2>) -> [Tensor<2>; 2] {
    [quaternion.clone().slice(s![.., 0..3]), quaternion.slice(s![.., 3..4])]
}
