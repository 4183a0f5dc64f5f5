//! Rotations: the group SO(3), kept as a unit quaternion.
//!
//! Solà, Deray, Atchuthan, *A micro Lie theory for state estimation in robotics*, examples 3 and 4 and appendix B.

use crate::LieError;
use crate::coefficients::sinc;
use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};

/// Largest entry of |RᵀR − I|, and largest deviation of a quaternion's norm, accepted on reading.
pub(crate) const READ_TOLERANCE: f64 = 1e-3;

/// |w| at or below which a rotation counts as a half turn, where the logarithm has two values. It is far above the
/// rounding of a few products, so that a half turn measured in a body frame keeps its branch when the world is turned.
const HALF_TURN_TOLERANCE: f64 = 1e-13;

/// Component of a half turn's axis at or below which it counts as zero when the branch is chosen.
const AXIS_TOLERANCE: f64 = 1e-7;

/// |sin(θ/2)| below which 2 atan2(sin, cos)/sin is 2/cos to the last bit.
const SMALL_SINE: f64 = 1e-9;

/// A rotation R ∈ SO(3), `target_from_source`.
///
/// - Tangent: ω ∈ ℝ³, radian; hat(ω) = \[ω\]×.
/// - Exp(ω) = I + (sin θ/θ) \[ω\]× + ((1 − cos θ)/θ²) \[ω\]×², θ = ‖ω‖.
/// - Ad_R = R, that is R Exp(ω) R⁻¹ = Exp(R ω).
///
/// Equality is that of rotations: q and −q are equal.
///
/// ```
/// use reseflow_lie::{Matrix3, SO3, Vector3};
///
/// let omega: Vector3<f64> = Vector3::new(0.3, -0.2, 0.5);
/// let (theta, hat) = (omega.norm(), omega.cross_matrix());
/// let (first, second) = (theta.sin() / theta, (1.0 - theta.cos()) / theta.powi(2));
/// let rodrigues = Matrix3::identity() + hat * first + hat * hat * second;
/// assert!((SO3::exp(&omega).matrix() - rodrigues).norm() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SO3 {
    quaternion: UnitQuaternion<f64>,
}

impl SO3 {
    /// The rotation that turns nothing.
    pub fn identity() -> SO3 {
        SO3 { quaternion: UnitQuaternion::identity() }
    }

    /// Exp: the rotation by ‖ω‖ radians about ω.
    pub fn exp(omega: &Vector3<f64>) -> SO3 {
        let half = 0.5 * omega.norm();
        let vector = omega * (0.5 * sinc(half));
        SO3::from_unit(Quaternion::from_parts(half.cos(), vector))
    }

    /// Log: the shortest rotation vector ω with Exp(ω) = R, ‖ω‖ ≤ π.
    ///
    /// A half turn has two, ±ω. There (up to rounding, |cos(θ/2)| ≤ 1e-13) the branch is the one whose first non-zero
    /// component, in the order x, y, z, is positive, and ‖ω‖ may exceed π by that rounding. The axis of R₀⁻¹R₁ is
    /// given in body coordinates, so a change of world frame does not change the branch.
    ///
    /// ```
    /// use reseflow_lie::{SO3, Vector3};
    /// use std::f64::consts::PI;
    ///
    /// let omega = SO3::exp(&Vector3::new(0.0, -PI, 0.0)).log();
    /// assert!((omega - Vector3::new(0.0, PI, 0.0)).norm() < 1e-12);
    /// ```
    pub fn log(&self) -> Vector3<f64> {
        let (w, vector) = self.principal_parts();
        let sine = vector.norm();
        let factor = if sine < SMALL_SINE { 2.0 / w } else { 2.0 * sine.atan2(w) / sine };
        vector * factor
    }

    /// The quaternion's (w, vector) with the sign of the branch that [`SO3::log`] documents.
    fn principal_parts(&self) -> (f64, Vector3<f64>) {
        let w = self.quaternion.w;
        let vector = self.quaternion.vector().into_owned();
        let decisive = if w.abs() > HALF_TURN_TOLERANCE {
            w
        } else {
            vector.iter().copied().find(|component| component.abs() > AXIS_TOLERANCE).unwrap_or(1.0)
        };
        if decisive < 0.0 { (-w, -vector) } else { (w, vector) }
    }

