//! SO(3) and SE(3) batched on burn tensors, with gradients that stay finite at 0 and at pi.
//!
//! Every map takes a flat batch axis N: rotation matrices `[N, 3, 3]`, vectors `[N, 3]`, quaternions `[N, 4]` in the
//! order x, y, z, w, twists `[N, 6]` with the angular part first. Constants are made on the device and in the float
//! type of the argument, so that f32 and f64 tensors go through the same code.
//!
//! The gradients meant are those along the group, that is of ε ↦ f(R Exp(ε)): a derivative towards matrices that are
//! no rotations has no meaning here. Branches are chosen by masks whose unselected side is computed from a harmless
//! input, because a mask that merely hides a NaN does not stop it on the way back.

mod constant;
mod series;

pub mod geodesic;
pub mod gram_schmidt;
pub mod metric;
pub mod quaternion;
pub mod se3;
pub mod so3;

pub use gram_schmidt::gram_schmidt;
pub use metric::{GeodesicDistance, chordal_distance_squared, geodesic_distance, rotation_angle};
pub use se3::SE3Tensor;
