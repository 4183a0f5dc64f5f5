//! `cargo xtask pretrain`: trains the policies that ship with the program and puts them where they are found by name.
//!
//! What is trained stands in `configs/pretrained/`, one configuration for each task. A policy's folder under `assets/pretrained` gets the
//! weights and their configuration; beside the policies lie the run's resolved configuration and a card with the figures.

use std::fs;
use std::io::ErrorKind;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use serde_json::{Value, json};

use crate::jobs::{self, Job, default_width};
use crate::process::{Failure, Program, complain, say};
use crate::workspace;

/// The configurations.
const CONFIGS: &str = "configs/pretrained";
/// The runs, of which the policies are taken.
const RUNS: &str = "runs/pretrained";
/// Where the policies are found by name.
const POLICIES: &str = "assets/pretrained";
/// The largest weights that may ship, bytes.
const LARGEST: u64 = 4 << 20;
/// A run's checkpoints and the names of the policies.
const KINDS: [(&str, &str, &str); 3] = [
    ("checkpoint", "flow1", "eval.json"),
    ("checkpoint-2", "flow2", "eval-2.json"),
    ("checkpoint-baseline", "etseed", "eval-baseline.json"),
];

/// Train the policies that ship with the program and install them in assets/pretrained; resumable.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    cargo xtask pretrain                 every task, some side by side; about two hours on two cores\n  \
    cargo xtask pretrain --task door     one of them\n  \
    cargo xtask pretrain --as-is         install finished runs of runs/pretrained, wherever they were trained")]
pub(crate) struct Args {
    /// The task; all unless said
    #[arg(long, value_name = "TASK")]
    task: Vec<String>,
    /// Train nothing: install the runs as they are
    #[arg(long)]
    as_is: bool,
    /// How many trainings run side by side; as many as there are processor cores, up to eight, unless said
    #[arg(long, value_name = "N")]
    jobs: Option<NonZeroUsize>,
}

/// Trains and installs.
pub(crate) fn run(args: &Args) -> Result<()> {
    let root = workspace::root();
    let tasks = tasks(&root.join(CONFIGS))?;
    if let Some(unknown) = args.task.iter().find(|task| !tasks.contains(task)) {
        bail!("there is no {CONFIGS}/{unknown}.toml, expected one of {}", tasks.join(", "));
    }
    let wanted: Vec<&String> =
        tasks.iter().filter(|task| args.task.is_empty() || args.task.contains(task)).collect();
    let mut failed = if args.as_is { Vec::new() } else { train(&wanted, args.jobs)? };
    for task in wanted {
        if failed.contains(task) {
            continue;
        }
        match install(task, &root.join(RUNS).join(task), &root.join(POLICIES).join(task)) {
            Ok(()) => say(&format!("pretrain: {POLICIES}/{task} is installed")),
            Err(fault) => {
                complain(&format!("{task}: {fault:#}"));
                failed.push(task.clone());
            }
        }
    }
    match failed.as_slice() {
        [] => Ok(()),
        failed => Err(Failure::new(format!(
            "not installed: {}; the same command again goes on from what is done",
            failed.join(", ")
        ))
        .into()),
    }
}

/// Builds in release and trains; returns the tasks that failed.
fn train(tasks: &[&String], width: Option<NonZeroUsize>) -> Result<Vec<String>> {
    let program = Program::build(&workspace::root().join(RUNS))?;
    let jobs = tasks.iter().map(|task| Job {
        name: (*task).clone(),
        command: program.with(&["run".to_owned(), format!("{CONFIGS}/{task}.toml")]),
        log: workspace::root().join(format!("{RUNS}/{task}.log")),
    });
    jobs::run("pretrain", jobs.collect(), width.map_or_else(default_width, NonZeroUsize::get))
}

/// The tasks that have a configuration, sorted.
fn tasks(folder: &Path) -> Result<Vec<String>> {
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry?.path();
        if path.extension().is_some_and(|ending| ending == "toml") {
            names.extend(path.file_stem().map(|stem| stem.to_string_lossy().into_owned()));
        }
    }
    names.sort();
    Ok(names)
}

