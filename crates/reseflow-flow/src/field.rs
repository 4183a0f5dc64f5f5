//! The learned flow as a solver sees it: a field that answers for many scenes at once, checked before anybody uses its answer.

use reseflow_data::ActionChunk;

use crate::{ChunkVelocity, FlowError, Path};

/// A learned flow for a batch of scenes in `endpoint` form: what clean trajectory does each state flow towards?
pub trait DriftField {
    /// The endpoints Ĥ¹ of `states` at flow time `t`, one for each scene.
    ///
    /// # Errors
    /// Whatever the field's implementation cannot do, as [`FlowError::Field`].
    fn endpoints(&mut self, states: &[ActionChunk], t: f64) -> Result<Vec<ActionChunk>, FlowError>;
}

/// A learned flow for a batch of scenes in `twist` form: the paper's ξ_θ, in body coordinates.
pub trait TwistField {
    /// The velocities of `states` at flow time `t`, one chunk for each scene.
    ///
    /// # Errors
    /// Whatever the field's implementation cannot do, as [`FlowError::Field`].
    fn velocities(&mut self, states: &[ActionChunk], t: f64) -> Result<Vec<ChunkVelocity>, FlowError>;
}

/// A flow to integrate, by what its network says.
pub enum Flow<'a> {
    /// The clean trajectory; the drift is the displacement towards it over 1 − t.
    Endpoint(&'a mut dyn DriftField),
    /// The drift itself.
    Twist(&'a mut dyn TwistField),
}

/// What a flow says at one moment.
pub(crate) struct Answer {
    /// ξ(H^t, t).
    pub(crate) drift: Vec<ChunkVelocity>,
    /// Ĥ¹, where the flow predicts it.
    pub(crate) endpoints: Option<Vec<ActionChunk>>,
}

impl Flow<'_> {
    /// Asks for the drift of `states` at `t`; in endpoint form `t` has to be less than 1.
    pub(crate) fn ask(&mut self, path: Path, states: &[ActionChunk], t: f64) -> Result<Answer, FlowError> {
        match self {
            Flow::Endpoint(field) => {
                let endpoints = field.endpoints(states, t)?;
                check(
                    states,
                    &endpoints,
                    |chunk| &chunk.0,
                    |action| action.world_from_gripper.is_finite() && action.opening.is_finite(),
                )?;
                let towards = |(state, end): (&ActionChunk, &ActionChunk)| {
                    let actions = state.iter().zip(end.iter());
                    ChunkVelocity(
                        actions.map(|(from, to)| path.displacement(from, to) * (1.0 / (1.0 - t))).collect(),
                    )
                };
                let drift = states.iter().zip(&endpoints).map(towards).collect();
                Ok(Answer { drift, endpoints: Some(endpoints) })
            }
            Flow::Twist(field) => {
                let drift = field.velocities(states, t)?;
                check(states, &drift, |chunk| &chunk.0, |velocity| velocity.is_finite())?;
                Ok(Answer { drift, endpoints: None })
            }
        }
    }
}

/// Makes sure that every action of every scene got an answer, and a finite one.
fn check<C, A>(
    states: &[ActionChunk],
    answers: &[C],
    actions: fn(&C) -> &Vec<A>,
    finite: fn(&A) -> bool,
) -> Result<(), FlowError> {
    if answers.len() != states.len() {
        let fault = format!("it answered for {} scenes, expected {}", answers.len(), states.len());
        return Err(FlowError::Field(fault));
    }
    for (scene, (state, answer)) in states.iter().zip(answers).enumerate() {
        let answer = actions(answer);
        if answer.len() != state.len() {
            return Err(FlowError::Field(format!(
                "it answered with {} actions for scene {scene}, expected {}",
                answer.len(),
                state.len()
            )));
        }
        if let Some(action) = answer.iter().position(|action| !finite(action)) {
            return Err(FlowError::Field(format!(
                "its answer for action {action} of scene {scene} is not finite"
            )));
        }
    }
    Ok(())
}
