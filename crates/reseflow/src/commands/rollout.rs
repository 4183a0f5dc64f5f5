//! `reseflow rollout`: a policy in the simulator, counted and logged.

use std::path::{Path, PathBuf};

use reseflow_data::Task;

use crate::cli::RolloutArgs;
use crate::config::PlanChoice;
use crate::error::bad_input;
use crate::learning::{LearnedPolicy, find_policy, learned_task};
use crate::output::{OutputFile, Terminal};
use crate::provenance::Provenance;
use crate::rollouts::{
    Actor, EpisodeResult, PREVIEW_EPISODES, PictureBook, PreviewFiles, RolloutReport, RolloutRequest, Script,
    Witness, find_split_task, run_episodes,
};
use reseflow_train::DeviceKind;

/// Runs the command.
pub(super) fn execute(args: &RolloutArgs, terminal: &Terminal) -> anyhow::Result<()> {
    let camera = args.camera.settings()?;
    let task = find_split_task(&args.task, args.split, camera)?;
    let device: DeviceKind = args.device.into();
    let choice = args.solver.choice(args.steps.is_some())?;
    let checkpoint = match args.policy.as_str() {
        "expert" | "still" => None,
        given => Some(find_policy(Path::new(given))?),
    };
    let mut learned = checkpoint.as_deref().map(|folder| LearnedPolicy::load(folder, device)).transpose()?;
    checkpoint.as_deref().map_or(Ok(()), |folder| check_task(folder, args))?;
    let observation_horizon = learned.as_ref().map_or(1, |policy| policy.sampler().observation_horizon());
    let solver = learned.is_some().then(|| choice.with_steps(args.steps.unwrap_or(1)));
    let mut actor = match (&mut learned, solver) {
        (Some(policy), Some(solver)) => Actor::Learned(policy.acting(solver)),
        _ if args.policy == "expert" => Actor::Scripted(Script::Expert),
        _ => Actor::Scripted(Script::Still),
    };
    let request = RolloutRequest {
        split: args.split.into(),
        seed: args.seed,
        episodes: args.episodes,
        observation_horizon,
        n_action_steps: args.n_action_steps,
        plan_choice: if checkpoint.is_some() { args.plan_choice } else { PlanChoice::Newest },
        disturb: args.disturb,
    };
    let mut others: Vec<&Path> =
        args.preview.iter().map(PathBuf::as_path).chain(checkpoint.as_deref()).collect();
    let log = args.mcap.as_deref().map(|path| OutputFile::claim_apart(path, &others)).transpose()?;
    others.extend(args.mcap.as_deref());
    let out = OutputFile::claim_apart(&args.out, &others)?;
    let results = run(args, task.as_ref(), &request, &mut actor, log.as_ref(), terminal)?;
    let provenance = Provenance::gather(device.name());
    let split = args.split.to_string();
    let mut report =
        RolloutReport::new(&args.policy, solver.as_ref(), &args.task, &split, &request, &results, provenance)
            .under_camera(camera);
    if let Some(checkpoint) = &checkpoint {
        report = report.of_checkpoint(checkpoint);
    }
    out.write_json(&report)?;
    terminal.say(report.table());
    terminal.machine(&report)
}

/// Refuses a policy that has learned another task, unless that is wanted.
fn check_task(checkpoint: &Path, args: &RolloutArgs) -> anyhow::Result<()> {
    match learned_task(checkpoint)? {
        Some(learned) if learned != args.task && !args.any_task => Err(bad_input(format!(
            "{}: has learned the task `{learned}`, not `{}`; --any-task lets it act all the same",
            checkpoint.display(),
            args.task
        ))),
        _ => Ok(()),
    }
}

fn run(
    args: &RolloutArgs,
    task: &dyn Task,
    request: &RolloutRequest,
    actor: &mut Actor<'_>,
    log: Option<&OutputFile>,
    terminal: &Terminal,
) -> anyhow::Result<Vec<EpisodeResult>> {
    let mut witness = Witness::default();
    if let Some(log) = log {
        witness = witness.with_log(log.path(), args.mcap_episodes)?;
    }
    let preview = args.preview.as_deref().map(PreviewFiles::claim).transpose()?;
    if preview.is_some() {
        witness = witness.with_pictures(PictureBook::new(&args.policy, &task.spec()), PREVIEW_EPISODES);
    }
    let progress = terminal.progress("rollouts", args.episodes as u64);
    let results = run_episodes(task, request, actor, &mut witness, &|| progress.advance())?;
    progress.finish();
    if let (Some(files), Some(pictures)) = (&preview, witness.finish()?) {
        files.write(&pictures)?;
    }
    Ok(results)
}