/// Copies the policies of a finished run into `target`, whole or not at all.
fn install(task: &str, run: &Path, target: &Path) -> Result<()> {
    let aside = target.with_extension("partial");
    let clear = || match fs::remove_dir_all(&aside) {
        Err(fault) if fault.kind() != ErrorKind::NotFound => Err(fault),
        _ => Ok(()),
    };
    clear().with_context(|| aside.display().to_string())?;
    if let Err(fault) = gather(task, run, &aside) {
        clear().with_context(|| aside.display().to_string())?;
        return Err(fault);
    }
    if target.exists() {
        fs::remove_dir_all(target).with_context(|| target.display().to_string())?;
    }
    fs::rename(&aside, target).with_context(|| target.display().to_string())
}

/// Copies the policies of a finished run into the folder `aside`, and writes their card.
fn gather(task: &str, run: &Path, aside: &Path) -> Result<()> {
    let mut policies = serde_json::Map::new();
    for (checkpoint, name, scores) in KINDS {
        let (from, to) = (run.join(checkpoint), aside.join(name));
        check_order(&from.join("model.safetensors"), &run.join(scores))?;
        fs::create_dir_all(&to).with_context(|| to.display().to_string())?;
        for file in ["config.toml", "model.safetensors"] {
            copy(&from.join(file), &to.join(file))?;
        }
        let weights = to.join("model.safetensors");
        let bytes = weights.metadata()?.len();
        if bytes > LARGEST {
            bail!("{} has {bytes} bytes, at most {LARGEST} may ship", weights.display());
        }
        policies.insert(name.to_owned(), scored(&read(&run.join(scores))?));
    }
    copy(&run.join("config.toml"), &aside.join("run.toml"))?;
    let (eval, summary) = (read(&run.join("eval.json"))?, read(&run.join("summary.json"))?);
    let card = json!({
        "task": task,
        "command": format!("cargo xtask pretrain --task {task}"),
        "commit": eval["provenance"]["commit"],
        "demonstrations": summary["config"]["data"]["train_episodes"],
        "disturbed_share": summary["config"]["data"]["disturbed_share"].as_f64().unwrap_or(0.0),
        "seed": summary["config"]["train"]["seed"],
        "training_secs": stages(&summary),
        "test_episodes": eval["episodes"],
        "noise_seeds": summary["eval_seeds"],
        "policies": policies,
        "rollouts_of_flow2": summary["series"],
    });
    let text = serde_json::to_string_pretty(&card)? + "\n";
    fs::write(aside.join("card.json"), text).with_context(|| aside.display().to_string())
}

/// Scores that are older than the weights are those of others: the run is being made again.
fn check_order(weights: &Path, scores: &Path) -> Result<()> {
    let written = |path: &Path| {
        path.metadata().and_then(|file| file.modified()).with_context(|| path.display().to_string())
    };
    if written(scores)? < written(weights)? {
        let (scores, weights) = (scores.display(), weights.display());
        bail!("{scores} is older than {weights}: it tells of other weights, and the run is not finished");
    }
    Ok(())
}

/// What a policy reached, for every number of steps.
fn scored(eval: &Value) -> Value {
    let rows = eval["rows"].as_array().map(Vec::as_slice).unwrap_or_default();
    let keys =
        ["steps", "d_geo_mean", "d_geo_std", "d_geo_low", "d_geo_high", "rotation_rad", "translation_m"];
    let row = |row: &Value| keys.map(|key| (key.to_owned(), row[key].clone())).into_iter().collect::<Value>();
    json!({ "episodes": eval["episodes"], "scores": rows.iter().map(row).collect::<Vec<_>>() })
}

/// The seconds of the stages that train.
fn stages(summary: &Value) -> Value {
    let stages = summary["stages"].as_array().map(Vec::as_slice).unwrap_or_default();
    let named = stages.iter().filter_map(|stage| Some((stage["name"].as_str()?, stage["secs"].as_f64()?)));
    let trained = named.filter(|(name, _)| name.starts_with("train") || name.starts_with("pairs"));
    trained.map(|(name, secs)| (name.to_owned(), Value::from(secs.round()))).collect()
}

