//! The result file of `reseflow eval` and its table.

use reseflow_data::Split;
use serde::{Deserialize, Serialize};

use super::{ModeScores, PlanLatency, TrivialScores, TurnedScores};
use crate::metrics::{Calibration, PairedDifference, Scores};
use crate::output::Table;
use crate::provenance::Provenance;

/// What a policy scores with one number of integration steps.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StepRow {
    /// Integration steps; of the baseline, noise levels visited.
    pub steps: usize,
    /// Evaluations of the network.
    pub evaluations: usize,
    /// The solver.
    pub solver: String,
    /// The consensus trajectory's scores.
    #[serde(flatten)]
    pub scores: Scores,
    /// D̄_geo of each node's trajectory at the last step.
    pub per_node: Vec<f64>,
    /// Node-wise consistency: the nodes' mean distance from the consensus.
    pub node_spread: Option<f64>,
    /// Whether the nodes' distance from the consensus tells how large the error is; none where they have no spread.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub calibration: Option<Calibration>,
    /// What a single plan takes, where reports have found it in `latency.json`; results of older versions hold it themselves.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub latency: Option<PlanLatency>,
    /// How the samples lie about both experts, where the episodes have two.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub modes: Option<ModeScores>,
    /// Wall-clock seconds for all samples of this row.
    pub secs: f64,
}

/// What fewer steps cost, or gain, against the most.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct StepsDifference {
    /// The row's steps.
    pub steps: usize,
    /// The steps that it is compared with.
    pub against: usize,
    /// D̄_geo of the row minus that of the other.
    #[serde(flatten)]
    pub d_geo: PairedDifference,
}

/// The mean squared distance between drift and displacement along the flow, metres weighted by 1/ℓ.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct StraightnessRow {
    /// Mean over scenes and actions.
    pub absolute: f64,
    /// As a share of the mean squared displacement; 0 where one step is as good as many.
    pub relative: f64,
    /// Uniform Euler steps.
    pub steps: usize,
}

/// The result file.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct EvalReport {
    /// One row for each number of steps.
    pub rows: Vec<StepRow>,
    /// How straight the flow is; reports of older versions do not say.
    #[serde(default)]
    pub straightness: Option<StraightnessRow>,
    /// Every other row against the one with the most steps, episode by episode.
    #[serde(default)]
    pub against_most_steps: Vec<StepsDifference>,
    /// How the answers to turned scenes differ from the turned answers; on the turned split of a run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub turned: Option<TurnedScores>,
    /// What trivial predictors score on the same episodes.
    pub trivial: Option<TrivialScores>,
    /// The task, as the data's file says; `null` where it does not.
    #[serde(default)]
    pub task: Option<String>,
    /// The split, as the data's file says; `null` where it does not.
    #[serde(default)]
    pub split: Option<Split>,
    /// Episodes scored.
    pub episodes: usize,
    /// Noise seeds.
    pub seeds: Vec<u64>,
    /// The checkpoint.
    pub checkpoint: String,
    /// The held-out data.
    pub data: String,
    /// Its content hash.
    pub data_hash: String,
    /// The data for the trivial predictors.
    pub train_data: Option<String>,
    /// The checkpoint's whole configuration: its task, its model and how it was trained.
    pub config: serde_json::Value,
    /// Where the figures come from.
    pub provenance: Provenance,
}

impl StepsDifference {
    /// Every other row against the one with the most steps; none where there is only one.
    pub fn of(rows: &[StepRow]) -> Vec<Self> {
        let Some(most) = rows.iter().max_by_key(|row| row.steps) else { return Vec::new() };
        let others = rows.iter().filter(|row| row.steps != most.steps);
        let compared = others.filter_map(|row| {
            let d_geo = PairedDifference::between(&row.scores.per_episode, &most.scores.per_episode)?;
            Some(Self { steps: row.steps, against: most.steps, d_geo })
        });
        compared.collect()
    }
}

impl EvalReport {
    /// The figures as a table.
    pub fn table(&self) -> Table {
        let mut table = Table::figures([
            "D_geo",
            "mean",
            "± seeds",
            "± episodes",
            "95 % interval",
            "half-turn",
            "rad",
            "mm",
            "opening",
        ]);
        let optional =
            |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |value| format!("{value:.4}"));
        let mut row = |name: String, scores: &Scores| {
            let interval = match (scores.d_geo_low, scores.d_geo_high) {
                (Some(low), Some(high)) => format!("{low:.4} to {high:.4}"),
                _ => "–".to_owned(),
            };
            table.row([
                name,
                format!("{:.4}", scores.d_geo_mean),
                optional(scores.d_geo_std),
                optional(scores.d_geo_episode_std),
                interval,
                format!("{:.4}", scores.d_geo_half_turn_mean),
                format!("{:.4}", scores.rotation_rad),
                format!("{:.1}", 1e3 * scores.translation_m),
                format!("{:.3}", scores.opening_error),
            ]);
        };
        for step in &self.rows {
            row(format!("{} step{}", step.steps, if step.steps == 1 { "" } else { "s" }), &step.scores);
        }
        if let Some(trivial) = &self.trivial {
            row("mean trajectory".to_owned(), &trivial.mean_trajectory);
            row("nearest demonstration".to_owned(), &trivial.nearest_demonstration);
        }
        table
    }
}
