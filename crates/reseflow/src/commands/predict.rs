//! `reseflow predict`: trajectories from each episode's first observation, as arrays.

use reseflow_data::{Dataset, Predictions};
use serde::Serialize;

use crate::cli::PredictArgs;
use crate::evaluation::{noise_seeds, predict_first};
use crate::learning::load_policy;
use crate::output::{OutputFile, Table, Terminal};

#[derive(Debug, Serialize)]
struct PredictReport {
    out: String,
    episodes: usize,
    seeds: Vec<u64>,
    steps: usize,
    secs: f64,
}

/// Runs the command.
pub(super) fn execute(args: &PredictArgs, terminal: &Terminal) -> anyhow::Result<()> {
    let dataset = Dataset::read(&args.data)?;
    let policy = load_policy(&args.checkpoint, args.device.into())?;
    let out = OutputFile::claim_apart(&args.out, &[&args.data, &args.checkpoint])?;

    let seeds = noise_seeds(args.seeds);
    let started = std::time::Instant::now();
    let samples = predict_first(&policy, &dataset, &seeds, args.steps)?;
    let secs = started.elapsed().as_secs_f64();
    let chunks =
        samples.into_iter().map(|of| of.into_iter().map(|sample| sample.consensus).collect()).collect();
    Predictions { chunks }.write(out.path())?;

    let report = PredictReport {
        out: args.out.display().to_string(),
        episodes: dataset.len(),
        seeds,
        steps: args.steps,
        secs,
    };
    let mut table = Table::facts("predictions", &report.out);
    table.fact("episodes", report.episodes);
    table.fact("noise seeds", report.seeds.len());
    table.fact("integration steps", report.steps);
    table.fact("time", format!("{secs:.2} s"));
    terminal.say(table);
    terminal.machine(&report)
}
