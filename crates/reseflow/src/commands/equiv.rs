//! `reseflow equiv`: whether a policy's plans move with the scene.

use reseflow_data::Dataset;
use serde::Serialize;

use super::planner::Planner;
use crate::cli::EquivArgs;
use crate::error::about_data;
use crate::evaluation::{EquivarianceError, checkpoint_config, equivariance_error, noise_seeds, turned};
use crate::output::{Table, Terminal};
use crate::provenance::Provenance;

#[derive(Debug, Serialize)]
struct EquivReport {
    rows: Vec<EquivarianceError>,
    solver: &'static str,
    episodes: usize,
    seeds: Vec<u64>,
    checkpoint: String,
    data: String,
    data_hash: String,
    config: serde_json::Value,
    provenance: Provenance,
}

/// Runs the command.
pub(super) fn execute(args: &EquivArgs, terminal: &Terminal) -> anyhow::Result<()> {
    let solver = args.solver.choice(!args.steps.is_empty())?;
    let device = args.device.into();
    let Planner { folder, policy, data, out } =
        Planner::load(&args.checkpoint, &args.data, args.out.as_deref(), device, terminal)?;

    let here = first_frames(data.dataset);
    let (there, seeds) = (turned(&here), noise_seeds(args.seeds));
    let steps = if args.steps.is_empty() { vec![1] } else { args.steps.clone() };
    let solvers = solver.with_each(&steps);
    let progress = terminal.progress("equivariance", solvers.len() as u64);
    let mut rows = Vec::with_capacity(solvers.len());
    for solver in &solvers {
        let error = equivariance_error(policy.sampler(), &here, &there, &seeds, solver);
        rows.push(error.map_err(|fault| about_data(&args.data, None, fault))?);
        progress.advance();
    }
    progress.finish();

    let mut table =
        Table::figures(["D_geo to the moved plan", "actions", "median", "99 %", "99.9 %", "largest"]);
    for EquivarianceError { steps, actions, p50, p99, p999, max } in &rows {
        let name = format!("{steps} step{}", if *steps == 1 { "" } else { "s" });
        let [p50, p99, p999, max] = [p50, p99, p999, max].map(|error| format!("{error:.1e}"));
        table.row([name, actions.to_string(), p50, p99, p999, max]);
    }
    let report = EquivReport {
        rows,
        solver: solvers.first().map_or("", |solver| solver.name()),
        episodes: here.len(),
        seeds,
        checkpoint: folder.display().to_string(),
        data: args.data.display().to_string(),
        data_hash: data.content_hash,
        config: checkpoint_config(&folder),
        provenance: Provenance::gather(device.name()),
    };
    out.map_or(Ok(()), |out| out.write_json(&report))?;
    terminal.say(table);
    terminal.machine(&report)?;
    let within = |row: &&EquivarianceError| args.at_most.is_none_or(|bound| row.p999 <= bound);
    match report.rows.iter().find(|row| !within(row)) {
        Some(row) => anyhow::bail!(
            "{}: with {} steps the 99.9th percentile is {:e}, expected at most {:e}",
            args.checkpoint.display(),
            row.steps,
            row.p999,
            args.at_most.unwrap_or_default()
        ),
        None => Ok(()),
    }
}

/// What plans begin from, and as many actions.
fn first_frames(mut dataset: Dataset) -> Dataset {
    for episode in &mut dataset.episodes {
        episode.observations.truncate(1);
        episode.actions.truncate(1);
        episode.alternative = None;
    }
    dataset
}
