//! One Runge–Kutta step on the group. Every stage is a point Θ of the chart about the state at the step's start; a body velocity
//! ξ met there is carried back to the chart by the inverse of dexp, Θ̇ = J_r⁻¹(Θ) ξ, and the velocities are then added as vectors.

use reseflow_data::ActionChunk;

use super::tableau::Tableau;
use crate::{ActionVelocity, ChunkVelocity, FlowError, Path};

/// The velocities of many scenes.
pub(crate) type Velocities = Vec<ChunkVelocity>;

/// Asks the flow for the velocities of states at a moment of the step's own time.
pub(crate) type Rate<'a> = dyn FnMut(&[ActionChunk], f64) -> Result<Velocities, FlowError> + 'a;

/// What a step did.
pub(crate) struct Step {
    /// The states after it.
    pub(crate) states: Vec<ActionChunk>,
    /// The displacement in the chart about the states before it.
    pub(crate) displacement: Velocities,
    /// The velocities at the last stage, in the body there.
    pub(crate) last: Velocities,
    /// The displacement less the embedded scheme's; without one, zero.
    pub(crate) error: Velocities,
}

/// Steps from `start` by `length`; `first` are the velocities of `states` there.
pub(crate) fn step(
    tableau: &Tableau,
    path: Path,
    states: &[ActionChunk],
    first: Velocities,
    start: f64,
    length: f64,
    rate: &mut Rate<'_>,
) -> Result<Step, FlowError> {
    let mut rates = vec![first.clone()];
    let mut last = first;
    for (weights, time) in tableau.stages.iter().zip(&tableau.times[1..]) {
        let charts = combine(&rates, weights, length);
        last = rate(&retract(path, states, &charts), start + time * length)?;
        rates.push(zip(&charts, &last, |chart, velocity| path.chart_rate(chart, velocity)));
    }
    let displacement = combine(&rates, tableau.step, length);
    let states = retract(path, states, &displacement);
    Ok(Step { states, displacement, last, error: combine(&rates, tableau.error, length) })
}

/// `length` · Σ weightᵢ rateᵢ.
fn combine(rates: &[Velocities], weights: &[f64], length: f64) -> Velocities {
    let sum = |scene: usize, action: usize| {
        rates.iter().zip(weights).fold(ActionVelocity::zero(), |sum, (rate, weight)| {
            sum + rate[scene].0[action] * (weight * length)
        })
    };
    let chunk = |(scene, chunk): (usize, &ChunkVelocity)| {
        ChunkVelocity((0..chunk.0.len()).map(|action| sum(scene, action)).collect())
    };
    rates[0].iter().enumerate().map(chunk).collect()
}

fn zip(
    first: &Velocities,
    second: &Velocities,
    with: impl Fn(&ActionVelocity, &ActionVelocity) -> ActionVelocity,
) -> Velocities {
    let chunk = |(first, second): (&ChunkVelocity, &ChunkVelocity)| {
        ChunkVelocity(first.0.iter().zip(&second.0).map(|(first, second)| with(first, second)).collect())
    };
    first.iter().zip(second).map(chunk).collect()
}

fn retract(path: Path, states: &[ActionChunk], charts: &Velocities) -> Vec<ActionChunk> {
    let chunk = |(state, chart): (&ActionChunk, &ChunkVelocity)| {
        ActionChunk(state.iter().zip(&chart.0).map(|(from, chart)| path.retract(from, chart)).collect())
    };
    states.iter().zip(charts).map(chunk).collect()
}
