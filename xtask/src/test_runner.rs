//! `cargo xtask test`: every test, on the runner that is installed.
//!
//! cargo-nextest starts a process per test and closes with one summary line; it knows no doc-tests, which therefore run first.
//! Without it plain `cargo test` runs everything, and the sum that it does not print is added here.

use anyhow::Result;

use crate::process::{self, Failure, cargo, has_cargo_tool, run_reading_lines, say};

/// Run every test of the workspace: cargo-nextest and doc-tests where it is installed, else plain `cargo test`.
#[derive(Debug, Default, clap::Args)]
#[command(after_help = "Examples:\n  \
    cargo xtask test\n  \
    cargo xtask test -p reseflow-lie           one crate\n  \
    cargo xtask test geodesic                  tests with this in their name\n\n\
    Arguments narrow the run; doc-tests then run only where plain `cargo test` would run them.")]
pub(crate) struct Args {
    /// Use plain `cargo test` even where cargo-nextest is installed
    #[arg(long)]
    plain: bool,
    /// Handed on to the test runner
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    pub(crate) passed_on: Vec<String>,
}

/// Runs the tests; fails if any test fails or does not build.
pub(crate) fn run(args: &Args) -> Result<()> {
    if args.plain || !has_cargo_tool("nextest") {
        let mut tally = Tally::default();
        let mut command = cargo(["test"]);
        command.args(scope(&args.passed_on)).args(&args.passed_on);
        let outcome = run_reading_lines("cargo test", &mut command, |line| tally.read(line));
        say(&format!("cargo test: {tally}"));
        return outcome;
    }
    let doc_tests = if args.passed_on.is_empty() { run_doc_tests() } else { Ok(()) };
    let mut command = cargo(["nextest", "run"]);
    command.args(scope(&args.passed_on)).args(&args.passed_on);
    let tests = process::run("cargo nextest", &mut command);
    match (tests, doc_tests) {
        (Err(tests), Err(doc_tests)) => Err(Failure::new(format!("{tests}; {doc_tests}")).into()),
        (tests, doc_tests) => tests.and(doc_tests),
    }
}

fn run_doc_tests() -> Result<()> {
    let mut tally = Tally::default();
    let mut command = cargo(["test", "--doc", "--workspace", "--locked", "--no-fail-fast"]);
    let outcome = run_reading_lines("cargo test --doc", &mut command, |line| tally.read(line));
    say(&format!("doc-tests: {tally}"));
    outcome
}

/// What to add to the user's arguments: the whole workspace, unless they name a package.
fn scope(passed_on: &[String]) -> Vec<&'static str> {
    let names_package =
        passed_on.iter().any(|argument| argument.starts_with("-p") || argument.starts_with("--package"));
    match (passed_on.is_empty(), names_package) {
        (true, _) => vec!["--workspace", "--locked", "--no-fail-fast"],
        (false, false) => vec!["--workspace", "--locked"],
        (false, true) => vec!["--locked"],
    }
}

/// The sum over libtest's `test result:` lines.
#[derive(Debug, Default, PartialEq, Eq)]
struct Tally {
    binaries: u64,
    passed: u64,
    failed: u64,
    ignored: u64,
}

impl Tally {
    fn read(&mut self, line: &str) {
        let Some(result) = line.trim_start().strip_prefix("test result: ") else { return };
        let count = |noun: &str| -> u64 {
            result
                .split(['.', ';'])
                .filter_map(|part| part.trim().strip_suffix(noun))
                .find_map(|number| number.trim().parse().ok())
                .unwrap_or(0)
        };
        self.binaries += 1;
        self.passed += count("passed");
        self.failed += count("failed");
        self.ignored += count("ignored");
    }
}

impl std::fmt::Display for Tally {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { binaries, passed, failed, ignored } = self;
        write!(f, "{passed} passed; {failed} failed; {ignored} ignored; over {binaries} test binaries")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sum_counts_every_binary() {
        let mut tally = Tally::default();
        for line in [
            "running 3 tests",
            "test a ... ok",
            "test result: ok. 3 passed; 0 failed; 1 ignored; 0 measured; 0 filtered out; finished in 0.01s",
            "test result: FAILED. 10 passed; 2 failed; 0 ignored; 0 measured; 5 filtered out; finished in 1.20s",
        ] {
            tally.read(line);
        }
        assert_eq!(tally, Tally { binaries: 2, passed: 13, failed: 2, ignored: 1 });
    }

    #[test]
    fn a_named_package_replaces_the_workspace() {
        let words = |text: &str| text.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
        assert!(scope(&words("")).contains(&"--workspace"));
        assert!(scope(&words("geodesic")).contains(&"--workspace"));
        assert!(!scope(&words("-p reseflow-lie")).contains(&"--workspace"));
        assert!(!scope(&words("--package=reseflow-lie")).contains(&"--workspace"));
    }
}
