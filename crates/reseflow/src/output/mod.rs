//! The only place that prints: results on standard output, progress on standard error.

mod files;
mod progress;
mod table;

pub use files::{OutputFile, OutputFolder, write_json};
pub use progress::Progress;
pub use table::Table;

use std::io::{IsTerminal, Write};

use anyhow::Context;
use serde::Serialize;

/// Where a command's words go.
#[derive(Debug, Clone, Copy)]
pub struct Terminal {
    json: bool,
    interactive: bool,
}

impl Terminal {
    /// A terminal that prints JSON (`json`) or text, with moving progress bars where standard error is a terminal.
    pub fn new(json: bool) -> Self {
        Self { json, interactive: std::io::stderr().is_terminal() }
    }

    /// Whether results are printed for machines.
    pub fn is_json(&self) -> bool {
        self.json
    }

    /// Prints a line of a result; silent where JSON was asked for.
    pub fn say(&self, line: impl std::fmt::Display) {
        if !self.json {
            print_line(&line.to_string());
        }
    }

    /// Prints a remark on what is being done, on standard error.
    #[expect(clippy::print_stderr, reason = "this is the output module")]
    pub fn note(&self, line: impl std::fmt::Display) {
        eprintln!("{line}");
    }

    /// Prints `result` as JSON on standard output; silent where text was asked for.
    ///
    /// # Errors
    /// When the result cannot be serialised.
    pub fn machine(&self, result: &impl Serialize) -> anyhow::Result<()> {
        if self.json {
            print_line(&serde_json::to_string_pretty(result).context("serialising the result")?);
        }
        Ok(())
    }

    /// A progress display for `total` things.
    pub fn progress(&self, label: &str, total: u64) -> Progress {
        Progress::start(label, total, self.interactive)
    }
}

/// Sends log lines to standard error: warnings, with `verbose` more; `RESEFLOW_LOG` overrides it (as in `RESEFLOW_LOG=debug`).
pub fn start_log(verbose: u8) {
    let level = ["warn", "info", "debug", "trace"][usize::from(verbose.min(3))];
    let filter = tracing_subscriber::EnvFilter::try_from_env("RESEFLOW_LOG")
        .unwrap_or_else(|_| tracing_subscriber::EnvFilter::new(level));
    let colors = std::io::stderr().is_terminal();
    tracing_subscriber::fmt().with_env_filter(filter).with_ansi(colors).with_writer(std::io::stderr).init();
}

/// Prints the one sentence that a failed command ends with.
#[expect(clippy::print_stderr, reason = "this is the output module")]
pub fn print_error(sentence: &str) {
    eprintln!("error: {sentence}");
}

/// Prints help or the version.
pub fn print_help(text: &str) {
    print_line(text.trim_end());
}

/// Prints a line on standard output. A reader that has gone away, as `head` does, ends the program quietly: what it was asked to
/// write is written by then.
fn print_line(line: &str) {
    match writeln!(std::io::stdout(), "{line}") {
        Ok(()) => {}
        Err(fault) if fault.kind() == std::io::ErrorKind::BrokenPipe => std::process::exit(0),
        Err(fault) => {
            print_error(&format!("standard output: {fault}"));
            std::process::exit(1);
        }
    }
}
