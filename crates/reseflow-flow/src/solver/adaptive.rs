//! Dormand–Prince 4(5) with a step controller (RK45): the step is as long as the tolerance allows. Hairer, Nørsett and Wanner,
//! *Solving Ordinary Differential Equations I*, section II.4, with the controller of *II*, section IV.2.

use reseflow_data::ActionChunk;
use serde::{Deserialize, Serialize};

use super::Integrated;
use super::munthe_kaas::{Step, Velocities, step};
use super::tableau::DORMAND_PRINCE;
use crate::{ActionVelocity, ChunkVelocity, Flow, FlowError, Path};

/// How far from t = 1 the endpoint form stops following the drift and arrives.
const ARRIVAL: f64 = 1e-3;
/// The first step tried, as a share of the whole way.
const FIRST_STEP: f64 = 0.1;
/// A step this short, as a share of the whole way, is given up.
const SHORTEST_STEP: f64 = 1e-9;

/// Tolerances of the adaptive solver. An action's error in one step may be `atol` + `rtol` · (the way it has come so far), both in
/// the norm of [`ActionVelocity::squared_norm`]: a pose far from the world's origin is not followed any less closely.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AdaptiveConfig {
    /// Relative to the way that an action has come.
    pub rtol: f64,
    /// Absolute.
    pub atol: f64,
    /// The most steps accepted.
    pub max_steps: usize,
}

impl Default for AdaptiveConfig {
    fn default() -> Self {
        Self { rtol: 1e-4, atol: 1e-6, max_steps: 100 }
    }
}

impl AdaptiveConfig {
    /// Checks the tolerances.
    ///
    /// # Errors
    /// [`FlowError::Config`] naming a tolerance that is none, [`FlowError::NoSteps`].
    pub fn validate(&self) -> Result<(), FlowError> {
        for (key, value) in [("rtol", self.rtol), ("atol", self.atol)] {
            if !value.is_finite() || value <= 0.0 {
                let fault = format!("solver.{key} must be a number greater than 0, got {value}");
                return Err(FlowError::Config(fault));
            }
        }
        if self.max_steps == 0 { Err(FlowError::NoSteps) } else { Ok(()) }
    }
}

/// Integrates with steps of the solver's own choice.
pub(crate) fn integrate(
    flow: &mut Flow<'_>,
    path: Path,
    noise: Vec<ActionChunk>,
    config: &AdaptiveConfig,
) -> Result<Integrated, FlowError> {
    let arrives = matches!(flow, Flow::Endpoint(_));
    // The solver's own time runs from 0 to `span`: τ = −ln(1 − t) in endpoint form, else t itself.
    let span = if arrives { -ARRIVAL.ln() } else { 1.0 };
    let flow_time = |own: f64| if arrives { -(-own).exp_m1() } else { own };
    let (mut evaluations, mut endpoints) = (0, None);
    let mut rate = |states: &[ActionChunk], own: f64| {
        let t = flow_time(own);
        let mut answer = flow.ask(path, states, t)?;
        evaluations += 1;
        if arrives {
            // dt/dτ = 1 − t, which leaves the displacement.
            answer.drift.iter_mut().flat_map(|chunk| &mut chunk.0).for_each(|rate| *rate = *rate * (1.0 - t));
        }
        endpoints = answer.endpoints;
        Ok(answer.drift)
    };

    let mut states = noise;
    let mut rates = rate(&states, 0.0)?;
    let mut ledger = Ledger::new(&states);
    let mut controller = Controller::default();
    let (mut own, mut length) = (0.0, span * FIRST_STEP);
    let (mut steps, mut rejected) = (0, 0);
    while own < span {
        if steps == config.max_steps || length < span * SHORTEST_STEP {
            return Err(FlowError::Tolerance { t: flow_time(own), steps });
        }
        let rest = span - own;
        let tried = length.min(within_half_turn(&rates));
        let last = tried >= rest * (1.0 - 1e-9);
        let tried = if last { rest } else { tried };
        let made = step(&DORMAND_PRINCE, path, &states, rates.clone(), own, tried, &mut rate)?;
        let ratio = ledger.ratio(&made, config);
        length = tried * controller.factor(ratio);
        if ratio <= 1.0 {
            ledger.accept(&made);
            (states, rates) = (made.states, made.last);
            own = if last { span } else { own + tried };
            steps += 1;
        } else {
            rejected += 1;
        }
    }
    // The last stage of the last step was asked at its end.
    let arrival = usize::from(endpoints.is_some());
    let states = endpoints.unwrap_or(states);
    Ok(Integrated {
        states,
        steps: steps + arrival,
        rejected,
        evaluations,
        error: Some(ledger.largest_error()),
    })
}

/// The longest step in which no action turns by more than half a turn: beyond it the chart nears its edge.
fn within_half_turn(rates: &Velocities) -> f64 {
    let fastest = rates.iter().flat_map(|chunk| &chunk.0).map(|rate| rate.twist.angular.norm());
    std::f64::consts::PI / fastest.fold(0.0, f64::max)
}

/// For every action, in order, the way it has come and the errors it has gathered.
struct Ledger(Vec<(f64, f64)>);

impl Ledger {
    fn new(states: &[ActionChunk]) -> Ledger {
        Ledger(vec![(0.0, 0.0); states.iter().map(ActionChunk::len).sum()])
    }

    /// The largest error of a step in units of its tolerance; infinite where a number is none.
    fn ratio(&self, step: &Step, config: &AdaptiveConfig) -> f64 {
        let made = norms(&step.displacement).zip(norms(&step.error));
        let ratios = self.0.iter().zip(made).map(|((way, _), (length, error))| {
            let ratio = error / (config.atol + config.rtol * (way + length));
            if ratio.is_nan() { f64::INFINITY } else { ratio }
        });
        ratios.fold(0.0, f64::max)
    }

    fn accept(&mut self, step: &Step) {
        let made = norms(&step.displacement).zip(norms(&step.error));
        for ((way, sum), (length, error)) in self.0.iter_mut().zip(made) {
            *way += length;
            *sum += error;
        }
    }

    fn largest_error(&self) -> f64 {
        self.0.iter().fold(0.0, |largest, (_, error)| largest.max(*error))
    }
}

fn norms(velocities: &Velocities) -> impl Iterator<Item = f64> {
    let actions = velocities.iter().flat_map(|ChunkVelocity(actions)| actions);
    actions.map(ActionVelocity::squared_norm).map(f64::sqrt)
}

/// The PI controller of Hairer's DOPRI5: the next step's length from this error and the last one.
struct Controller {
    previous: f64,
    rejected: bool,
}

impl Default for Controller {
    fn default() -> Self {
        Self { previous: 1e-4, rejected: false }
    }
}

impl Controller {
    const SAFETY: f64 = 0.9;
    const BETA: f64 = 0.04;
    const ALPHA: f64 = 0.2 - 0.75 * Self::BETA;

    /// By how much to lengthen the step after an error of `ratio` tolerances.
    fn factor(&mut self, ratio: f64) -> f64 {
        if ratio > 1.0 {
            self.rejected = true;
            return (Self::SAFETY * ratio.powf(-Self::ALPHA)).max(0.2);
        }
        let most = if self.rejected { 1.0 } else { 10.0 };
        let factor = Self::SAFETY * ratio.max(1e-12).powf(-Self::ALPHA) * self.previous.powf(Self::BETA);
        (self.previous, self.rejected) = (ratio.max(1e-4), false);
        factor.clamp(0.2, most)
    }
}
