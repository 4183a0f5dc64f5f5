//! Exponential-map Euler on the group, in endpoint form: every step follows the screw towards the predicted endpoint, and the last
//! one arrives there, so that one step is Ĥ(H⁰, 0).

use reseflow_data::ActionChunk;

use crate::FlowError;

/// A learned flow for a batch of scenes: what clean trajectory does each state flow towards?
pub trait DriftField {
    /// The endpoints Ĥ¹ of `states` at flow time `t`, one for each scene.
    ///
    /// # Errors
    /// Whatever the field's implementation cannot do, as [`FlowError::Field`].
    fn endpoints(&mut self, states: &[ActionChunk], t: f64) -> Result<Vec<ActionChunk>, FlowError>;
}

/// Where the flow led.
#[derive(Debug, Clone, PartialEq)]
pub struct Integrated {
    /// The states at t = 1.
    pub states: Vec<ActionChunk>,
    /// Drift evaluations.
    pub evaluations: usize,
}

/// Integrates `noise` from t = 0 to t = 1 in `steps` uniform steps.
///
/// # Errors
/// [`FlowError::NoSteps`], and what the field reports.
pub fn integrate_euler(
    field: &mut dyn DriftField,
    noise: Vec<ActionChunk>,
    steps: usize,
) -> Result<Integrated, FlowError> {
    if steps == 0 {
        return Err(FlowError::NoSteps);
    }
    let mut states = noise;
    for step in 0..steps {
        let t = step as f64 / steps as f64;
        let endpoints = field.endpoints(&states, t)?;
        // (1/S) · log(H⁻¹Ĥ) / (1 − s/S): the share of what is left of the way.
        let share = 1.0 / (steps - step) as f64;
        states = if step + 1 == steps {
            endpoints
        } else {
            let towards = |(state, end): (&ActionChunk, &ActionChunk)| {
                ActionChunk(
                    state.iter().zip(end.iter()).map(|(from, to)| from.interpolate(to, share)).collect(),
                )
            };
            states.iter().zip(&endpoints).map(towards).collect()
        };
    }
    Ok(Integrated { states, evaluations: steps })
}
