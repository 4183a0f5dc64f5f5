//! Which solvers a run compares at equal cost: the table `[samplers]`.

use serde::{Deserialize, Serialize};

use super::counts::{check_counts, first_repeated};
use super::{SolverChoice, SolverKind};

/// Solvers and the evaluations of the network that each may spend.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SamplersConfig {
    /// The solvers.
    pub kinds: Vec<SolverKind>,
    /// The most evaluations that a solver of uniform steps may spend: one row for each.
    pub evaluations: Vec<usize>,
    /// Relative tolerances of the adaptive solver, which says itself what it spends: one row for each.
    pub tolerances: Vec<f64>,
    /// Episodes of the test split, from the first.
    pub episodes: usize,
    /// Noise seeds, from 3407 on.
    pub seeds: usize,
}

impl Default for SamplersConfig {
    fn default() -> Self {
        Self {
            kinds: vec![
                SolverKind::Euler,
                SolverKind::Midpoint,
                SolverKind::Heun,
                SolverKind::Rk4,
                SolverKind::Rk45,
            ],
            evaluations: vec![1, 2, 5, 9, 17, 33, 65],
            tolerances: vec![1e-1, 1e-2, 1e-3],
            episodes: 20,
            seeds: 2,
        }
    }
}

impl SamplersConfig {
    /// The adaptive solver at each tolerance, the absolute one a hundredth of the relative.
    pub fn adaptive(&self) -> Vec<SolverChoice> {
        let at =
            |rtol: &f64| SolverChoice { kind: SolverKind::Rk45, rtol: Some(*rtol), atol: Some(1e-2 * rtol) };
        match self.kinds.contains(&SolverKind::Rk45) {
            true => self.tolerances.iter().map(at).collect(),
            false => Vec::new(),
        }
    }

    /// The solvers of uniform steps.
    pub fn uniform(&self) -> impl Iterator<Item = SolverChoice> {
        let kinds = self.kinds.iter().filter(|kind| **kind != SolverKind::Rk45);
        kinds.map(|kind| SolverChoice { kind: *kind, ..SolverChoice::default() })
    }

    /// Checks what the types cannot say.
    ///
    /// # Errors
    /// A sentence that names the key, what was expected and what was got.
    pub fn validate(&self) -> Result<(), String> {
        check_counts(&[("samplers.episodes", self.episodes), ("samplers.seeds", self.seeds)])?;
        check_counts(
            &self.evaluations.iter().map(|count| ("samplers.evaluations", *count)).collect::<Vec<_>>(),
        )?;
        if self.kinds.is_empty() || first_repeated(&self.kinds).is_some() {
            return Err(
                "`samplers.kinds` is empty or repeats itself, expected one solver or more, each once"
                    .to_owned(),
            );
        }
        if self.evaluations.is_empty() && self.uniform().next().is_some() {
            return Err(
                "`samplers.evaluations` is empty, expected one count or more for the solvers of uniform steps".to_owned()
            );
        }
        if self.tolerances.is_empty() && self.kinds.contains(&SolverKind::Rk45) {
            return Err("`samplers.tolerances` is empty, expected one tolerance or more for the solver rk45"
                .to_owned());
        }
        if let Some(count) = first_repeated(&self.evaluations) {
            return Err(format!("`samplers.evaluations` holds {count} twice, expected each count once"));
        }
        if let Some(rtol) = first_repeated(&self.tolerances) {
            return Err(format!("`samplers.tolerances` holds {rtol} twice, expected each tolerance once"));
        }
        for choice in self.adaptive() {
            choice.validate().map_err(|fault| format!("`samplers.tolerances`: {fault}"))?;
        }
        Ok(())
    }
}
