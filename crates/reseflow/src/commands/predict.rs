//! `reseflow predict`: trajectories from each episode's first observation, as arrays.

use reseflow_data::{Dataset, Predictions};
use serde::Serialize;

use crate::cli::PredictArgs;
use crate::error::about_data;
use crate::evaluation::{noise_seeds, note_task, predict_first};
use crate::learning::{LearnedPolicy, find_policy};
use crate::output::{OutputFile, Table, Terminal};

#[derive(Debug, Serialize)]
struct PredictReport {
    out: String,
    episodes: usize,
    seeds: Vec<u64>,
    solver: &'static str,
    steps: usize,
    evaluations: usize,
    secs: f64,
}

/// Runs the command.
pub(super) fn execute(args: &PredictArgs, terminal: &Terminal) -> anyhow::Result<()> {
    let dataset = Dataset::read(&args.data)?;
    let solver = args.solver.choice(args.steps.is_some())?.with_steps(args.steps.unwrap_or(1));
    let checkpoint = find_policy(&args.checkpoint)?;
    let policy = LearnedPolicy::load(&checkpoint, args.device.into())?;
    let out = OutputFile::claim_apart(&args.out, &[&args.data, &checkpoint])?;

    let seeds = noise_seeds(args.seeds);
    let started = std::time::Instant::now();
    note_task(&checkpoint, &args.data, &dataset, terminal)?;
    let drawn = predict_first(policy.sampler(), &dataset, &seeds, &solver)
        .map_err(|fault| about_data(&args.data, None, fault))?;
    let secs = started.elapsed().as_secs_f64();
    let chunks =
        drawn.samples.into_iter().map(|of| of.into_iter().map(|sample| sample.consensus).collect()).collect();
    Predictions { chunks }.write(out.path())?;

    let report = PredictReport {
        out: args.out.display().to_string(),
        episodes: dataset.len(),
        seeds,
        solver: solver.name(),
        steps: drawn.steps,
        evaluations: drawn.evaluations,
        secs,
    };
    let mut table = Table::facts("predictions", &report.out);
    table.fact("episodes", report.episodes);
    table.fact("noise seeds", report.seeds.len());
    table.fact(
        "integration steps",
        format!("{} ({}, {} evaluations)", report.steps, report.solver, report.evaluations),
    );
    table.fact("time", format!("{secs:.2} s"));
    terminal.say(table);
    terminal.machine(&report)
}
