//! A rotation from two vectors, by Gram–Schmidt (Zhou et al., *On the continuity of rotation representations*, 2019).

use crate::{LieError, SO3};
use nalgebra::{Matrix3, Vector3};

/// Sine of the angle between the vectors, and their length, below which a frame has no meaning in f64.
const DEGENERATE: f64 = 1e-12;

impl SO3 {
    /// The rotation whose first column is a/‖a‖, whose second is b less its part along it, normalised, and whose
    /// third is their cross product.
    ///
    /// It is equivariant: turning a and b by g turns the result to gR.
    ///
    /// # Errors
    ///
    /// A non-finite component, a vector of length 0 (below 1e-12), or parallel vectors (sine below 1e-12).
    ///
    /// ```
    /// use reseflow_lie::{SO3, Vector3};
    ///
    /// let rotation = SO3::gram_schmidt(&Vector3::new(0.0, 2.0, 0.0), &Vector3::new(-1.0, 5.0, 0.0))?;
    /// assert!((rotation.log() - Vector3::z() * std::f64::consts::FRAC_PI_2).norm() < 1e-15);
    /// # Ok::<(), reseflow_lie::LieError>(())
    /// ```
    pub fn gram_schmidt(a: &Vector3<f64>, b: &Vector3<f64>) -> Result<SO3, LieError> {
        if !a.iter().chain(b.iter()).all(|component| component.is_finite()) {
            return Err(LieError::NonFinite { what: "the columns of a frame" });
        }
        let (first, second) = (a.norm(), b.norm());
        if first < DEGENERATE || second < DEGENERATE {
            return Err(LieError::DegenerateFrame { first, second, sine: 0.0 });
        }
        let (x, direction) = (a / first, b / second);
        let across = direction - x * x.dot(&direction);
        let sine = across.norm();
        if sine < DEGENERATE {
            return Err(LieError::DegenerateFrame { first, second, sine });
        }
        // Once more: when a and b are nearly parallel, one projection leaves a part along x of the size of rounding/sine.
        let across = across / sine;
        let y = (across - x * x.dot(&across)).normalize();
        Ok(SO3::from_orthonormal(&Matrix3::from_columns(&[x, y, x.cross(&y)])))
    }
}
