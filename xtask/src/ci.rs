//! `cargo xtask ci`: everything that continuous integration runs, cheapest first.

use std::process::Command;

use anyhow::Result;

use crate::process::{self, cargo, has_cargo_tool, say};
use crate::{test_runner, tidy};

/// Run every check and every test, cheapest first.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    cargo xtask ci                 what to run before a push\n  \
    cargo xtask ci --no-test       formatting, tidiness, lints, documentation, licences")]
pub(crate) struct Args {
    /// Stop before the tests
    #[arg(long)]
    no_test: bool,
}

/// Runs the checks in order and stops at the first that fails.
pub(crate) fn run(args: &Args) -> Result<()> {
    say("ci: formatting");
    process::run("cargo fmt", &mut cargo(["fmt", "--all", "--check"]))?;
    say("ci: tidiness");
    tidy::run(&tidy::Args {})?;
    say("ci: dependencies' licences, bans and sources");
    if has_cargo_tool("deny") {
        process::run("cargo deny", &mut cargo(["deny", "check", "bans", "licenses", "sources"]))?;
    } else {
        say("ci: skipped, because cargo-deny is not installed (`cargo install --locked cargo-deny`)");
    }
    say("ci: lints");
    process::run("cargo clippy", &mut clippy())?;
    // After clippy: both need the same metadata of every dependency.
    say("ci: documentation");
    process::run("cargo doc", &mut documentation())?;
    if args.no_test {
        return Ok(());
    }
    say("ci: tests");
    test_runner::run(&test_runner::Args::default())
}

fn clippy() -> Command {
    cargo(["clippy", "--workspace", "--all-targets", "--locked", "--", "-D", "warnings"])
}

fn documentation() -> Command {
    let mut command = cargo(["doc", "--workspace", "--no-deps", "--locked"]);
    command.env("RUSTDOCFLAGS", "-D warnings");
    command
}
