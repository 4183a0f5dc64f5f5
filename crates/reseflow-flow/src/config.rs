//! A flow as a whole: its parts are valid each by itself, and have to go together.

use serde::{Deserialize, Serialize};

use crate::{FlowError, ObjectiveConfig, Path, PoseError, Prior, TimeSampling};

/// What the network says of the flow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Parameterisation {
    /// The clean pose Ĥ¹; the drift is the displacement towards it over 1 − t.
    #[default]
    Endpoint,
    /// The paper's: the drift itself, a body twist.
    Twist,
}

/// Everything about a flow but its network.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FlowConfig {
    /// What the network says.
    pub parameterisation: Parameterisation,
    /// Which geodesic joins noise and data.
    pub path: Path,
    /// The noise.
    pub prior: Prior,
    /// Flow times in training.
    pub time: TimeSampling,
    /// The objective.
    pub objective: ObjectiveConfig,
}

impl FlowConfig {
    /// Checks every part, and that they go together.
    ///
    /// # Errors
    /// [`FlowError::Config`] naming what is out of range, or what excludes what and why.
    pub fn validate(&self) -> Result<(), FlowError> {
        self.prior.validate()?;
        self.time.validate()?;
        self.objective.validate()?;
        if self.parameterisation == Parameterisation::Twist && self.objective.error == PoseError::Chordal {
            return Err(FlowError::Config(
                "objective.error = \"chordal\" compares clean poses, and parameterisation = \"twist\" predicts none; \
                 use objective.error = \"twist\""
                    .to_owned(),
            ));
        }
        Ok(())
    }
}
