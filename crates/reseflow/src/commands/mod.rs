//! One file a command: read what was given, check it, work, report.

mod bench;
mod equiv;
mod eval;
mod generate;
mod inspect;
mod planner;
mod predict;
mod reflow;
mod report;
mod rollout;
mod run;
mod train;

use crate::cli::{Cli, Command};
use crate::output::Terminal;

/// Does what the command line asks for.
///
/// # Errors
/// What is wrong with the input, or what failed; see [`crate::error::exit_code`].
pub fn execute(cli: Cli) -> anyhow::Result<()> {
    let terminal = Terminal::new(cli.json);
    match cli.command {
        Command::Gen(args) => generate::execute(&args, &terminal),
        Command::Inspect(args) => inspect::execute(&args, &terminal),
        Command::Rollout(args) => rollout::execute(&args, &terminal),
        Command::Train(args) => train::execute(&args, &terminal),
        Command::Reflow(args) => reflow::execute(&args, &terminal),
        Command::Predict(args) => predict::execute(&args, &terminal),
        Command::Eval(args) => eval::execute(&args, &terminal),
        Command::Run(args) => run::execute(&args, &terminal),
        Command::Equiv(args) => equiv::execute(&args, &terminal),
        Command::Bench(args) => bench::execute(&args, &terminal),
        Command::Report(args) => report::execute(&args, &terminal),
    }
}