    /// Reads a rotation matrix, and replaces it by the nearest rotation.
    ///
    /// # Errors
    ///
    /// A non-finite entry, a reflection, or a matrix with an entry of |RᵀR − I| above 1e-3 (files hold f32).
    pub fn from_matrix(matrix: &Matrix3<f64>) -> Result<SO3, LieError> {
        if !matrix.iter().all(|entry| entry.is_finite()) {
            return Err(LieError::NonFinite { what: "a rotation matrix" });
        }
        let deviation = (matrix.transpose() * matrix - Matrix3::identity()).amax();
        if deviation > READ_TOLERANCE {
            return Err(LieError::NotOrthonormal { deviation, tolerance: READ_TOLERANCE });
        }
        let determinant = matrix.determinant();
        if determinant < 0.0 {
            return Err(LieError::Reflection { determinant });
        }
        Ok(SO3::from_orthonormal(&nearest_orthonormal(*matrix)))
    }

    /// The rotation with a matrix known to be orthonormal to rounding, determinant 1.
    pub(crate) fn from_orthonormal(matrix: &Matrix3<f64>) -> SO3 {
        let rotation = Rotation3::from_matrix_unchecked(*matrix);
        SO3::from_unit(UnitQuaternion::from_rotation_matrix(&rotation).into_inner())
    }

    /// The rotation with a quaternion known to be of unit norm to rounding; the rounding is taken out.
    pub(crate) fn from_unit(quaternion: Quaternion<f64>) -> SO3 {
        SO3 { quaternion: UnitQuaternion::new_normalize(quaternion) }
    }

    /// The rotation matrix; its columns are the source frame's axes in the target frame.
    pub fn matrix(&self) -> Matrix3<f64> {
        self.quaternion.to_rotation_matrix().into_inner()
    }

    /// Reads a quaternion in the order x, y, z, w and normalises it.
    ///
    /// # Errors
    ///
    /// A non-finite component, or a norm further than 1e-3 from 1.
    pub fn from_quaternion_xyzw(xyzw: [f64; 4]) -> Result<SO3, LieError> {
        if !xyzw.iter().all(|component| component.is_finite()) {
            return Err(LieError::NonFinite { what: "a quaternion" });
        }
        let quaternion = Quaternion::from(xyzw);
        let norm = quaternion.norm();
        if (norm - 1.0).abs() > READ_TOLERANCE {
            return Err(LieError::NotUnitQuaternion { norm, tolerance: READ_TOLERANCE });
        }
        Ok(SO3::from_unit(quaternion))
    }

    /// The unit quaternion in the order x, y, z, w, its sign the one of [`SO3::log`] (w ≥ 0 but at a half turn).
    pub fn quaternion_xyzw(&self) -> [f64; 4] {
        let (w, vector) = self.principal_parts();
        [vector.x, vector.y, vector.z, w]
    }

    /// R⁻¹ = Rᵀ.
    pub fn inverse(&self) -> SO3 {
        SO3 { quaternion: self.quaternion.inverse() }
    }

    /// The product that `*` stands for, kept at unit norm however long the chain.
    pub(crate) fn compose(&self, right: &SO3) -> SO3 {
        let mut quaternion = self.quaternion * right.quaternion;
        quaternion.renormalize_fast();
        SO3 { quaternion }
    }

    /// R p: the vector's components in the target frame.
    pub fn act(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.quaternion * point
    }

    /// The angle of rotation, radian, in \[0, π\].
    pub fn angle(&self) -> f64 {
        2.0 * self.quaternion.vector().norm().atan2(self.quaternion.w.abs())
    }

    /// Ad_R, the matrix with R Exp(ω) R⁻¹ = Exp(Ad_R ω); for rotations it is R.
    pub fn adjoint(&self) -> Matrix3<f64> {
        self.matrix()
    }

    /// Whether every component is finite.
    pub fn is_finite(&self) -> bool {
        self.quaternion.coords.iter().all(|component| component.is_finite())
    }

    /// The geodesic R Exp(s Log(R⁻¹ R′)): `self` at s = 0, `other` at s = 1, at constant speed.
    pub fn interpolate(&self, other: &SO3, s: f64) -> SO3 {
        self.compose(&SO3::exp(&((self.inverse() * other).log() * s)))
    }
}

/// The orthonormal polar factor, by Newton's iteration X ← (X + X⁻ᵀ)/2 (Higham, *Functions of Matrices*, section 8.3).
///
/// It squares the deviation at each step: the 1.5e-3 of a singular value that is admitted here goes to 1e-6, to 1e-12 and
/// to rounding.
fn nearest_orthonormal(matrix: Matrix3<f64>) -> Matrix3<f64> {
    (0..3).fold(matrix, |estimate, _| match estimate.try_inverse() {
        Some(inverse) => (estimate + inverse.transpose()) * 0.5,
        None => estimate,
    })
}
