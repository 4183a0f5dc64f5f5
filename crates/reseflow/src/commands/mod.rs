//! One file a command: read what was given, check it, work, report.

mod generate;
mod inspect;
mod rollout;

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
        _ => anyhow::bail!("x"),
    }
}
