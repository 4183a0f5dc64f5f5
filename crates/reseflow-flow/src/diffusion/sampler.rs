//! From noise to a trajectory: invariant steps down to level 1, and one equivariant step out of the anchor's frame.

use rand::Rng;
use reseflow_data::ActionChunk;

use super::{Anchor, AnchoredChunk, Diffusion, LeftFactor, respaced};
use crate::FlowError;

/// A learned denoiser for a batch of scenes.
pub trait Denoiser {
    /// Ĥ^{k→0} of the `states` at level k > 1, one list of left factors for each scene; the same wherever the scenes lie.
    ///
    /// # Errors
    /// Whatever the denoiser's implementation cannot do, as [`FlowError::Field`].
    fn invariant(
        &mut self,
        states: &[AnchoredChunk],
        level: usize,
    ) -> Result<Vec<Vec<LeftFactor>>, FlowError>;

    /// Ĥ^{1→0} of trajectories in the world; where scenes and trajectories are moved by g, it is g Ĥ g⁻¹.
    ///
    /// # Errors
    /// As [`Self::invariant`].
    fn equivariant(&mut self, trajectories: &[ActionChunk]) -> Result<Vec<Vec<LeftFactor>>, FlowError>;
}

/// Draws one trajectory of `horizon` actions for each scene in `steps` evaluations of the denoiser.
///
/// All noise of scene i comes from the generator i and is relative to its anchor, so the same generators about moved anchors give
/// the moved trajectories, as far as the denoiser is what it promises to be.
///
/// # Errors
/// [`FlowError::NoSteps`], [`FlowError::Config`] for more steps than levels, [`FlowError::Mismatch`] where there is not one generator for
/// each anchor, and [`FlowError::Field`] where the denoiser fails or does not answer for every action with finite numbers.
pub fn denoise<R: Rng>(
    denoiser: &mut dyn Denoiser,
    diffusion: &Diffusion,
    anchors: &[Anchor],
    horizon: usize,
    steps: usize,
    rngs: &mut [R],
) -> Result<Vec<ActionChunk>, FlowError> {
    if rngs.len() != anchors.len() {
        return Err(FlowError::Mismatch { what: "generators", expected: anchors.len(), got: rngs.len() });
    }
    let levels = respaced(diffusion.schedule().steps(), steps)?;
    let mut states: Vec<_> = rngs.iter_mut().map(|rng| diffusion.draw(horizon, rng)).collect();
    for (index, &level) in levels.iter().enumerate().filter(|(_, level)| **level > 1) {
        let next = levels.get(index + 1).copied().unwrap_or(0);
        let factors = denoiser.invariant(&states, level)?;
        check(&factors, anchors.len(), horizon)?;
        for ((state, factors), rng) in states.iter_mut().zip(&factors).zip(rngs.iter_mut()) {
            for (action, factor) in state.0.iter_mut().zip(factors) {
                let clean = factor.apply(action);
                *action = diffusion.posterior_mean(action, &clean, level, next);
                if diffusion.config().stochastic && next > 0 {
                    let deviation = diffusion.schedule().posterior(level, next).deviation;
                    *action = diffusion.scattered(action, deviation, rng);
                }
            }
        }
    }
    let mut trajectories: Vec<_> =
        anchors.iter().zip(&states).map(|(anchor, state)| anchor.place(state)).collect();
    if levels.last() == Some(&1) {
        let factors = denoiser.equivariant(&trajectories)?;
        check(&factors, anchors.len(), horizon)?;
        for (trajectory, factors) in trajectories.iter_mut().zip(&factors) {
            for (action, factor) in trajectory.0.iter_mut().zip(factors) {
                *action = factor.apply_to_action(action);
            }
        }
    }
    Ok(trajectories)
}

/// Makes sure that every action of every scene got an answer, and a finite one.
fn check(factors: &[Vec<LeftFactor>], scenes: usize, horizon: usize) -> Result<(), FlowError> {
    if factors.len() != scenes {
        let fault = format!("it answered for {} scenes, expected {scenes}", factors.len());
        return Err(FlowError::Field(fault));
    }
    for (scene, factors) in factors.iter().enumerate() {
        if factors.len() != horizon {
            let fault =
                format!("it answered with {} actions for scene {scene}, expected {horizon}", factors.len());
            return Err(FlowError::Field(fault));
        }
        if let Some(action) = factors.iter().position(|factor| !factor.is_finite()) {
            let fault = format!("its answer for action {action} of scene {scene} is not finite");
            return Err(FlowError::Field(fault));
        }
    }
    Ok(())
}
