//! Which noise a demonstration is joined with in Flow 2, where it stands beside the pairs that Flow 1 made.
//!
//! With `independent` noise the best endpoint for one step lies between the modes, however long one trains; an `anchored`
//! demonstration keeps to noise that Flow 1 carries near it, so that it mends the pairs without blurring them.

use reseflow_data::{Action, ActionChunk, FlowPair};
use serde::{Deserialize, Serialize};

use crate::path::pairs;
use crate::{FlowError, Path};

/// How demonstrations get their noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Coupling {
    /// The noise, of those drawn for this observation, that Flow 1 carries nearest to the demonstration: [`nearest_image`].
    #[default]
    Anchored,
    /// Noise drawn anew each time, as in the training of Flow 1: the paper's.
    Independent,
}

/// The index of the first of `pairs` whose image is nearest to the demonstration; `weights` are those of its L actions.
///
/// All pairs have to be of the demonstration's own observation: a nearest noise of another one would tell the network what the
/// demonstration is.
///
/// # Errors
/// [`FlowError::Mismatch`] where there is no pair or horizons differ.
pub fn nearest_image(
    pairs: &[FlowPair],
    demonstration: &ActionChunk,
    weights: &[f64],
) -> Result<usize, FlowError> {
    if pairs.is_empty() {
        return Err(FlowError::Mismatch { what: "noises to couple with", expected: 1, got: 0 });
    }
    let mut best = (0, f64::INFINITY);
    for (index, pair) in pairs.iter().enumerate() {
        let distance = squared_distance(demonstration, &pair.image, weights)?;
        if distance < best.1 {
            best = (index, distance);
        }
    }
    Ok(best.0)
}

/// The weighted sum over the actions of θ² + ‖p′ − p‖²/ℓ² + (opening′ − opening)².
fn squared_distance(a: &ActionChunk, b: &ActionChunk, weights: &[f64]) -> Result<f64, FlowError> {
    if weights.len() != a.len() {
        return Err(FlowError::Mismatch { what: "action weights", expected: a.len(), got: weights.len() });
    }
    let apart = |(a, b): (&Action, &Action)| Path::Product.displacement(a, b).squared_norm();
    Ok(pairs(a, b)?.map(apart).zip(weights).map(|(apart, weight)| apart * weight).sum())
}
