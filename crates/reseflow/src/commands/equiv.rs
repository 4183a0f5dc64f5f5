//! `reseflow equiv`: whether a policy's plans move with the scene.

use reseflow_data::Dataset;
use serde::Serialize;

use crate::cli::EquivArgs;
use crate::error::{about_data, bad_input};
use crate::evaluation::{EquivarianceError, equivariance_error, noise_seeds, note_task, turned};
use crate::learning::{LearnedPolicy, find_policy};
use crate::output::{OutputFile, Table, Terminal};
use crate::provenance::Provenance;

#[derive(Debug, Serialize)]
struct EquivReport {
    rows: Vec<EquivarianceError>,
    episodes: usize,
    seeds: Vec<u64>,
    checkpoint: String,
    data: String,
    provenance: Provenance,
}

/// Runs the command.
pub(super) fn execute(args: &EquivArgs, terminal: &Terminal) -> anyhow::Result<()> {
    let solver = args.solver.choice(!args.steps.is_empty())?;
    let folder = find_policy(&args.checkpoint)?;
    let policy = LearnedPolicy::load(&folder, args.device.into())?;
    let here = Dataset::read(&args.data)?;
    if here.is_empty() {
        return Err(bad_input(format!("{}: holds no episode, expected at least one", args.data.display())));
    }
    note_task(&folder, &args.data, &here, terminal)?;
    let out =
        args.out.as_deref().map(|out| OutputFile::claim_apart(out, &[&args.data, &folder])).transpose()?;

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
        episodes: here.len(),
        seeds,
        checkpoint: folder.display().to_string(),
        data: args.data.display().to_string(),
        provenance: Provenance::gather(&format!("{:?}", args.device).to_lowercase()),
    };
    out.map_or(Ok(()), |out| out.write_json(&report))?;
    terminal.say(table);
    terminal.machine(&report)?;
    match args.at_most {
        Some(bound) if report.rows.iter().any(|row| row.p999 > bound) => {
            let worst = report.rows.iter().map(|row| row.p999).fold(0.0, f64::max);
            anyhow::bail!("the 99.9th percentile is {worst:.1e}, expected at most {bound:.1e}")
        }
        _ => Ok(()),
    }
}
