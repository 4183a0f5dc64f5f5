//! How a run's policies are scored on recorded episodes: the table `[eval]`.

use serde::{Deserialize, Serialize};

use super::SolverChoice;
use super::counts::{check_counts, first_repeated};

/// The numbers of integration steps that policies are scored with.
pub const EVAL_STEPS: [usize; 5] = [1, 2, 10, 50, 100];

/// What a policy reaches where there is one mode only: what the quick start's reached in one step on held-out episodes when this measure
/// was fixed. It stays as it is, so that shares between two experts can be compared.
pub const UNIMODAL_D_GEO: f64 = 0.021;

/// How a policy is scored.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct EvalConfig {
    /// Numbers of integration steps.
    pub steps: Vec<usize>,
    /// Those among them that count on the other splits than `test`, as many steps take long; all of them where this is left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub steps_elsewhere: Option<Vec<usize>>,
    /// Noise seeds, from 3407 on.
    pub seeds: usize,
    /// How flows are integrated.
    pub solver: SolverChoice,
    /// What D̄_geo is where there is one mode only: samples three times as far from both experts count as between them.
    pub unimodal_d_geo: f64,
    /// On which episodes; the first is `test`.
    pub splits: Vec<EvalSplit>,
    /// On how many episodes of each split the baseline is scored, which takes its whole network for every noise level; all of them
    /// where this is left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub baseline_episodes: Option<usize>,
    /// Whether a run ends with timing single plans of its policies. Where runs go on side by side they slow each other down, and
    /// `reseflow bench` times them afterwards.
    pub timed: bool,
}

/// Episodes to score policies on, `data.test_episodes` of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EvalSplit {
    /// Held-out episodes of the training distribution.
    Test,
    /// Poses, sizes and viewpoints outside the training distribution.
    Wide,
    /// The test episodes, each moved by a random rigid motion of its own.
    Turned,
}

impl EvalSplit {
    /// The name in configurations and file names.
    pub fn name(self) -> &'static str {
        match self {
            Self::Test => "test",
            Self::Wide => "wide",
            Self::Turned => "turned",
        }
    }
}

impl Default for EvalConfig {
    fn default() -> Self {
        Self {
            steps: EVAL_STEPS.to_vec(),
            steps_elsewhere: None,
            seeds: 10,
            solver: SolverChoice::default(),
            unimodal_d_geo: UNIMODAL_D_GEO,
            splits: vec![EvalSplit::Test],
            baseline_episodes: None,
            timed: true,
        }
    }
}

impl EvalConfig {
    /// The numbers of integration steps on a split.
    pub fn steps_on(&self, split: EvalSplit) -> &[usize] {
        match (&self.steps_elsewhere, split) {
            (Some(elsewhere), EvalSplit::Wide | EvalSplit::Turned) => elsewhere,
            _ => &self.steps,
        }
    }

    /// Checks what the types cannot say.
    ///
    /// # Errors
    /// A sentence that names the key, what was expected and what was got.
    pub fn validate(&self) -> Result<(), String> {
        check_counts(&[
            ("eval.seeds", self.seeds),
            ("eval.baseline_episodes", self.baseline_episodes.unwrap_or(1)),
        ])?;
        if self.steps.is_empty() || self.steps.contains(&0) {
            return Err(format!(
                "`eval.steps` is {:?}, expected numbers of steps, each 1 or more",
                self.steps
            ));
        }
        if let Some(steps) = first_repeated(&self.steps) {
            return Err(format!("`eval.steps` holds {steps} twice, expected each number of steps once"));
        }
        if let Some(elsewhere) = &self.steps_elsewhere {
            let known = elsewhere.iter().all(|steps| self.steps.contains(steps));
            if elsewhere.is_empty() || !known || first_repeated(elsewhere).is_some() {
                return Err(format!(
                    "`eval.steps_elsewhere` is {elsewhere:?}, expected some of `eval.steps`, {:?}, each once",
                    self.steps
                ));
            }
        }
        if self.splits.first() != Some(&EvalSplit::Test) || first_repeated(&self.splits).is_some() {
            return Err(format!(
                "`eval.splits` is [{}], expected test and after it any of wide and turned, each once",
                self.splits.iter().map(|split| split.name()).collect::<Vec<_>>().join(", ")
            ));
        }
        self.solver.validate().map_err(|fault| format!("`eval.solver`: {fault}"))?;
        let unimodal = self.unimodal_d_geo;
        if !(unimodal.is_finite() && unimodal > 0.0) {
            return Err(format!("`eval.unimodal_d_geo` is {unimodal}, expected a number greater than 0"));
        }
        Ok(())
    }
}
