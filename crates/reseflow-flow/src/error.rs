//! What a flow refuses.

/// A configuration or a request that makes no sense.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum FlowError {
    /// A configuration value outside its range.
    #[error("flow config: {0}")]
    Config(String),
    /// A solver was asked for no step.
    #[error("the solver needs at least 1 step, got 0")]
    NoSteps,
    /// The drift field failed.
    #[error("the drift field failed: {0}")]
    Field(String),
}
