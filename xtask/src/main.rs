//! The developer's pipelines, run as `cargo xtask <command>` from anywhere in the workspace.
//!
//! Each command is one file beside this one. They only order and explain what `cargo` and the `reseflow` binary do; nothing
//! here is needed to use the crates.

mod bench;
mod ci;
mod demo;
mod jobs;
mod pretrain;
mod process;
mod reproduce;
mod test_runner;
mod tidy;
mod workspace;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::process::{Failure, complain};

/// The developer's pipelines of this workspace.
#[derive(Debug, Parser)]
#[command(
    name = "cargo xtask",
    bin_name = "cargo xtask",
    after_help = "Start with:\n  cargo xtask demo    simulate, train, evaluate and roll out one small policy\n  \
                  cargo xtask test    run every test"
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Demo(demo::Args),
    Test(test_runner::Args),
    Ci(ci::Args),
    Tidy(tidy::Args),
    Bench(bench::Args),
    Reproduce(reproduce::Args),
    Pretrain(pretrain::Args),
}

fn main() -> ExitCode {
    let result = match Cli::parse().command {
        Command::Demo(args) => demo::run(&args),
        Command::Test(args) => test_runner::run(&args),
        Command::Ci(args) => ci::run(&args),
        Command::Tidy(args) => tidy::run(&args),
        Command::Bench(args) => bench::run(&args),
        Command::Reproduce(args) => reproduce::run(&args),
        Command::Pretrain(args) => pretrain::run(&args),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            complain(&format!("{error:#}"));
            error.downcast_ref::<Failure>().map_or(ExitCode::FAILURE, Failure::exit_code)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_well_formed_and_every_command_has_an_example() {
        let mut cli = Cli::command();
        cli.build();
        cli.clone().debug_assert();
        for command in cli.get_subcommands().filter(|command| command.get_name() != "help") {
            let help = command.clone().render_long_help().to_string();
            assert!(help.contains("Examples:"), "`{}` shows no example", command.get_name());
        }
    }

    #[test]
    fn what_follows_a_pipeline_is_handed_on_untouched() {
        let Command::Demo(demo) = Cli::parse_from(["xtask", "demo", "--set", "train.steps=5"]).command else {
            panic!("not a demo")
        };
        assert_eq!(demo.passed_on, ["--set", "train.steps=5"]);
        let Command::Test(test) = Cli::parse_from(["xtask", "test", "-p", "reseflow-lie", "se3"]).command
        else {
            panic!("not a test")
        };
        assert_eq!(test.passed_on, ["-p", "reseflow-lie", "se3"]);
    }
}
