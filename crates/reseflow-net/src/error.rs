//! What the network refuses.

use crate::Parameterisation;

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
