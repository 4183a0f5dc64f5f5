//! What is particular to flows: modes, straightness, nodes, equivariance.

use super::super::document::{Block, Table, decimals, optional, percent};
use super::super::study::{Study, fewest, learner_title};
use crate::learners::Learner;

/// Where samples lie about two experts.
pub(in super::super) fn modes(study: &Study) -> Block {
    let mut table = Table::new(
        "Scenes with two experts as good as each other. Share a mode: samples nearer to either expert; between: samples further than the \
         given D̄_geo from both; rarer within a scene: 50 % where every scene's samples take both ways alike, 0 % where one way only.",
        [
            "run",
            "policy",
            "steps",
            "share a mode",
            "rarer within a scene",
            "between",
            "limit",
            "D̄_geo to the nearer",
            "experts apart",
            "energy distance",
        ],
    );
    for run in &study.runs {
        for eval in run.evals.iter().filter(|eval| eval.split == "test") {
            for row in &eval.report.rows {
                let Some(modes) = &row.modes else { continue };
                let [first, second] = modes.share_per_mode.map(percent);
                table.row([
                    run.name.clone(),
                    learner_title(eval.learner),
                    row.steps.to_string(),
                    format!("{first}, {second}"),
                    percent(modes.rarer_share_within_scene),
                    percent(modes.share_between),
                    decimals(modes.between_d_geo),
                    decimals(modes.d_geo_nearer),
                    decimals(modes.d_geo_apart),
                    optional(modes.energy_distance),
                ]);
            }
        }
    }
    table.or_absent("modes: no run has scenes with two experts (the task `coin_toss`).")
}

/// Solvers at equal cost.
pub(in super::super) fn samplers(study: &Study) -> Block {
    let mut table = Table::new(
        "Solvers on one and the same flow from the same noise: the error against the evaluations of the network that they spend. To the \
         exact flow: D̄_geo to what RK45 reaches at a relative tolerance of 1e-5, which is what the integration itself adds. RK45 takes \
         the steps that the hardest scene of a batch needs, so its evaluations are the batch's.",
        ["run", "policy", "solver", "evaluations", "steps", "D̄_geo", "95 % interval", "to the exact flow"],
    );
    for run in &study.runs {
        for flow in run.samplers.iter().flat_map(|samplers| &samplers.flows) {
            for row in &flow.rows {
                let tolerance = row.rtol.map(|rtol| format!(" (rtol {rtol:.0e})")).unwrap_or_default();
                let interval = match (row.d_geo_low, row.d_geo_high) {
                    (Some(low), Some(high)) => format!("{low:.4} to {high:.4}"),
                    _ => "–".to_owned(),
                };
                table.row([
                    run.name.clone(),
                    learner_title(Learner::Flow(flow.flow)),
                    format!("{}{tolerance}", row.solver),
                    row.evaluations.to_string(),
                    row.steps.to_string(),
                    decimals(row.d_geo_mean),
                    interval,
                    decimals(row.d_geo_to_reference),
                ]);
            }
        }
    }
    table.or_absent("solvers at equal cost: no run compared them (the table `samplers` of a configuration).")
}

/// How straight flows are.
pub(in super::super) fn straightness(study: &Study) -> Block {
    let mut table = Table::new(
        "The mean squared distance between the drift along the flow and the displacement from its start to its end (metres weighted by \
         1/0.15 m); relative: as a share of the mean squared displacement. 0 where one step leads as far as many.",
        ["run", "policy", "straightness", "relative", "measured with"],
    );
    for run in &study.runs {
        for eval in run.evals.iter().filter(|eval| eval.split == "test") {
            let Some(row) = &eval.report.straightness else { continue };
            table.row([
                run.name.clone(),
                learner_title(eval.learner),
                format!("{:.3e}", row.absolute),
                format!("{:.3e}", row.relative),
                format!("{} Euler steps", row.steps),
            ]);
        }
    }
    table.or_absent("straightness: it was measured for no flow.")
}

/// The nodes by themselves.
pub(in super::super) fn nodes(study: &Study) -> Block {
    let mut table = Table::new(
        "D̄_geo of each node's own trajectory, nodes in order, beside the consensus of all, with the fewest steps. Spread: the nodes' \
         weighted distance from the consensus; rank correlation: whether more spread goes with more error (1: always, 0: not at all).",
        ["run", "policy", "steps", "consensus", "nodes", "spread", "rank correlation"],
    );
    for run in &study.runs {
        for eval in run.evals.iter().filter(|eval| eval.split == "test") {
            let Some(row) = fewest(&eval.report).filter(|row| !row.per_node.is_empty()) else { continue };
            let nodes: Vec<String> = row.per_node.iter().map(|node| decimals(*node)).collect();
            table.row([
                run.name.clone(),
                learner_title(eval.learner),
                row.steps.to_string(),
                decimals(row.scores.d_geo_mean),
                nodes.join(", "),
                optional(row.node_spread),
                row.calibration
                    .as_ref()
                    .map_or_else(|| "–".to_owned(), |known| format!("{:.2}", known.spearman)),
            ]);
        }
    }
    table.or_absent("nodes: no policy answers node by node.")
}

/// Turned scenes against turned answers.
pub(in super::super) fn turned(study: &Study) -> Block {
    let mut table = Table::new(
        "D_geo between the answer to a moved scene and the moved answer to the scene, over all actions, seeds and episodes: 0 but for \
         rounding where the policy is equivariant.",
        ["run", "policy", "steps", "median", "99th percentile", "99.9th percentile", "largest"],
    );
    for run in &study.runs {
        for eval in &run.evals {
            let Some(turned) = &eval.report.turned else { continue };
            let error = &turned.equivariance;
            let cells = [error.p50, error.p99, error.p999, error.max].map(|value| format!("{value:.1e}"));
            let [p50, p99, p999, max] = cells;
            table.row([
                run.name.clone(),
                learner_title(eval.learner),
                error.steps.to_string(),
                p50,
                p99,
                p999,
                max,
            ]);
        }
    }
    table.or_absent("equivariance: no run was scored on the turned split (`eval.splits`).")
}
