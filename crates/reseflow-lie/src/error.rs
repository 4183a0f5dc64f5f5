//! What can be wrong with numbers that claim to be a rotation, a pose or a set to average.

/// A fault in what was handed to this crate. Every message says what was expected and what was got.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LieError {
    /// A component is NaN or infinite.
    #[error("expected finite numbers for {what}, got NaN or infinity")]
    NonFinite {
        /// What was being read.
        what: &'static str,
    },
    /// RᵀR is too far from the identity: scaled, sheared or rounded beyond what f32 explains.
    #[error(
        "expected an orthonormal matrix (largest entry of |RᵀR − I| at most {tolerance}), got {deviation}"
    )]
    NotOrthonormal {
        /// The largest entry of |RᵀR − I|.
        deviation: f64,
        /// The largest deviation accepted.
        tolerance: f64,
    },
    /// The matrix is orthonormal with determinant −1.
    #[error("expected a rotation (determinant 1), got a reflection (determinant {determinant})")]
    Reflection {
        /// The determinant.
        determinant: f64,
    },
    /// The quaternion's norm is not 1.
    #[error("expected a unit quaternion (norm within {tolerance} of 1), got norm {norm}")]
    NotUnitQuaternion {
        /// The norm.
        norm: f64,
        /// The largest deviation accepted.
        tolerance: f64,
    },
    /// The last row of a homogeneous matrix is not (0, 0, 0, 1).
    #[error("expected the bottom row (0, 0, 0, 1), got ({}, {}, {}, {})", row[0], row[1], row[2], row[3])]
    BottomRow {
        /// The row that was found.
        row: [f64; 4],
    },
    /// Two vectors too short or too nearly parallel to span a plane.
    #[error("expected two vectors that span a plane, got lengths {first} and {second} with sine {sine}")]
    DegenerateFrame {
        /// Length of the first vector.
        first: f64,
        /// Length of the second vector.
        second: f64,
        /// Sine of the angle between them.
        sine: f64,
    },
    /// The mean of nothing was asked for.
    #[error("expected at least one element to average, got none")]
    EmptyMean,
    /// The number of weights is not the number of elements.
    #[error("expected one weight for each of {elements} elements, got {weights}")]
    WeightCount {
        /// Number of elements.
        elements: usize,
        /// Number of weights.
        weights: usize,
    },
    /// Weights must be finite, not negative, with a positive sum.
    #[error("expected finite weights ≥ 0 with a positive sum, got {weight} (sum {sum})")]
    InvalidWeight {
        /// The first offending weight, or the smallest one when only the sum offends.
        weight: f64,
        /// The sum of the weights.
        sum: f64,
    },
    /// The Fréchet mean's iteration stopped before its gradient vanished.
    #[error("the Fréchet mean did not converge: gradient {gradient_rad} rad after {iterations} iterations")]
    MeanNotConverged {
        /// Iterations made.
        iterations: usize,
        /// Norm of the remaining Riemannian gradient.
        gradient_rad: f64,
    },
}
