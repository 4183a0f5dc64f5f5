//! `cargo xtask reproduce`: every experiment behind the tables and figures, one after another, and their report.
//!
//! What runs stands in `configs/reproduce.toml`. Each experiment is a `reseflow run`, which skips what it has done before and goes on
//! with an interrupted training, so this may be interrupted and called again at any time.

mod plan;

use std::time::{Duration, Instant};

use anyhow::Result;

use crate::process::{self, Failure, cargo, complain, say};
use crate::workspace;
use plan::{Experiment, Pipeline, Plan};

/// Where the plan is.
const PLAN: &str = "configs/reproduce.toml";

/// Run every experiment behind the report, or score the policies that ship with the program; resumable.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    cargo xtask reproduce                  one training seed of everything, then the report\n  \
    cargo xtask reproduce --full           and two more training seeds, and the ablations\n  \
    cargo xtask reproduce --pretrained     no training: the policies in assets/pretrained\n  \
    cargo xtask reproduce --full --dry-run what would run")]
pub(crate) struct Args {
    /// Also two more training seeds and the ablations
    #[arg(long, conflicts_with = "pretrained")]
    full: bool,
    /// Train nothing: score the policies that ship with the program
    #[arg(long)]
    pretrained: bool,
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
        say(&format!("reseflow {}", typed(&report(&plan, pipeline, &experiments))));
        return Ok(());
    }

    say("reproduce: building reseflow in release (a first build takes several minutes)");
    process::run(
        "the build of reseflow",
        &mut cargo(["build", "--release", "--locked", "--package", "reseflow"]),
    )?;
    let (started, count) = (Instant::now(), experiments.len());
    let mut failed = Vec::new();
    for (place, experiment) in (1..).zip(&experiments) {
        let (name, begun) = (&experiment.name, Instant::now());
        say(&format!("reproduce {place}/{count}: {name}"));
        let how = match reseflow(name, &plan.words(experiment)) {
            Ok(()) => "done",
            Err(fault) => {
                complain(&format!("{fault:#}"));
                failed.push(name.as_str());
                "failed"
            }
        };
        let (took, total) = (clock(begun.elapsed()), clock(started.elapsed()));
        say(&format!("reproduce {place}/{count}: {name} {how} in {took}, {total} since the build"));
    }
    let done: Vec<&Experiment> = experiments
        .iter()
        .copied()
        .filter(|experiment| !failed.contains(&experiment.name.as_str()))
        .collect();
    if !done.is_empty() {
        reseflow("the report", &report(&plan, pipeline, &done))?;
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

fn reseflow(what: &str, words: &[String]) -> Result<()> {
    let mut command = cargo(["run", "--quiet", "--release", "--locked", "--package", "reseflow", "--"]);
    process::run(what, command.args(words))
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

fn clock(time: Duration) -> String {
    let secs = time.as_secs();
    format!("{} h {:02} min {:02} s", secs / 3600, secs / 60 % 60, secs % 60)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_printed_can_be_typed() {
        assert_eq!(quoted("data.train_episodes=10"), "data.train_episodes=10");
        assert_eq!(quoted("eval.splits=[\"test\"]"), "'eval.splits=[\"test\"]'");
        assert_eq!(clock(Duration::from_secs(3723)), "1 h 02 min 03 s");
    }
}
