//! Distances between rotations and between poses.

use burn::tensor::Tensor;

use crate::quaternion;
use crate::se3::SE3Tensor;
use crate::series::{safe_sqrt, squared_norm};
use crate::so3;

/// The angle of RₐᵀR_b in \[0, π\] (up to rounding), with gradient 0 where the rotations agree.
///
/// 2 atan2(‖v‖, w) of the relative quaternion: accurate at every angle, where `acos` of the trace is not.
///
/// # Shapes
/// - `a`, `b`: `[N, 3, 3]`
/// - output: `[N]`, rad
pub fn rotation_angle(a: Tensor<3>, b: Tensor<3>) -> Tensor<1> {
    let quaternion = quaternion::from_matrix(so3::between(a, b));
    let [vector, scalar] = quaternion::split(quaternion);
    let sine = safe_sqrt(squared_norm(vector));
    (sine.atan2(scalar) * 2.0).squeeze_dim(1)
}

/// ‖Rₐ − R_b‖²_F = 8 sin²(θ/2), smooth everywhere.
///
/// # Shapes
/// - `a`, `b`: `[N, 3, 3]`
/// - output: `[N]`
pub fn chordal_distance_squared(a: Tensor<3>, b: Tensor<3>) -> Tensor<1> {
    let [n, _, _] = a.dims();
    squared_norm((a - b).reshape([n, 9])).squeeze_dim(1)
}

/// D_geo with its two parts, each `[N]`.
#[derive(Debug, Clone)]
pub struct GeodesicDistance {
    /// √(rotation_rad² + translation_m²), radians and metres mixed as the ReSeFlow paper has it.
    pub d_geo: Tensor<1>,
    /// The angle between the rotations, rad.
    pub rotation_rad: Tensor<1>,
    /// The distance between the positions, metres.
    pub translation_m: Tensor<1>,
}

/// D_geo(X, Y) = √(‖Log(R_xᵀR_y)‖² + ‖p_y − p_x‖²) (the ReSeFlow paper, eq. D_geo), with gradient 0 where X = Y.
///
/// # Shapes
/// - output: `[N]` each
pub fn geodesic_distance(x: &SE3Tensor, y: &SE3Tensor) -> GeodesicDistance {
    let rotation_rad = rotation_angle(x.rotation.clone(), y.rotation.clone());
    let translation_squared: Tensor<1> =
        squared_norm(y.translation.clone() - x.translation.clone()).squeeze_dim(1);
    let d_geo = safe_sqrt(rotation_rad.clone() * rotation_rad.clone() + translation_squared.clone());
    GeodesicDistance { d_geo, rotation_rad, translation_m: safe_sqrt(translation_squared) }
}
