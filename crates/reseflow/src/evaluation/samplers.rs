//! Solvers at equal cost: the error against evaluations of the network, for each way to integrate one and the same flow.

use reseflow_data::Dataset;
use reseflow_train::{AdaptiveConfig, Drawn, Solver};
use serde::{Deserialize, Serialize};

use super::{SamplePolicy, noise_seeds, predict_first};
use crate::config::{SamplersConfig, SolverChoice};
use crate::error::sentence;
use crate::metrics::{Scores, TrajectoryError, mean};
use crate::output::Terminal;
use crate::provenance::Provenance;

/// What stands for the flow's exact solution. A uniform grid would not do: where a network predicts endpoints, its last step goes all the
/// way to the endpoint, which costs O(1/steps) with any scheme.
const REFERENCE: Solver = Solver::DormandPrince(AdaptiveConfig { rtol: 1e-5, atol: 1e-6, max_steps: 5000 });

/// The result file.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct SamplersReport {
    /// Flow 1, and the last where there are more.
    pub flows: Vec<FlowSamplers>,
    /// Episodes sampled.
    pub episodes: usize,
    /// Noise seeds.
    pub seeds: Vec<u64>,
    /// What stands for the flow's exact solution.
    pub reference: Solver,
    /// Where the figures come from.
    pub provenance: Provenance,
}

/// The solvers on one flow.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FlowSamplers {
    /// Its number, from 1.
    pub flow: usize,
    /// D̄_geo of the reference to the truth.
    pub reference_d_geo: f64,
    /// One row for each solver and budget.
    pub rows: Vec<SamplerRow>,
}

/// What a solver does with a budget.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SamplerRow {
    /// The solver.
    pub solver: String,
    /// The evaluations that it may spend; `null` where it says so itself.
    pub budget: Option<usize>,
    /// The relative tolerance of the adaptive one.
    pub rtol: Option<f64>,
    /// Steps taken.
    pub steps: usize,
    /// Evaluations spent.
    pub evaluations: usize,
    /// D̄_geo to the truth.
    pub d_geo_mean: f64,
    /// The lower end of its 95 % bootstrap interval over episodes.
    pub d_geo_low: Option<f64>,
    /// The upper end.
    pub d_geo_high: Option<f64>,
    /// D̄_geo to the reference from the same noise: what the integration itself adds.
    pub d_geo_to_reference: f64,
}

impl SamplersReport {
    /// An empty report on `episodes` episodes.
    pub fn new(config: &SamplersConfig, episodes: usize, device: &str) -> Self {
        Self {
            flows: Vec::new(),
            episodes,
            seeds: noise_seeds(config.seeds),
            reference: REFERENCE,
            provenance: Provenance::gather(device),
        }
    }
}

/// Integrates flow `flow` from the same noise with every solver of `config`.
///
/// # Errors
/// When the data does not fit the policy. An adaptive solver that gives up leaves no row, and is said on the terminal.
pub fn compare_samplers(
    policy: &dyn SamplePolicy,
    flow: usize,
    dataset: &Dataset,
    config: &SamplersConfig,
    terminal: &Terminal,
) -> anyhow::Result<FlowSamplers> {
    let seeds = noise_seeds(config.seeds);
    let draw = |solver: &Solver| predict_first(policy, dataset, &seeds, solver);
    let exact = draw(&REFERENCE)?;
    let mut rows = Vec::new();
    for choice in config.uniform() {
        let cost = Cost::measure(policy, dataset, &choice)?;
        for budget in &config.evaluations {
            let Some(steps) = cost.steps(*budget) else { continue };
            let drawn = draw(&choice.with_steps(steps))?;
            rows.extend(row(&drawn, &exact, dataset, choice, Some(*budget)));
        }
    }
    for choice in config.adaptive() {
        match draw(&choice.with_steps(1)) {
            Ok(drawn) => rows.extend(row(&drawn, &exact, dataset, choice, None)),
            Err(fault) => terminal.note(format!("samplers: rk45 gives up: {}", sentence(&fault))),
        }
    }
    let scores = scores(&exact, dataset);
    Ok(FlowSamplers { flow, reference_d_geo: scores.map_or(0.0, |scores| scores.d_geo_mean), rows })
}

/// What steps of a solver cost, in evaluations.
struct Cost {
    first: usize,
    each_more: usize,
}

impl Cost {
    /// From one step and from two: the last step of a flow that predicts endpoints takes one evaluation with every solver.
    fn measure(policy: &dyn SamplePolicy, dataset: &Dataset, choice: &SolverChoice) -> anyhow::Result<Self> {
        let one = Dataset { episodes: dataset.episodes.iter().take(1).cloned().collect(), meta: None };
        let evaluations = |steps| {
            let drawn = predict_first(policy, &one, &noise_seeds(1), &choice.with_steps(steps))?;
            anyhow::Ok(drawn.evaluations)
        };
        let first = evaluations(1)?;
        Ok(Self { first, each_more: (evaluations(2)? - first).max(1) })
    }

    /// The most steps that `budget` evaluations are enough for.
    fn steps(&self, budget: usize) -> Option<usize> {
        Some(budget.checked_sub(self.first)? / self.each_more + 1)
    }
}

fn row(
    drawn: &Drawn,
    exact: &Drawn,
    dataset: &Dataset,
    choice: SolverChoice,
    budget: Option<usize>,
) -> Option<SamplerRow> {
    let scores = scores(drawn, dataset)?;
    let twins = drawn.samples.iter().flatten().zip(exact.samples.iter().flatten());
    let apart = twins.filter_map(|(one, other)| {
        Some(TrajectoryError::between(&one.consensus, &other.consensus.0)?.d_geo())
    });
    Some(SamplerRow {
        solver: choice.with_steps(1).name().to_owned(),
        budget,
        rtol: choice.rtol,
        steps: drawn.steps,
        evaluations: drawn.evaluations,
        d_geo_mean: scores.d_geo_mean,
        d_geo_low: scores.d_geo_low,
        d_geo_high: scores.d_geo_high,
        d_geo_to_reference: mean(&apart.collect::<Vec<_>>())?,
    })
}

/// The scores of samples `[episode][seed]`.
fn scores(drawn: &Drawn, dataset: &Dataset) -> Option<Scores> {
    let seeds = drawn.samples.iter().map(Vec::len).min()?;
    let errors = |seed: usize| {
        let pairs = drawn.samples.iter().zip(&dataset.episodes);
        pairs
            .filter_map(|(of_episode, truth)| {
                TrajectoryError::between(&of_episode[seed].consensus, &truth.actions)
            })
            .collect::<Vec<_>>()
    };
    Scores::aggregate(&(0..seeds).map(errors).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_budget_is_never_exceeded_and_never_wasted() {
        // Endpoints: the last step takes one evaluation. Velocities: all steps take four.
        for cost in [Cost { first: 1, each_more: 4 }, Cost { first: 4, each_more: 4 }] {
            for budget in 1..40 {
                let spent = |steps: usize| cost.first + (steps - 1) * cost.each_more;
                match cost.steps(budget) {
                    Some(steps) => assert!(spent(steps) <= budget && budget < spent(steps + 1)),
                    None => assert!(budget < cost.first),
                }
            }
        }
    }
}