fn read(path: &PathBuf) -> Result<Value> {
    let text = fs::read_to_string(path).with_context(|| path.display().to_string())?;
    serde_json::from_str(&text).with_context(|| path.display().to_string())
}

fn copy(from: &Path, to: &Path) -> Result<()> {
    fs::copy(from, to).with_context(|| from.display().to_string()).map(drop)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::{Duration, SystemTime};

    #[test]
    fn every_task_of_the_paper_has_a_configuration() {
        let tasks = tasks(&workspace::root().join(CONFIGS)).unwrap();
        assert_eq!(tasks, ["door", "painting", "triangle"]);
    }

    #[test]
    fn a_finished_run_is_installed_whole_and_an_unfinished_one_changes_nothing() {
        let folder = std::env::temp_dir().join(format!("reseflow-pretrain-{}", std::process::id()));
        let (run, target) = (folder.join("run"), folder.join("assets/door"));
        let eval = json!({
            "episodes": 100, "provenance": { "commit": "abc" },
            "rows": [{ "steps": 1, "d_geo_mean": 0.02, "per_action_mean": [0.1] }],
        });
        let summary = json!({
            "eval_seeds": 10, "series": [{ "name": "rollout", "successes": 99 }],
            "config": { "data": { "train_episodes": 3000 }, "train": { "seed": 1 } },
            "stages": [{ "name": "train", "secs": 12.4 }, { "name": "eval", "secs": 1.0 }],
        });
        for (checkpoint, _, scores) in KINDS {
            fs::create_dir_all(run.join(checkpoint)).unwrap();
            fs::write(run.join(checkpoint).join("config.toml"), "kind = \"flow\"").unwrap();
            fs::write(run.join(checkpoint).join("model.safetensors"), checkpoint).unwrap();
            fs::write(run.join(scores), eval.to_string()).unwrap();
        }
        fs::write(run.join("config.toml"), "name = \"door\"").unwrap();
        fs::write(run.join("summary.json"), summary.to_string()).unwrap();

        install("door", &run, &target).unwrap();
        assert_eq!(
            fs::read_to_string(target.join("etseed/model.safetensors")).unwrap(),
            "checkpoint-baseline"
        );
        let card = read(&target.join("card.json")).unwrap();
        assert_eq!((&card["commit"], &card["demonstrations"]), (&json!("abc"), &json!(3000)));
        assert_eq!(card["noise_seeds"], 10);
        assert_eq!(card["training_secs"], json!({ "train": 12.0 }));
        assert_eq!(card["policies"]["flow2"]["scores"][0]["d_geo_mean"], 0.02);
        assert_eq!(card["policies"]["flow2"]["scores"][0].get("per_action_mean"), None);

        fs::write(run.join("checkpoint/model.safetensors"), "other").unwrap();
        fs::remove_file(run.join("eval-2.json")).unwrap();
        assert!(install("door", &run, &target).is_err());
        assert_eq!(fs::read_to_string(target.join("flow1/model.safetensors")).unwrap(), "checkpoint");
        assert!(!folder.join("assets/door.partial").exists(), "half a folder would be taken for a task");

        fs::write(run.join("eval-2.json"), eval.to_string()).unwrap();
        let scores = fs::File::options().write(true).open(run.join("eval.json")).unwrap();
        scores.set_modified(SystemTime::now() - Duration::from_secs(60)).unwrap();
        let fault = install("door", &run, &target).unwrap_err().to_string();
        assert!(fault.contains("it tells of other weights"), "{fault}");
        scores.set_modified(SystemTime::now()).unwrap();
        install("door", &run, &target).unwrap();
        assert_eq!(fs::read_to_string(target.join("flow1/model.safetensors")).unwrap(), "other");
        fs::remove_dir_all(folder).unwrap();
    }
}
