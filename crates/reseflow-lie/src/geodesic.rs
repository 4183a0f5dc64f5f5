//! The two geodesics of SE(3), each with its displacement and its retraction.
//!
//! - *screw*: H^t = H⁰ Exp(t ξ_b), ξ_b = Log((H⁰)⁻¹ H¹), the ReSeFlow paper's geodesic in body form. A constant
//!   twist: exact on a door's arc.
//! - *product*: the geodesic of SO(3) × ℝ³, the one that D_geo measures: the origin moves on a straight line.

use crate::{BodyTwist, SE3, SO3, SpatialTwist};

impl SE3 {
    /// X Exp(ξ_b): the pose after moving with a constant body twist for a unit of time.
    pub fn plus(&self, twist: &BodyTwist) -> SE3 {
        self.compose(&SE3::exp(twist))
    }

    /// Exp(ξ_s) X: the pose after moving with a constant spatial twist for a unit of time.
    pub fn plus_spatial(&self, twist: &SpatialTwist) -> SE3 {
        SE3::exp_spatial(twist).compose(self)
    }

    /// ξ_b = Log(X⁻¹ Y), with X.plus(ξ_b) = Y; the same whatever the world frame.
    pub fn body_twist_to(&self, other: &SE3) -> BodyTwist {
        self.inverse().compose(other).log()
    }

    /// ξ_s = Log(Y X⁻¹), the ReSeFlow paper's Y ⊖ X, with X.plus_spatial(ξ_s) = Y.
    ///
    /// ```
    /// use reseflow_lie::{SE3, SO3, Vector3};
    ///
    /// let from = SE3::new(SO3::exp(&Vector3::new(0.1, 0.7, -0.4)), Vector3::new(1.0, 2.0, 3.0));
    /// let to = SE3::new(SO3::exp(&Vector3::new(-0.9, 0.2, 0.5)), Vector3::new(0.5, 1.0, -1.0));
    /// let spatial = from.spatial_twist_to(&to);
    /// assert!((spatial - from.body_twist_to(&to).to_spatial(&from)).vector6().norm() < 1e-13);
    /// ```
    pub fn spatial_twist_to(&self, other: &SE3) -> SpatialTwist {
        other.compose(&self.inverse()).log_spatial()
    }

    /// The screw geodesic X Exp(s Log(X⁻¹ Y)): `self` at s = 0, `other` at s = 1.
    pub fn interpolate_screw(&self, other: &SE3, s: f64) -> SE3 {
        self.plus(&(self.body_twist_to(other) * s))
    }

    /// The product retraction (R Exp(ω), p + R ρ): like [`SE3::plus`], but the origin moves on a straight line.
    pub fn plus_product(&self, displacement: &BodyTwist) -> SE3 {
        SE3::new(
            self.rotation.compose(&SO3::exp(&displacement.angular)),
            self.translation + self.rotation.act(&displacement.linear),
        )
    }

    /// (Log(RᵀR′), Rᵀ(p′ − p)), with X.plus_product(displacement) = Y; the same whatever the world frame.
    pub fn product_displacement_to(&self, other: &SE3) -> BodyTwist {
        let body_from_world = self.rotation.inverse();
        BodyTwist::new(
            body_from_world.compose(&other.rotation).log(),
            body_from_world.act(&(other.translation - self.translation)),
        )
    }

    /// The product geodesic (R Exp(s Log(RᵀR′)), p + s(p′ − p)): `self` at s = 0, `other` at s = 1.
    pub fn interpolate_product(&self, other: &SE3, s: f64) -> SE3 {
        SE3::new(
            self.rotation.interpolate(&other.rotation, s),
            self.translation + (other.translation - self.translation) * s,
        )
    }
}
