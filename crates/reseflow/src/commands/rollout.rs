//! `reseflow rollout`: a policy in the simulator, counted and logged.

use reseflow_data::McapLog;

use crate::cli::RolloutArgs;
use crate::output::{OutputFile, Terminal};
use crate::provenance::Provenance;
use crate::rollouts::{Actor, RolloutReport, RolloutRequest, Script, Witness, find_task, run_episodes};

/// Runs the command.
pub(super) fn execute(args: &RolloutArgs, terminal: &Terminal) -> anyhow::Result<()> {
    let task = find_task(&args.task)?;
    let mut actor = match args.policy.as_str() {
        "expert" => Actor::Scripted(Script::Expert),
        _ => Actor::Scripted(Script::Still),
    };
    let out = OutputFile::claim(&args.out)?;
    let log = args.mcap.as_deref().map(OutputFile::claim).transpose()?;
    let request = RolloutRequest {
        split: args.split.into(),
        seed: args.seed,
        episodes: args.episodes,
        observation_horizon: 1,
        n_action_steps: args.n_action_steps,
        disturb: args.disturb,
    };
    let mut witness = Witness {
        episodes: if log.is_some() { args.mcap_episodes } else { 0 },
        log: log.as_ref().map(|file| McapLog::create(file.path())).transpose()?,
        pictures: None,
    };
    let progress = terminal.progress("rollouts", args.episodes as u64);
    let results = run_episodes(task.as_ref(), &request, &mut actor, &mut witness, &|| progress.advance())?;
    progress.finish();
    if let Some(log) = witness.log {
        log.finish()?;
    }
    let provenance = Provenance::gather("cpu");
    let report = RolloutReport::new(&args.policy, None, &args.task, &request, &results, provenance);
    out.write_json(&report)?;
    terminal.say(report.table());
    terminal.machine(&report)
}
