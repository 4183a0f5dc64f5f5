//! Which noise levels a sampler of fewer steps visits.

use crate::FlowError;

/// The levels at which the networks are asked, from K down: all that matters is that the first is K, where noise is drawn, and that the
/// last is 1, where the equivariant kernel stands. They are as evenly spaced as whole numbers can be.
///
/// With a single step only level K is asked: its invariant kernel knows the noise that it is given, the equivariant one has never
/// seen any like it.
///
/// # Errors
/// [`FlowError::NoSteps`] for none, [`FlowError::Config`] for more steps than there are levels.
pub fn respaced(levels: usize, steps: usize) -> Result<Vec<usize>, FlowError> {
    match steps {
        0 => Err(FlowError::NoSteps),
        1 => Ok(vec![levels]),
        _ if steps > levels => Err(FlowError::Config(format!(
            "the diffusion has {levels} noise levels, so at most that many steps, got {steps}"
        ))),
        _ => {
            // Rounded to the nearest; gaps of at least one keep the levels apart.
            let gaps = steps - 1;
            Ok((0..steps).map(|step| levels - (2 * step * (levels - 1) + gaps) / (2 * gaps)).collect())
        }
    }
}
