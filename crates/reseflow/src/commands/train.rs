//! `reseflow train`: a data set into a checkpoint.

use reseflow_data::Dataset;
use reseflow_train::Resume;

use crate::cli::TrainArgs;
use crate::config::load_experiment;
use crate::learning::train_policy;
use crate::output::{OutputFolder, Terminal};

/// Runs the command.
pub(super) fn execute(args: &TrainArgs, terminal: &Terminal) -> anyhow::Result<()> {
    let mut config = load_experiment(&args.config, &args.set)?;
    if let Some(device) = args.device {
        config.device = device.into();
    }
    let demonstrations = Dataset::read(&args.data)?;
    let validation = args.validation.as_deref().map(Dataset::read).transpose()?;
    OutputFolder::claim_around(&args.out)?;
    let resume = if args.resume { Resume::Always } else { Resume::Never };
    let summary = train_policy(&config, &demonstrations, validation.as_ref(), &args.out, resume, terminal)?;
    terminal.say(format!("checkpoint: {}", args.out.display()));
    terminal.machine(&summary)
}
