//! The policy trait: scripted experts, baselines and trained networks all speak it.

use crate::{ActionChunk, ObservationHistory};

/// Why a policy could not plan.
#[derive(Debug, thiserror::Error)]
#[error("policy {policy} cannot plan: {reason}")]
pub struct PolicyError {
    /// The policy's name.
    pub policy: String,
    /// What was expected and what was got.
    pub reason: String,
}

/// What a policy answers.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// The next L actions.
    pub actions: ActionChunk,
    /// One spread per action (node-wise consistency: the weighted rms distance of the nodes to their consensus), where the
    /// policy has one.
    pub uncertainty: Option<Vec<f64>>,
}

/// Turns observations into actions.
pub trait Policy {
    /// A short name for reports.
    fn name(&self) -> &str;

    /// Forgets the last episode; `seed` names the random stream of the next one.
    fn reset(&mut self, seed: u64);

    /// Plans from the last frames.
    ///
    /// # Errors
    /// When the observation is not one that this policy can use.
    fn plan(&mut self, history: &ObservationHistory) -> Result<Plan, PolicyError>;
}
