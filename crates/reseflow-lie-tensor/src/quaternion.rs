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

/// The unit quaternion of a rotation, with w ≥ 0.
///
/// Row i of 4 q qᵀ is 4 qᵢ q. The row with the largest diagonal entry is gathered and normalised; its norm is at least
/// 1 whatever the matrix, so nothing can divide by zero, and the other rows get no gradient. At a half-turn, where
/// q and −q are equally good, the component of largest magnitude is positive; |w| within rounding counts as a
/// half-turn, so that the choice does not hang on the last bit.
///
/// # Shapes
/// - `rotation`: `[N, 3, 3]`
/// - output: `[N, 4]`, order x, y, z, w
pub fn from_matrix(rotation: Tensor<3>) -> Tensor<2> {
    let [n, _, _] = rotation.dims();
    let map = constant(QUATERNION_OUTER_FROM_MATRIX.as_flattened(), [9, 16], &rotation);
    let outer = rotation.reshape([n, 9]).matmul(map);
    let diagonal = outer.clone().detach().slice(s![.., 0..16;5]);
    let row = diagonal.argmax(1).reshape([n, 1, 1]).repeat_dim(2, 4);
    // 4 q qᵀ is affine in R; the constant part is the identity.
    let identity = constant(&IDENTITY_4, [1, 16], &outer);
    let scaled = (outer + identity).reshape([n, 4, 4]).gather(1, row).reshape([n, 4]);

    let norm = squared_norm(scaled.clone()).sqrt();
    let half_turn = HALF_TURN_EPSILONS * epsilon(scaled.dtype());
    let w = scaled.clone().detach().slice(s![.., 3..4]);
    let flipped = w.clone().lower_elem(-half_turn);
    scaled / norm.mul(w.ones_like().mask_fill(flipped, -1.0))
}

const IDENTITY_4: [f64; 16] = [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.];

/// How many roundings of 4 |qᵢ| w still count as w = 0.
const HALF_TURN_EPSILONS: f64 = 16.0;

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
    // The adjoint of the map above: ⟨R, q qᵀ-part⟩ has the same table.
    let map = constant(QUATERNION_OUTER_FROM_MATRIX.as_flattened(), [9, 16], &outer).transpose();
    outer.reshape([n, 16]).matmul(map).reshape([n, 3, 3])
}

/// The rotation vector of a unit quaternion with w ≥ 0: 2 atan2(‖v‖, w) v / ‖v‖, of norm at most π.
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
