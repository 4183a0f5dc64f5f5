//! Solvers on the group: a tableau and a loop, in Munthe-Kaas form (Munthe-Kaas, *High order Runge–Kutta methods on manifolds*,
//! 1999). They know neither network nor task.
//!
//! In endpoint form the drift log((H^t)⁻¹ Ĥ¹)/(1 − t) is singular at t = 1 only in form, and no solver asks for it there:
//!
//! - On a fixed grid the last step of every solver arrives at Ĥ¹(H^t, t) of the last grid time, with one evaluation. So one step
//!   of any of them is Ĥ¹(H⁰, 0), and the prediction is never extrapolated beyond. The arrival is an Euler step and has a local
//!   error of O(h²) times how much the drift still changes: orders 1 and 2 are kept, and order 4 where the drift settles on a
//!   geodesic of the path towards the end; on a drift that does not, rk4 ends with order 2. All this supposes Ĥ¹(H, 1) = H. A
//!   network holds to that only roughly, and what it is off by there makes the arrival's error O(h), whatever the solver.
//! - The adaptive solver integrates in τ = −ln(1 − t), where the drift is the bare displacement towards Ĥ¹, up to t = 1 − 10⁻³, and
//!   then arrives at Ĥ¹.
//!
//! In twist form nothing is singular, and every solver integrates from 0 to 1 as it is.

mod adaptive;
mod fixed;
mod munthe_kaas;
mod tableau;

use reseflow_data::ActionChunk;
use serde::{Deserialize, Serialize};

use crate::{ChunkVelocity, Flow, FlowError, Path};

pub use adaptive::AdaptiveConfig;
pub(crate) use fixed::integrate_watched;
pub(crate) use tableau::EULER;

/// How a flow is integrated. In a configuration the key `kind` tells which.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Solver {
    /// Exponential-map Euler, order 1: one evaluation a step.
    Euler {
        /// Uniform steps.
        steps: usize,
    },
    /// The explicit midpoint rule, order 2: two evaluations a step.
    Midpoint {
        /// Uniform steps.
        steps: usize,
    },
    /// Heun's rule (the explicit trapezium), order 2: two evaluations a step.
    Heun {
        /// Uniform steps.
        steps: usize,
    },
    /// The classical Runge–Kutta scheme, order 4: four evaluations a step.
    Rk4 {
        /// Uniform steps.
        steps: usize,
    },
    /// Dormand–Prince 4(5) (RK45): steps of its own choice, six evaluations each.
    DormandPrince(AdaptiveConfig),
}

impl Default for Solver {
    fn default() -> Self {
        Self::Euler { steps: 1 }
    }
}

/// Where the flow led, and at what cost.
#[derive(Debug, Clone, PartialEq)]
pub struct Integrated {
    /// The states at t = 1.
    pub states: Vec<ActionChunk>,
    /// Steps taken; of an adaptive solver the accepted ones and the arrival.
    pub steps: usize,
    /// Steps that an adaptive solver tried and did not take.
    pub rejected: usize,
    /// Evaluations of the field, each for all scenes.
    pub evaluations: usize,
    /// An adaptive solver's estimate of its error: the sum over the accepted steps, for the action where it is largest, in the
    /// norm of [`crate::ActionVelocity::squared_norm`].
    pub error: Option<f64>,
}

impl Solver {
    /// The name in configurations and reports.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Euler { .. } => "euler",
            Self::Midpoint { .. } => "midpoint",
            Self::Heun { .. } => "heun",
            Self::Rk4 { .. } => "rk4",
            Self::DormandPrince(_) => "dormand_prince",
        }
    }

    /// Checks step counts and tolerances.
    ///
    /// # Errors
    /// [`FlowError::NoSteps`], and [`FlowError::Config`] naming a tolerance that is none.
    pub fn validate(&self) -> Result<(), FlowError> {
        match *self {
            Self::Euler { steps } | Self::Midpoint { steps } | Self::Heun { steps } | Self::Rk4 { steps } => {
                if steps == 0 {
                    Err(FlowError::NoSteps)
                } else {
                    Ok(())
                }
            }
            Self::DormandPrince(config) => config.validate(),
        }
    }
}

/// Integrates `noise`, one state for each scene, from t = 0 to t = 1.
///
/// All scenes share the grid. An adaptive solver's step is the one that the hardest action of all scenes needs.
///
/// # Errors
/// What [`Solver::validate`] refuses, what the field reports, a field that does not answer for every action with finite numbers
/// ([`FlowError::Field`]), and [`FlowError::Tolerance`].
pub fn integrate(
    flow: &mut Flow<'_>,
    path: Path,
    noise: Vec<ActionChunk>,
    solver: &Solver,
) -> Result<Integrated, FlowError> {
    solver.validate()?;
    let (tableau, steps) = match *solver {
        Solver::Euler { steps } => (&tableau::EULER, steps),
        Solver::Midpoint { steps } => (&tableau::MIDPOINT, steps),
        Solver::Heun { steps } => (&tableau::HEUN, steps),
        Solver::Rk4 { steps } => (&tableau::RK4, steps),
        Solver::DormandPrince(config) => return adaptive::integrate(flow, path, noise, &config),
    };
    integrate_watched(flow, path, noise, tableau, steps, &mut |_, _| ())
}

/// The states that `steps` uniform Euler steps go through, from the noise to the ends: `[grid time][scene]`, `steps` + 1 times.
///
/// # Errors
/// As [`integrate`].
pub fn trace(
    flow: &mut Flow<'_>,
    path: Path,
    noise: Vec<ActionChunk>,
    steps: usize,
) -> Result<Vec<Vec<ActionChunk>>, FlowError> {
    Solver::Euler { steps }.validate()?;
    let mut states = Vec::with_capacity(steps + 1);
    let mut watch = |now: &[ActionChunk], _: &[ChunkVelocity]| states.push(now.to_vec());
    let ends = integrate_watched(flow, path, noise, &EULER, steps, &mut watch)?.states;
    states.push(ends);
    Ok(states)
}
