//! `reseflow bench`: how long single plans take.

use std::path::Path;

use reseflow_data::Dataset;

use crate::cli::BenchArgs;
use crate::error::{about_data, bad_input};
use crate::evaluation::{LatencyReport, note_task, time_plans};
use crate::learning::{LearnedPolicy, find_policy};
use crate::output::{OutputFile, Terminal};
use crate::pipeline::time_run;

/// Runs the command.
pub(super) fn execute(args: &BenchArgs, terminal: &Terminal) -> anyhow::Result<()> {
    let reports = match (&args.checkpoint, &args.data) {
        (Some(checkpoint), Some(data)) => {
            let report = time_policy(args, checkpoint, data, terminal)?;
            terminal.say(report.table());
            return terminal.machine(&report);
        }
        _ => args.runs.iter().map(|folder| {
            let report = time_run(folder, terminal)?;
            terminal.say(folder.display());
            terminal.say(report.table());
            Ok(report)
        }),
    };
    terminal.machine(&reports.collect::<anyhow::Result<Vec<_>>>()?)
}

fn time_policy(
    args: &BenchArgs,
    checkpoint: &Path,
    data: &Path,
    terminal: &Terminal,
) -> anyhow::Result<LatencyReport> {
    let solver = args.solver.choice(!args.steps.is_empty())?;
    let folder = find_policy(checkpoint)?;
    let policy = LearnedPolicy::load(&folder, args.device.into())?;
    let dataset = Dataset::read(data)?;
    if dataset.is_empty() {
        return Err(bad_input(format!("{}: holds no episode, expected at least one", data.display())));
    }
    note_task(&folder, data, &dataset, terminal)?;
    let out = args.out.as_deref().map(|out| OutputFile::claim_apart(out, &[data, &folder])).transpose()?;
    let steps = if args.steps.is_empty() { policy.usual_steps() } else { args.steps.clone() };
    let mut report = LatencyReport::new(args.device.into());
    let name = checkpoint.display().to_string();
    let timed = time_plans(&name, &policy, &dataset, &solver.with_each(&steps));
    report.rows = timed.map_err(|fault| about_data(data, None, fault))?;
    out.map_or(Ok(()), |out| out.write_json(&report))?;
    Ok(report)
}
