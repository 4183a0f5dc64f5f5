//! Which solver a flow is integrated with: in a configuration and on the command line.

use clap::ValueEnum;
use reseflow_train::{AdaptiveConfig, Solver};
use serde::{Deserialize, Serialize};

/// The solvers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SolverKind {
    /// Uniform steps, one evaluation each
    #[default]
    Euler,
    /// Uniform steps, two evaluations each
    Midpoint,
    /// Uniform steps, two evaluations each
    Heun,
    /// Uniform steps, four evaluations each
    Rk4,
    /// Dormand and Prince's 4(5), with steps of its own choice
    Rk45,
}

/// A solver and, for the adaptive one, its tolerances.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SolverChoice {
    /// The solver.
    pub kind: SolverKind,
    /// Tolerance relative to the way that an action has come.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rtol: Option<f64>,
    /// Absolute tolerance, radians and metres over 0.15 m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub atol: Option<f64>,
}

impl SolverChoice {
    /// Checks that tolerances are given to the adaptive solver alone, and are some.
    ///
    /// # Errors
    /// A sentence that names what is wrong.
    pub fn validate(&self) -> Result<(), String> {
        if self.kind != SolverKind::Rk45 && (self.rtol.is_some() || self.atol.is_some()) {
            return Err(
                "tolerances (`rtol`, `atol`) belong to the solver `rk45`, the others take uniform steps"
                    .to_owned(),
            );
        }
        self.with_steps(1).validate().map_err(|fault| fault.to_string())
    }

    /// Whether the number of steps is the solver's own choice.
    pub fn is_adaptive(&self) -> bool {
        self.kind == SolverKind::Rk45
    }

    /// The solver with `steps` steps; the adaptive one chooses them itself.
    pub fn with_steps(&self, steps: usize) -> Solver {
        match self.kind {
            SolverKind::Euler => Solver::Euler { steps },
            SolverKind::Midpoint => Solver::Midpoint { steps },
            SolverKind::Heun => Solver::Heun { steps },
            SolverKind::Rk4 => Solver::Rk4 { steps },
            SolverKind::Rk45 => {
                let default = AdaptiveConfig::default();
                Solver::DormandPrince(AdaptiveConfig {
                    rtol: self.rtol.unwrap_or(default.rtol),
                    atol: self.atol.unwrap_or(default.atol),
                    max_steps: default.max_steps,
                })
            }
        }
    }

    /// One solver for each number of steps, or the adaptive one once.
    pub fn with_each(&self, steps: &[usize]) -> Vec<Solver> {
        match self.is_adaptive() {
            true => vec![self.with_steps(1)],
            false => steps.iter().map(|&steps| self.with_steps(steps)).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tolerances_belong_to_the_adaptive_solver_which_chooses_its_own_steps() {
        let heun = SolverChoice { kind: SolverKind::Heun, ..SolverChoice::default() };
        heun.validate().unwrap();
        assert_eq!(heun.with_each(&[1, 5]), [Solver::Heun { steps: 1 }, Solver::Heun { steps: 5 }]);
        assert!(SolverChoice { rtol: Some(1e-3), ..heun }.validate().unwrap_err().contains("rk45"));
        let adaptive = SolverChoice { kind: SolverKind::Rk45, rtol: Some(1e-3), atol: None };
        adaptive.validate().unwrap();
        let expected = AdaptiveConfig { rtol: 1e-3, ..AdaptiveConfig::default() };
        assert_eq!(adaptive.with_each(&[1, 5]), [Solver::DormandPrince(expected)]);
        assert!(SolverChoice { rtol: Some(0.0), ..adaptive }.validate().unwrap_err().contains("rtol"));
    }
}
