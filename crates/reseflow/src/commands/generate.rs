//! `reseflow gen`: the expert's demonstrations as a data-set file.

use serde::Serialize;
use std::path::{Path, PathBuf};

use crate::cli::{GenArgs, SplitArg};
use crate::demonstrations::{self, DemonstrationRequest, ReplayCheck};
use crate::output::{OutputFile, Table, Terminal};
use crate::rollouts::{PREVIEW_EPISODES, PictureBook, PreviewFiles, Witness, find_split_task};

#[derive(Debug, Serialize)]
struct GenReport {
    out: String,
    task: String,
    split: String,
    seed: u64,
    episodes: usize,
    attempts_dropped: u64,
    secs: f64,
    replay: Option<ReplayCheck>,
    preview: Option<String>,
}

/// Runs the command.
pub(super) fn execute(args: &GenArgs, terminal: &Terminal) -> anyhow::Result<()> {
    let camera = args.camera.settings()?;
    let task = find_split_task(&args.task, args.split, camera)?;
    let previews: Vec<&Path> = args.preview.iter().map(PathBuf::as_path).collect();
    let out = OutputFile::claim_apart(&args.out, &previews)?;
    let preview = args.preview.as_deref().map(PreviewFiles::claim).transpose()?;

    let (split, seed, episodes) = (args.split.into(), args.seed, args.episodes);
    let request =
        DemonstrationRequest { split, seed, episodes, camera, disturbed_share: args.disturbed_share };
    let progress = terminal.progress("episodes", args.episodes as u64);
    let mut dataset = demonstrations::record(task.as_ref(), &request, &|| progress.advance())?;
    let secs = progress.finish();
    if args.split == SplitArg::Turned
        && let Some(meta) = &mut dataset.meta
    {
        meta.extra.insert("turned".to_owned(), true.into());
    }
    dataset.write(out.path())?;

    let mut witness = Witness::default();
    if preview.is_some() {
        let pictures = PictureBook::new("stored actions replayed", &task.spec());
        witness = witness.with_pictures(pictures, PREVIEW_EPISODES);
    }
    let mut replay = None;
    if args.verify_replay || preview.is_some() {
        let episodes = if args.verify_replay { args.episodes } else { PREVIEW_EPISODES.min(args.episodes) };
        let progress = terminal.progress("replays", episodes as u64);
        let check = demonstrations::replay(task.as_ref(), out.path(), episodes, &mut witness, &|| {
            progress.advance()
        })?;
        progress.finish();
        replay = args.verify_replay.then_some(check);
    }
    if let (Some(files), Some(pictures)) = (&preview, witness.finish()?) {
        files.write(&pictures)?;
    }

    let report = GenReport {
        out: args.out.display().to_string(),
        task: args.task.clone(),
        split: args.split.to_string(),
        seed: args.seed,
        episodes: dataset.len(),
        attempts_dropped: dataset.meta.as_ref().map_or(0, |meta| meta.attempts_dropped),
        secs,
        replay,
        preview: args.preview.as_deref().map(PreviewFiles::names),
    };
    terminal.say(report.table());
    terminal.machine(&report)
}

impl GenReport {
    fn table(&self) -> Table {
        let mut table = Table::facts("data set", &self.out);
        table.fact(
            "episodes",
            format!("{} ({}, {}, seed {})", self.episodes, self.task, self.split, self.seed),
        );
        table.fact("attempts dropped", self.attempts_dropped);
        table.fact("time", format!("{:.1} s", self.secs));
        if let Some(ReplayCheck { episodes, successes, success_low, success_high }) = self.replay {
            let text =
                format!("{successes} of {episodes} solved (95 %: {success_low:.3} to {success_high:.3})");
            table.fact("replayed open loop", text);
        }
        if let Some(preview) = &self.preview {
            table.fact("picture, film", preview);
        }
        table
    }
}
