//! Poses: the group SE(3) of rotations and translations.
//!
//! Solà, Deray, Atchuthan, *A micro Lie theory*, example 6 and appendix D (reordered to angular first).

use crate::{BodyTwist, LieError, SO3, SpatialTwist};
use nalgebra::{Matrix4, Matrix6, Vector3};

/// Largest deviation of a homogeneous matrix's last row from (0, 0, 0, 1) accepted on reading.
const BOTTOM_ROW_TOLERANCE: f64 = 1e-5;

/// A pose X = (R, p) ∈ SE(3), `target_from_source`: x ↦ R x + p.
///
/// - Tangent: ξ = (ω, ρ) ∈ ℝ⁶, angular first, radian and metre; hat(ξ) = \[\[ω\]×, ρ; 0, 0\].
/// - Matrix: \[R, p; 0, 1\].
/// - Exp(ξ) = (Exp(ω), J_l(ω) ρ), with J_l the left Jacobian of SO(3).
/// - Ad_X = \[R, 0; \[p\]× R, R\], that is X Exp(ξ) X⁻¹ = Exp(Ad_X ξ).
///
/// ```
/// use reseflow_lie::{BodyTwist, SE3, SO3, Vector3};
///
/// let twist = BodyTwist::new(Vector3::new(0.3, -0.2, 0.5), Vector3::new(1.0, 2.0, -3.0));
/// let pose = SE3::exp(&twist);
/// assert_eq!(pose.rotation, SO3::exp(&twist.angular));
/// assert_eq!(pose.translation, SO3::left_jacobian(&twist.angular) * twist.linear);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SE3 {
    /// R.
    pub rotation: SO3,
    /// p, metre: the source frame's origin in the target frame.
    pub translation: Vector3<f64>,
}

impl SE3 {
    /// The pose (R, p).
    pub fn new(rotation: SO3, translation: Vector3<f64>) -> SE3 {
        SE3 { rotation, translation }
    }

    /// The pose that moves nothing.
    pub fn identity() -> SE3 {
        SE3::new(SO3::identity(), Vector3::zeros())
    }

    /// Exp of a body twist: where a body that starts at the identity is after moving with it for a unit of time.
    pub fn exp(twist: &BodyTwist) -> SE3 {
        SE3::exp_parts(&twist.angular, &twist.linear)
    }

    /// Exp of a spatial twist: the displacement g of world space for which X ↦ gX moves a body by that twist.
    pub fn exp_spatial(twist: &SpatialTwist) -> SE3 {
        SE3::exp_parts(&twist.angular, &twist.linear)
    }

    fn exp_parts(angular: &Vector3<f64>, linear: &Vector3<f64>) -> SE3 {
        SE3::new(SO3::exp(angular), SO3::left_jacobian(angular) * linear)
    }

    /// Log as a body twist: the inverse of [`SE3::exp`], on the branch that [`SO3::log`] documents.
    pub fn log(&self) -> BodyTwist {
        let (angular, linear) = self.log_parts();
        BodyTwist::new(angular, linear)
    }

    /// Log as a spatial twist: the inverse of [`SE3::exp_spatial`].
    pub fn log_spatial(&self) -> SpatialTwist {
        let (angular, linear) = self.log_parts();
        SpatialTwist::new(angular, linear)
    }

    fn log_parts(&self) -> (Vector3<f64>, Vector3<f64>) {
        let angular = self.rotation.log();
        (angular, SO3::left_jacobian_inverse(&angular) * self.translation)
    }

    /// Reads a homogeneous matrix; the rotation block is replaced by the nearest rotation.
    ///
    /// # Errors
    ///
    /// A non-finite entry, a bottom row other than (0, 0, 0, 1), or what [`SO3::from_matrix`] refuses.
    pub fn from_matrix(matrix: &Matrix4<f64>) -> Result<SE3, LieError> {
        if !matrix.iter().all(|entry| entry.is_finite()) {
            return Err(LieError::NonFinite { what: "a pose matrix" });
        }
        let row = [matrix[(3, 0)], matrix[(3, 1)], matrix[(3, 2)], matrix[(3, 3)]];
        let expected = [0.0, 0.0, 0.0, 1.0];
        if row.iter().zip(expected).any(|(got, want)| (got - want).abs() > BOTTOM_ROW_TOLERANCE) {
            return Err(LieError::BottomRow { row });
        }
        let rotation = SO3::from_matrix(&matrix.fixed_view::<3, 3>(0, 0).into_owned())?;
        Ok(SE3::new(rotation, matrix.fixed_view::<3, 1>(0, 3).into_owned()))
    }

    /// The homogeneous matrix \[R, p; 0, 1\].
    pub fn matrix(&self) -> Matrix4<f64> {
        let mut matrix = self.rotation.matrix().to_homogeneous();
        matrix.fixed_view_mut::<3, 1>(0, 3).copy_from(&self.translation);
        matrix
    }

    /// X⁻¹ = (Rᵀ, −Rᵀ p).
    pub fn inverse(&self) -> SE3 {
        let rotation = self.rotation.inverse();
        SE3::new(rotation, -rotation.act(&self.translation))
    }

    /// The product that `*` stands for: (R R′, p + R p′).
    pub(crate) fn compose(&self, right: &SE3) -> SE3 {
        SE3::new(self.rotation.compose(&right.rotation), self.act(&right.translation))
    }

    /// R x + p: the point's coordinates in the target frame, metre.
    pub fn act(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.rotation.act(point) + self.translation
    }

    /// Ad_X = \[R, 0; \[p\]× R, R\], the matrix with X Exp(ξ) X⁻¹ = Exp(Ad_X ξ).
    pub fn adjoint(&self) -> Matrix6<f64> {
        let rotation = self.rotation.matrix();
        let mut adjoint = Matrix6::zeros();
        adjoint.fixed_view_mut::<3, 3>(0, 0).copy_from(&rotation);
        adjoint.fixed_view_mut::<3, 3>(3, 0).copy_from(&(self.translation.cross_matrix() * rotation));
        adjoint.fixed_view_mut::<3, 3>(3, 3).copy_from(&rotation);
        adjoint
    }

    /// Ad_X (ω, ρ) = (R ω, R ρ + p × R ω), without the matrix.
    pub(crate) fn adjoint_parts(
        &self,
        angular: &Vector3<f64>,
        linear: &Vector3<f64>,
    ) -> (Vector3<f64>, Vector3<f64>) {
        let turned = self.rotation.act(angular);
        (turned, self.rotation.act(linear) + self.translation.cross(&turned))
    }

    /// Whether every component is finite.
    pub fn is_finite(&self) -> bool {
        self.rotation.is_finite() && self.translation.iter().all(|component| component.is_finite())
    }
}
