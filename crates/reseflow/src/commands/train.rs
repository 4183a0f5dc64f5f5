//! `reseflow train`: a data set into a checkpoint.

use reseflow_data::Dataset;
use reseflow_train::Resume;

use crate::cli::TrainArgs;
use crate::config::load_experiment;
use crate::error::about_data;
use crate::learners::{Learner, Training};
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
    let training = Training {
        config: &config,
        demonstrations: &demonstrations,
        validation: validation.as_ref(),
        out: &args.out,
        resume,
    };
    let learner = if args.baseline { Learner::Baseline } else { Learner::Flow(1) };
    let summary = training
        .run(learner, terminal)
        .map_err(|fault| about_data(&args.data, args.validation.as_deref(), fault))?;
    terminal.say(format!("checkpoint: {}", args.out.display()));
    terminal.machine(&summary)
}
