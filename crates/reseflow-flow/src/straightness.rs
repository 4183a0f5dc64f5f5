//! How straight a flow is: S = ∫₀¹ E‖ξ(Z^t, t) − Δ‖² dt with Δ the geodesic displacement from Z⁰ to Z¹ (Liu, Gong and Liu, *Flow
//! straight and fast*, 2022, section 2.2, on the group). It is zero exactly where one step of Euler's is as good as many.

use reseflow_data::{Action, ActionChunk};

use crate::path::pairs;
use crate::solver::{EULER, integrate_watched};
use crate::{ChunkVelocity, Flow, FlowError, Path};

/// A mean squared distance that is rounding and counts as none.
const ROUNDING: f64 = 1e-26;

/// The mean squared distance between drift and displacement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Straightness {
    /// S, in the norm of [`crate::ActionVelocity::squared_norm`], mean over scenes and actions.
    pub absolute: f64,
    /// S over the mean squared displacement; 0 where S is rounding alone, even if nothing moves.
    pub relative: f64,
}

/// Measures the flow that starts at `noise`, one state for each scene, along `steps` uniform Euler steps.
///
/// Drift and displacement are compared as body twists (`Path::Screw`), or with the linear parts turned into the start's frame
/// (`Path::Product`): either way a flow along the path's own geodesics is straight.
///
/// # Errors
/// As [`crate::integrate`].
pub fn straightness(
    flow: &mut Flow<'_>,
    path: Path,
    noise: &[ActionChunk],
    steps: usize,
) -> Result<Straightness, FlowError> {
    if steps == 0 {
        return Err(FlowError::NoSteps);
    }
    let mut drifts = Vec::with_capacity(steps);
    let mut watch = |states: &[ActionChunk], drift: &[ChunkVelocity]| {
        let chunk = |((start, now), drift): ((&ActionChunk, &ActionChunk), &ChunkVelocity)| {
            let actions = start.iter().zip(now.iter()).zip(&drift.0);
            actions.map(|((start, now), drift)| path.seen_from(start, now, drift)).collect::<Vec<_>>()
        };
        let seen = noise.iter().zip(states).zip(drift).flat_map(chunk);
        drifts.push(seen.collect::<Vec<_>>());
    };
    let ends = integrate_watched(flow, path, noise.to_vec(), &EULER, steps, &mut watch)?.states;

    let mut displacements = Vec::new();
    for (start, end) in noise.iter().zip(&ends) {
        let way = |(from, to): (&Action, &Action)| path.displacement(from, to);
        displacements.extend(pairs(start, end)?.map(way));
    }
    let count = displacements.len() as f64;
    let apart = drifts.iter().flat_map(|drift| drift.iter().zip(&displacements));
    let apart: f64 = apart.map(|(drift, straight)| (*drift - *straight).squared_norm()).sum();
    let way: f64 = displacements.iter().map(|straight| straight.squared_norm()).sum();
    let share = |part: f64, whole: f64| if part <= ROUNDING * count { 0.0 } else { part / whole };
    let absolute = apart / steps as f64;
    Ok(Straightness { absolute: share(absolute, count), relative: share(absolute, way) })
}
