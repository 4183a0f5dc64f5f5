//! Uniform steps from 0 to 1.

use reseflow_data::ActionChunk;

use super::Integrated;
use super::munthe_kaas::step;
use super::tableau::Tableau;
use crate::{ChunkVelocity, Flow, FlowError, Path};

/// Integrates in `steps` uniform steps and shows every grid time's states and drift to `watch`.
pub(crate) fn integrate_watched(
    flow: &mut Flow<'_>,
    path: Path,
    noise: Vec<ActionChunk>,
    tableau: &Tableau,
    steps: usize,
    watch: &mut dyn FnMut(&[ActionChunk], &[ChunkVelocity]),
) -> Result<Integrated, FlowError> {
    let mut states = noise;
    let mut evaluations = 0;
    for index in 0..steps {
        let time = |step: usize| step as f64 / steps as f64;
        let answer = flow.ask(path, &states, time(index))?;
        evaluations += 1;
        watch(&states, &answer.drift);
        states = match answer.endpoints {
            Some(endpoints) if index + 1 == steps => endpoints,
            _ => {
                let mut rate = |states: &[ActionChunk], t: f64| {
                    evaluations += 1;
                    Ok(flow.ask(path, states, t)?.drift)
                };
                let length = 1.0 / steps as f64;
                step(tableau, path, &states, answer.drift, time(index), length, &mut rate)?.states
            }
        };
    }
    Ok(Integrated { states, steps, rejected: 0, evaluations, error: None })
}
