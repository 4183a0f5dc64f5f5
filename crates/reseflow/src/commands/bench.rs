//! `reseflow bench`: how long single plans take.

use std::path::Path;

use super::planner::Planner;
use crate::cli::BenchArgs;
use crate::error::{about_data, bad_input};
use crate::evaluation::{LatencyReport, time_plans};
use crate::output::Terminal;
use crate::pipeline::FinishedRun;

/// Runs the command.
pub(super) fn execute(args: &BenchArgs, terminal: &Terminal) -> anyhow::Result<()> {
    let reports = match (&args.checkpoint, &args.data) {
        (Some(checkpoint), Some(data)) => vec![time_policy(args, checkpoint, data, terminal)?],
        _ if args.runs.is_empty() => {
            return Err(bad_input(
                "there is nothing to time: expected folders of finished runs, or --checkpoint and --data",
            ));
        }
        _ => time_runs(args, terminal)?,
    };
    for report in &reports {
        terminal.say(&report.of);
        terminal.say(report.table());
    }
    terminal.machine(&reports)
}

/// Times nothing unless every folder can be timed.
fn time_runs(args: &BenchArgs, terminal: &Terminal) -> anyhow::Result<Vec<LatencyReport>> {
    let runs: Vec<FinishedRun> =
        args.runs.iter().map(|folder| FinishedRun::open(folder)).collect::<anyhow::Result<_>>()?;
    runs.iter().map(|run| run.time(terminal)).collect()
}

fn time_policy(
    args: &BenchArgs,
    checkpoint: &Path,
    data: &Path,
    terminal: &Terminal,
) -> anyhow::Result<LatencyReport> {
    let solver = args.solver.choice(!args.steps.is_empty())?;
    let device = args.device.into();
    let Planner { folder, policy, data: read, out } =
        Planner::load(checkpoint, data, args.out.as_deref(), device, terminal)?;
    let steps = if args.steps.is_empty() { policy.usual_steps() } else { args.steps.clone() };
    let name = checkpoint.display().to_string();
    let mut report = LatencyReport::new(&name, device);
    let timed = time_plans(&name, &folder, &policy, &read.dataset, &solver.with_each(&steps));
    report.rows = timed.map_err(|fault| about_data(data, None, fault))?;
    out.map_or(Ok(()), |out| out.write_json(&report))?;
    Ok(report)
}
