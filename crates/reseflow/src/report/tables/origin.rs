//! Where figures come from, and what they cost.

use super::super::document::{Block, Table, dash};
use super::super::gather::Run;
use super::super::study::Study;

/// Commit, machine, seeds and data of each run, and its configuration folded away.
pub(in super::super) fn origin(study: &Study) -> Vec<Block> {
    let mut table = Table::new(
        "One line a run: what made it. A `+` after the commit marks changed files.",
        [
            "run",
            "task",
            "demonstrations",
            "training seed",
            "test episodes",
            "noise seeds",
            "commit",
            "version",
            "device",
            "processor",
            "threads",
            "test data",
        ],
    );
    let mut folded = Vec::new();
    for run in &study.runs {
        let first = run.evals.first().map(|eval| &eval.report);
        let provenance = run.provenance();
        let seeds = first.and_then(|report| Some((*report.seeds.first()?, *report.seeds.last()?)));
        table.row([
            run.name.clone(),
            run.task.clone(),
            run.demonstrations.map_or_else(dash, |count| count.to_string()),
            run.training_seed.map_or_else(dash, |seed| seed.to_string()),
            first.map_or_else(dash, |report| report.episodes.to_string()),
            seeds.map_or_else(dash, |(first, last)| format!("{first}–{last}")),
            provenance.and_then(|of| of.commit.as_deref().map(short)).unwrap_or_else(dash),
            provenance.map_or_else(dash, |of| of.version.clone()),
            provenance.map_or_else(dash, |of| of.device.clone()),
            provenance.and_then(|of| of.processor.clone()).unwrap_or_else(dash),
            provenance.map_or_else(dash, |of| of.threads.to_string()),
            first.map_or_else(dash, |report| report.data_hash.chars().take(12).collect()),
        ]);
        if let Some(text) = &run.config {
            folded
                .push(Block::Folded { title: format!("configuration of {}", run.name), text: text.clone() });
        }
    }
    let mut blocks = vec![Block::Table(table)];
    blocks.extend(folded);
    blocks
}

/// The first characters of a commit, and its mark.
fn short(commit: &str) -> String {
    let mark = if commit.ends_with('+') { "+" } else { "" };
    let hash: String = commit.trim_end_matches('+').chars().take(12).collect();
    format!("{hash}{mark}")
}

/// The seconds that each stage of a run took.
pub(in super::super) fn stages(study: &Study) -> Block {
    let mut table = Table::new(
        "Wall-clock time of each stage, as the runs noted it; of a training that was interrupted, the last part only.",
        ["run", "data", "training", "evaluation", "rollouts", "whole"],
    );
    for run in study.runs.iter().filter(|run| !run.stages.is_empty()) {
        let of =
            |names: &[&str]| duration(total(run, |stage| names.iter().any(|name| stage.starts_with(name))));
        table.row([
            run.name.clone(),
            of(&["data"]),
            of(&["train", "pairs"]),
            of(&["eval"]),
            of(&["rollout"]),
            duration(total(run, |_| true)),
        ]);
    }
    table.or_absent("times: no run holds a summary.")
}

fn total(run: &Run, counts: impl Fn(&str) -> bool) -> f64 {
    run.stages.iter().filter(|(name, _)| counts(name)).map(|(_, secs)| secs).sum()
}

fn duration(secs: f64) -> String {
    let whole = secs.round() as u64;
    match whole {
        ..60 => format!("{secs:.1} s"),
        60..3600 => format!("{} min {:02} s", whole / 60, whole % 60),
        _ => format!("{} h {:02} min", whole / 3600, whole % 3600 / 60),
    }
}
