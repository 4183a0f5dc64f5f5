//! `cargo xtask reproduce`: every experiment behind the tables and figures, some side by side, and their report.
//!
//! What runs stands in `configs/reproduce.toml`. Each experiment is a `reseflow run`, which skips what it has done before and goes on
//! with an interrupted training, so this may be interrupted and called again at any time.

mod plan;

use std::num::NonZeroUsize;
use std::time::Instant;

use anyhow::Result;

use crate::jobs::{self, Job, clock, default_width};
use crate::process::{self, Failure, Program, say};
use crate::workspace;
use plan::{Experiment, Pipeline, Plan};

/// Where the plan is.
const PLAN: &str = "configs/reproduce.toml";

/// Run every experiment behind the report, or score the policies that ship with the program; resumable.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    cargo xtask reproduce                  one training seed of everything, then the report\n  \
    cargo xtask reproduce --full           and everything else that is planned\n  \
    cargo xtask reproduce --pretrained     no training: the policies in assets/pretrained\n  \
    cargo xtask reproduce --full --dry-run what would run")]
pub(crate) struct Args {
    /// Also other numbers of demonstrations, two experts, two more training seeds, velocities instead of endpoints, and the ablations
    #[arg(long, conflicts_with = "pretrained")]
    full: bool,
    /// Train nothing: score the policies that ship with the program
    #[arg(long)]
    pretrained: bool,
    /// How many experiments run side by side; as many as there are processor cores, up to eight, unless said
    #[arg(long, value_name = "N")]
    jobs: Option<NonZeroUsize>,
    /// Print the commands and run nothing
    #[arg(long)]
    dry_run: bool,
}

/// Builds in release, runs the plan, and puts the runs that were finished into one report.
pub(crate) fn run(args: &Args) -> Result<()> {
    let plan = Plan::read(&workspace::root().join(PLAN))?;
    let pipeline = match (args.full, args.pretrained) {
        (_, true) => Pipeline::Pretrained,
        (true, false) => Pipeline::Full,
        (false, false) => Pipeline::Usual,
    };
    let experiments = plan.of(pipeline);
    if args.dry_run {
        for experiment in &experiments {
            say(&format!("reseflow {}", typed(&plan.words(experiment))));
        }
        for words in [timing(&plan, &experiments), report(&plan, pipeline, &experiments)] {
            say(&format!("reseflow {}", typed(&words)));
        }
        return Ok(());
    }

    let program = Program::build(&workspace::root().join(plan.output()))?;
    let started = Instant::now();
    let width = args.jobs.map_or_else(default_width, NonZeroUsize::get);
    let jobs = experiments.iter().map(|experiment| Job {
        name: experiment.name.clone(),
        command: program.with(&plan.words(experiment)),
        log: workspace::root().join(plan.folder(&format!("{}.log", experiment.name))),
    });
    let failed = jobs::run("reproduce", jobs.collect(), width)?;
    let done: Vec<&Experiment> =
        experiments.iter().copied().filter(|experiment| !failed.contains(&experiment.name)).collect();
    if !done.is_empty() {
        let timed = process::run("the timing of single plans", &mut program.with(&timing(&plan, &done)));
        process::run("the report", &mut program.with(&report(&plan, pipeline, &done)))?;
        timed?;
    }
    if !failed.is_empty() {
        let (failed, count) = (failed.join(", "), failed.len());
        return Err(Failure::new(format!(
            "{count} experiments failed: {failed}; the same command again goes on from what is done"
        ))
        .into());
    }
    say(&format!("reproduce: all done in {}", clock(started.elapsed())));
    Ok(())
}

/// The words of the call that times every policy when no run is at work any more: side by side they would slow each other down.
fn timing(plan: &Plan, experiments: &[&Experiment]) -> Vec<String> {
    let folders = experiments.iter().map(|experiment| plan.folder(&experiment.name));
    std::iter::once("bench".to_owned()).chain(folders).collect()
}

/// The words of the call that makes the report.
fn report(plan: &Plan, pipeline: Pipeline, experiments: &[&Experiment]) -> Vec<String> {
    let mut words = vec!["report".to_owned()];
    words.extend(experiments.iter().map(|experiment| plan.folder(&experiment.name)));
    let name = if pipeline == Pipeline::Pretrained { "report-pretrained" } else { "report" };
    words.extend(["--out".to_owned(), plan.folder(name)]);
    words
}

/// Words as one would type them.
fn typed(words: &[String]) -> String {
    words.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" ")
}

fn quoted(word: &str) -> String {
    let plain = word.chars().all(|c| c.is_ascii_alphanumeric() || "-_./=".contains(c));
    if plain { word.to_owned() } else { format!("'{word}'") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_printed_can_be_typed() {
        assert_eq!(quoted("data.train_episodes=10"), "data.train_episodes=10");
        assert_eq!(quoted("eval.splits=[\"test\"]"), "'eval.splits=[\"test\"]'");
    }
}
