//! `reseflow inspect`: what a file holds, found out from the file and not from its name.

use std::collections::BTreeSet;
use std::io::Read;
use std::path::Path;

use reseflow_data::{
    DataError, DatasetSummary, HashCheck, McapSummary, PairMeta, PairSet, PoseRange, Predictions,
};
use serde::Serialize;

use crate::cli::InspectArgs;
use crate::error::bad_input;
use crate::output::{Table, Terminal};

#[derive(Debug, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
enum Contents {
    DataSet(Box<DatasetSummary>),
    Predictions(PredictionSummary),
    Pairs(PairSummary),
    Log(McapSummary),
}

#[derive(Debug, Serialize)]
struct PredictionSummary {
    episodes: usize,
    seeds: usize,
    horizon: usize,
}

#[derive(Debug, Serialize)]
struct PairSummary {
    windows: usize,
    noises: usize,
    horizon: usize,
    episodes: usize,
    #[serde(flatten)]
    meta: PairMeta,
}

/// Runs the command.
pub(super) fn execute(args: &InspectArgs, terminal: &Terminal) -> anyhow::Result<()> {
    let contents = read(&args.file)?;
    terminal.say(match &contents {
        Contents::DataSet(summary) => data_set_table(&args.file, summary),
        Contents::Predictions(summary) => prediction_table(&args.file, summary),
        Contents::Pairs(summary) => pair_table(&args.file, summary),
        Contents::Log(summary) => log_table(&args.file, summary),
    });
    terminal.machine(&contents)
}

fn read(path: &Path) -> anyhow::Result<Contents> {
    let mut start = [0; 8];
    let mut file =
        std::fs::File::open(path).map_err(|source| DataError::Io { path: path.to_owned(), source })?;
    let length = file.read(&mut start).map_err(|source| DataError::Io { path: path.to_owned(), source })?;
    match &start[..length] {
        [0x89, b'M', b'C', b'A', b'P', ..] => Ok(Contents::Log(McapSummary::read(path)?)),
        [b'P', b'K', ..] => read_npz(path),
        _ => {
            let place = path.display();
            Err(bad_input(format!(
                "{place}: neither an npz archive nor an MCAP log, expected one of the two"
            )))
        }
    }
}

/// What the names of its arrays make it: `window` a pair file, `pose` a prediction file, everything else ought to be a data set.
fn read_npz(path: &Path) -> anyhow::Result<Contents> {
    let data_set = match DatasetSummary::read(path) {
        Ok(summary) => return Ok(Contents::DataSet(Box::new(summary))),
        Err(fault) => fault,
    };
    if let Ok(predictions) = Predictions::read(path) {
        let seeds = predictions.chunks.first().map_or(0, Vec::len);
        let horizon = predictions.chunks.first().and_then(|of| of.first()).map_or(0, |chunk| chunk.len());
        let episodes = predictions.chunks.len();
        return Ok(Contents::Predictions(PredictionSummary { episodes, seeds, horizon }));
    }
    match PairSet::read(path) {
        Ok(pairs) => Ok(Contents::Pairs(PairSummary::of(pairs))),
        // What is wrong with the pairs is the fault only where there are some.
        Err(fault) if !fault.to_string().contains("no array `window`") => Err(fault.into()),
        Err(_) => Err(data_set.into()),
    }
}

impl PairSummary {
    fn of(PairSet { windows, meta }: PairSet) -> Self {
        let first = windows.first();
        let episodes: BTreeSet<usize> = windows.iter().map(|of| of.window.episode).collect();
        Self {
            windows: windows.len(),
            noises: first.map_or(0, |of| of.pairs.len()),
            horizon: first.and_then(|of| of.pairs.first()).map_or(0, |pair| pair.noise.len()),
            episodes: episodes.len(),
            meta,
        }
    }
}

fn data_set_table(path: &Path, summary: &DatasetSummary) -> Table {
    let mut table = Table::facts("data set", &path.display().to_string());
    let mut row = |name: &str, value: String| table.fact(name, value);
    row(
        "episodes E / steps T / points N",
        format!("{} / {} / {}", summary.episodes, summary.steps, summary.points),
    );
    if let Some(meta) = &summary.meta {
        let split = meta.split.map_or_else(|| "unknown split".to_owned(), |split| split.to_string());
        row("task", format!("{} ({split})", meta.task));
        row("engine", meta.engine.clone());
        row("attempts dropped", meta.attempts_dropped.to_string());
    }
    if let Some(fault) = &summary.meta_fault {
        row("meta ignored", fault.clone());
    }
    let metres = |low: &[f64; 3], high: &[f64; 3]| {
        let axis = |i: usize| format!("[{:.3}, {:.3}]", low[i], high[i]);
        format!("{} × {} × {}", axis(0), axis(1), axis(2))
    };
    let widen = |bound: &[f32; 3]| bound.map(f64::from);
    row("points (m)", metres(&widen(&summary.points_min_m), &widen(&summary.points_max_m)));
    for (name, range) in [("gripper", &summary.gripper), ("action", &summary.action)] {
        let PoseRange { position_min_m, position_max_m, angle_max_rad, opening } = range;
        row(&format!("{name} position (m)"), metres(position_min_m, position_max_m));
        row(&format!("{name} angle up to (rad)"), format!("{angle_max_rad:.3}"));
        row(&format!("{name} opening"), format!("{:.2} to {:.2}", opening[0], opening[1]));
    }
    if summary.disturbed > 0 {
        row("disturbed episodes", summary.disturbed.to_string());
    }
    row("targets that are padding", format!("{:.1} %", 100.0 * summary.padded_share));
    let check = match summary.hash_check {
        HashCheck::Absent => "nothing to compare with",
        HashCheck::Matches => "as recorded",
        HashCheck::Differs => "arrays were changed after recording",
    };
    let short: String = summary.content_hash.chars().take(16).collect();
    row("content hash", format!("{short}… ({check})"));
    table
}

fn prediction_table(path: &Path, summary: &PredictionSummary) -> Table {
    let mut table = Table::facts("predictions", &path.display().to_string());
    table.fact("episodes E", summary.episodes);
    table.fact("noise seeds S", summary.seeds);
    table.fact("horizon L", summary.horizon);
    table
}

fn pair_table(path: &Path, summary: &PairSummary) -> Table {
    let mut table = Table::facts("pairs", &path.display().to_string());
    table.fact(
        "windows W / noises M / horizon L",
        format!("{} / {} / {}", summary.windows, summary.noises, summary.horizon),
    );
    table.fact("episodes", summary.episodes);
    let short = |hash: &str| hash.chars().take(16).collect::<String>() + "…";
    table.fact("checkpoint", short(&summary.meta.checkpoint_hash));
    table.fact("data", short(&summary.meta.data_hash));
    table.fact("settings", &summary.meta.settings);
    table
}

fn log_table(path: &Path, summary: &McapSummary) -> Table {
    let name = path.display().to_string();
    let mut table = Table::figures([&name, "schema", "messages", "from (s)", "to (s)", "spacing (ms)"]);
    let secs = |nanos: u64| format!("{:.3}", nanos as f64 * 1e-9);
    for topic in &summary.topics {
        let spacing = topic
            .spacing_nanos
            .map_or_else(String::new, |[_, median, _]| format!("{:.1}", median as f64 * 1e-6));
        table.row([
            topic.topic.clone(),
            topic.schema.clone(),
            topic.messages.to_string(),
            secs(topic.first_nanos),
            secs(topic.last_nanos),
            spacing,
        ]);
    }
    table
}
