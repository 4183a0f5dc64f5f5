//! `reseflow reflow`: a trained flow into the next, straighter one.

use std::path::PathBuf;

use reseflow_data::{Dataset, DatasetFile};
use reseflow_train::Resume;

use crate::cli::ReflowArgs;
use crate::config::load_experiment;
use crate::error::{about_data, bad_input};
use crate::learning::load_flow;
use crate::output::{OutputFile, OutputFolder, Terminal};
use crate::reflow::{ReflowReport, Round};

/// Runs the command.
pub(super) fn execute(args: &ReflowArgs, terminal: &Terminal) -> anyhow::Result<()> {
    let mut config = load_experiment(&args.config, &args.set)?;
    if let Some(device) = args.device {
        config.device = device.into();
    }
    let reflow = config.reflow.clone().unwrap_or_default();
    reflow.validate(&config.train)?;
    let same = |path: &PathBuf| std::fs::canonicalize(path).ok();
    if same(&args.out).is_some_and(|out| Some(out) == same(&args.checkpoint)) {
        let place = args.out.display();
        return Err(bad_input(format!(
            "{place}: is the flow to start from, expected another folder for the next"
        )));
    }
    // Before pairs are made, which takes its time.
    load_flow(&args.checkpoint, config.device)?
        .model()
        .validate_training(&reflow.training(&config.train, 1))?;
    let data = DatasetFile::read(&args.data)?;
    let validation = args.validation.as_deref().map(Dataset::read).transpose()?;
    OutputFolder::claim_around(&args.out)?;
    let file = args.pairs.clone().unwrap_or_else(|| beside(&args.out));
    OutputFile::claim(&file)?;

    let round =
        Round { config: &config, reflow: &reflow, number: 1, checkpoint: &args.checkpoint, data: &data };
    let found = round.find_pairs(&file)?;
    let pairs_found = found.is_some();
    let pairs = match found {
        Some(pairs) => {
            terminal.note(format!("pairs: {} holds them already", file.display()));
            pairs
        }
        None => round.make_pairs(&file, terminal).map_err(|fault| about_data(&args.data, None, fault))?,
    };
    let resume = if args.resume { Resume::Always } else { Resume::Never };
    let training = round
        .train(&pairs, validation.as_ref(), &args.out, resume, terminal)
        .map_err(|fault| about_data(&args.data, args.validation.as_deref(), fault))?;
    terminal.say(format!("checkpoint: {}\npairs: {}", args.out.display(), file.display()));
    terminal.machine(&ReflowReport {
        pairs: file.display().to_string(),
        pairs_found,
        windows: pairs.windows.len(),
        noises: pairs.windows.first().map_or(0, |of| of.pairs.len()),
        training,
    })
}

/// `DIR.pairs.npz` beside the folder `out`.
fn beside(out: &std::path::Path) -> PathBuf {
    let mut name = out.file_name().unwrap_or_default().to_owned();
    name.push(".pairs.npz");
    out.with_file_name(name)
}
