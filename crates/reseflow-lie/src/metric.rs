//! D_geo, the distance the ReSeFlow paper reports (its equation "dgeo"), with its rad and m parts beside it.

use crate::SE3;

/// How far apart two poses are, in the product metric of SO(3) × ℝ³.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GeodesicDistance {
    /// ‖Log(RᵀR̂)‖: the angle between the orientations, radian, in \[0, π\].
    pub rotation_rad: f64,
    /// ‖p̂ − p‖: the distance between the origins, metre.
    pub translation_m: f64,
}

impl GeodesicDistance {
    /// D_geo = √(‖Log(RᵀR̂)‖² + ‖p̂ − p‖²); the paper adds radians and metres as they are.
    ///
    /// ```
    /// use reseflow_lie::{SE3, SO3, Vector3, geodesic_distance};
    ///
    /// let predicted = SE3::new(SO3::exp(&Vector3::new(0.0, 0.0, 0.3)), Vector3::new(1.0, 1.0, 1.0));
    /// let truth = SE3::new(SO3::exp(&Vector3::new(0.0, 0.0, 0.6)), Vector3::new(1.0, 1.4, 1.0));
    /// assert!((geodesic_distance(&predicted, &truth).d_geo() - 0.5).abs() < 1e-15);
    /// ```
    pub fn d_geo(&self) -> f64 {
        self.rotation_rad.hypot(self.translation_m)
    }
}

/// The distance between two poses. It is a metric, and a change of world frame leaves it as it is.
pub fn geodesic_distance(predicted: &SE3, truth: &SE3) -> GeodesicDistance {
    GeodesicDistance {
        rotation_rad: (predicted.rotation.inverse() * truth.rotation).angle(),
        translation_m: (truth.translation - predicted.translation).norm(),
    }
}
