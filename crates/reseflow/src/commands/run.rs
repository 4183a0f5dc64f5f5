//! `reseflow run`: everything that a configuration says.

use crate::cli::RunArgs;
use crate::config::load_experiment;
use crate::error::bad_input;
use crate::output::Terminal;
use crate::pipeline;

/// Runs the command.
pub(super) fn execute(args: &RunArgs, terminal: &Terminal) -> anyhow::Result<()> {
    let mut config = load_experiment(&args.config, &args.set)?;
    config.validate_run().map_err(|fault| bad_input(format!("{}: {fault}", args.config.display())))?;
    if let Some(device) = args.device {
        config.device = device.into();
    }
    let summary = pipeline::run(&config, args.fresh, terminal)?;
    terminal.say(summary.table());
    terminal.machine(&summary)
}
