//! What the network refuses.

use crate::Parameterisation;

/// Farther than any scene reaches, metres; its square is far from what f32 can hold.
const LARGEST: f64 = 1e6;

/// Refuses numbers that are not finite or beyond [`LARGEST`], as those of the `index`th `what`.
pub(crate) fn check_numbers(
    what: &'static str,
    index: usize,
    numbers: impl IntoIterator<Item = f64>,
) -> Result<(), NetError> {
    for number in numbers {
        if !number.is_finite() {
            return Err(NetError::NonFinite { what, index });
        }
        if number.abs() > LARGEST {
            return Err(NetError::OutOfRange { what, index });
        }
    }
    Ok(())
}

/// An input or a configuration that has no answer.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum NetError {
    /// A cloud without points.
    #[error("the point cloud is empty: at least one point is needed")]
    EmptyCloud,
    /// A coordinate that is NaN or infinite.
    #[error("point {index} of the cloud is not finite")]
    NonFinitePoint {
        /// The point's index.
        index: usize,
    },
    /// A number of a gripper, a token or a scene's state that is NaN or infinite.
    #[error("{what} {index} is not finite")]
    NonFinite {
        /// What it is a number of.
        what: &'static str,
        /// Which of them; those of several scenes are counted on, scene after scene.
        index: usize,
    },
    /// A finite number so large that f32 would not hold its square times a few.
    #[error(
        "{what} {index} has a number beyond 1e6: expected a scene in metres, not this far from the origin"
    )]
    OutOfRange {
        /// What it is a number of.
        what: &'static str,
        /// Which of them; those of several scenes are counted on, scene after scene.
        index: usize,
    },
    /// Counts that do not go together.
    #[error("{what}: expected {expected}, got {got}")]
    Mismatch {
        /// Which count.
        what: &'static str,
        /// What was expected.
        expected: usize,
        /// What was got.
        got: usize,
    },
    /// A prediction that the weights were not drawn for.
    #[error("the network predicts {configured:?}, asked was {asked:?}: see decoder.parameterisation")]
    Parameterisation {
        /// What the network was configured for.
        configured: Parameterisation,
        /// What was asked for.
        asked: Parameterisation,
    },
    /// A configuration value outside its range.
    #[error("network config: {0}")]
    Config(String),
}
