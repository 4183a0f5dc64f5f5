//! What a flow refuses.

/// A configuration or a request that makes no sense.
#[derive(Debug, Clone, thiserror::Error, PartialEq)]
pub enum FlowError {
    /// A configuration value outside its range, or values that do not go together.
    #[error("flow config: {0}")]
    Config(String),
    /// A solver was asked for no step.
    #[error("the solver needs at least 1 step, got 0")]
    NoSteps,
    /// The drift field failed, or did not answer for every action.
    #[error("the drift field failed: {0}")]
    Field(String),
    /// Two things that belong together have different lengths.
    #[error("{what}: expected {expected}, got {got}")]
    Mismatch {
        /// What was counted.
        what: &'static str,
        /// How many there have to be.
        expected: usize,
        /// How many there are.
        got: usize,
    },
    /// An adaptive solver could not keep its tolerance.
    #[error("the solver met its tolerance only up to t = {t} in {steps} steps, where it gave up")]
    Tolerance {
        /// The flow time that was reached.
        t: f64,
        /// Accepted steps.
        steps: usize,
    },
}
