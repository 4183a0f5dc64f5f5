//! Runs made in memory, for the report's tests.

use std::path::PathBuf;

use super::gather::{Eval, Run};
use crate::evaluation::{EvalReport, ModeScores, StepRow};
use crate::learners::Learner;
use crate::metrics::{Scores, bootstrap_mean_interval, mean};
use crate::provenance::Provenance;

/// A run of the main method that nothing has scored yet.
pub(super) fn run(name: &str, task: &str, demonstrations: usize, training_seed: u64) -> Run {
    Run {
        folder: PathBuf::from(name),
        name: name.to_owned(),
        task: task.to_owned(),
        variant: None,
        demonstrations: Some(demonstrations),
        training_seed: Some(training_seed),
        shipped: false,
        config: None,
        evals: Vec::new(),
        acting: Vec::new(),
        timed_with: None,
        samplers: None,
        stages: Vec::new(),
        missing: Vec::new(),
    }
}

/// The run with scores of `learner` on the test split: for each number of steps the error of each episode, the same for every action.
pub(super) fn scored(mut run: Run, learner: Learner, rows: &[(usize, &[f64])]) -> Run {
    let report = EvalReport {
        rows: rows.iter().map(|(steps, errors)| row(*steps, errors)).collect(),
        straightness: None,
        against_most_steps: Vec::new(),
        turned: None,
        trivial: None,
        task: Some(run.task.clone()),
        split: None,
        episodes: rows.first().map_or(0, |(_, errors)| errors.len()),
        seeds: vec![3407],
        checkpoint: "checkpoint".to_owned(),
        data: "data/test.npz".to_owned(),
        data_hash: run.task.clone(),
        train_data: None,
        config: serde_json::Value::Null,
        provenance: Provenance::gather("cpu"),
    };
    run.evals.push(Eval { learner, split: "test".to_owned(), report });
    run
}

/// A run on scenes with two experts: Flow 2 in one step, with so many samples between them and with the first of them.
pub(super) fn coin_toss(name: &str, training_seed: u64, between: f64, first: f64) -> Run {
    let mut run = scored(run(name, "coin_toss", 2000, training_seed), Learner::Flow(2), &[(1, &[0.5, 0.5])]);
    run.evals[0].report.rows[0].modes = Some(ModeScores {
        share_per_mode: [first, 1.0 - first],
        rarer_share_within_scene: 0.25,
        share_between: between,
        between_d_geo: 0.1,
        d_geo_nearer: 0.02,
        d_geo_apart: 1.0,
        energy_distance: Some(0.05),
    });
    run
}

/// A row of Euler's rule.
fn row(steps: usize, errors: &[f64]) -> StepRow {
    let d_geo = mean(errors).unwrap_or_default();
    let interval = bootstrap_mean_interval(errors);
    StepRow {
        steps,
        evaluations: steps,
        solver: "euler".to_owned(),
        scores: Scores {
            d_geo_mean: d_geo,
            d_geo_std: None,
            d_geo_episode_std: None,
            d_geo_low: interval.map(|interval| interval.low),
            d_geo_high: interval.map(|interval| interval.high),
            d_geo_half_turn_mean: d_geo,
            rotation_rad: d_geo,
            translation_m: 0.0,
            opening_error: 0.0,
            per_action_mean: vec![d_geo; 10],
            per_action_std: vec![None; 10],
            per_seed: vec![d_geo],
            per_episode: errors.to_vec(),
        },
        per_node: Vec::new(),
        node_spread: None,
        calibration: None,
        latency: None,
        modes: None,
        secs: 0.0,
    }
}
