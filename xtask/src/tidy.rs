//! `cargo xtask tidy`: the rules of this code base that neither rustfmt nor clippy knows.
//!
//! Each rule is a function from text or metadata to complaints, so that its tests can show it failing.

mod documents;
mod floors;
mod restricted;
mod source;
mod text;
mod tree;

use std::fmt;
use std::path::PathBuf;

use anyhow::Result;

use crate::process::{Failure, complain, say};
use crate::workspace::{self, Metadata};

/// Check the shape of the code: dependency floors, file length, headers, unfinished work, paths.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  cargo xtask tidy\n\n\
    The rules: dependencies run down the floors of ARCHITECTURE.md; burn, rapier3d, parry3d, glamx, \
    mcap, foxglove, npyz, clap, plotters and anyhow appear only in the crates that own them, in tests and in xtask; a Rust file \
    opens with `//!` and has at most 400 lines (tables named *_table.rs or generated* excepted); nothing is marked \
    unfinished; no text names a folder of one machine; what the documents point at exists.")]
pub(crate) struct Args {}

/// One broken rule.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Complaint {
    /// Where: a path relative to the workspace, or a crate's name.
    place: String,
    /// The line, where there is one.
    line: Option<usize>,
    /// What is wrong and what is expected.
    fault: String,
}

impl Complaint {
    fn new(place: impl Into<String>, fault: impl Into<String>) -> Self {
        Self { place: place.into(), line: None, fault: fault.into() }
    }

    fn at(place: impl Into<String>, line: usize, fault: impl Into<String>) -> Self {
        Self { place: place.into(), line: Some(line), fault: fault.into() }
    }
}

impl fmt::Display for Complaint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "{}:{line}: {}", self.place, self.fault),
            None => write!(f, "{}: {}", self.place, self.fault),
        }
    }
}

/// Checks every rule and lists every complaint.
pub(crate) fn run(_: &Args) -> Result<()> {
    let root = workspace::root();
    let metadata = Metadata::load()?;
    let files = tree::read(&root)?;

    let mut complaints = floors::check(&metadata);
    complaints.extend(restricted::check(&metadata));
    let homes = [Some(root.clone()), std::env::var_os("HOME").map(PathBuf::from)];
    let homes: Vec<PathBuf> = homes.into_iter().flatten().collect();
    for file in &files {
        complaints.extend(source::check(file));
        complaints.extend(text::check(file, &homes));
        complaints.extend(documents::check(file, |path| root.join(path).exists()));
    }
    complaints.sort();
    for complaint in &complaints {
        complain(&complaint.to_string());
    }
    if complaints.is_empty() {
        say(&format!("tidy: {} files and {} crates are in order", files.len(), metadata.packages.len()));
        return Ok(());
    }
    Err(Failure::new(format!("tidy: {} complaints", complaints.len())).into())
}
