//! Stamps: a finished stage leaves a hash of everything that it depended on, and is skipped while that stays the same.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Context;
use serde::{Deserialize, Serialize};

use crate::output::{Terminal, write_json};
use crate::provenance::{content_hash, program_hash};

/// The folder of the stamps.
#[derive(Debug, Clone)]
pub struct Stamps {
    folder: PathBuf,
    fresh: bool,
}

/// How a stage went, this time or when it was last done.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StageRun {
    /// The stage.
    pub name: String,
    /// The hash of what it depended on.
    pub inputs: String,
    /// The seconds that it took.
    pub secs: f64,
    /// Whether that was an earlier run.
    pub skipped: bool,
}

#[derive(Debug, Serialize, Deserialize)]
struct Stamp {
    inputs: String,
    /// Content hashes of what the stage left, in the order of its outputs.
    outputs: Vec<String>,
    secs: f64,
}

impl Stamps {
    /// The stamps in `folder`; `fresh` disregards those that are there.
    pub fn new(folder: PathBuf, fresh: bool) -> Self {
        Self { folder, fresh }
    }

    /// Does `work` unless this program did it with the same `inputs` before and its `outputs` are still what they were.
    ///
    /// The stamp is taken away before the work and set after it, so that an interruption means "not done".
    ///
    /// # Errors
    /// What `work` reports, or that the stamp cannot be written.
    pub fn stage(
        &self,
        name: &str,
        inputs: &impl Serialize,
        outputs: &[PathBuf],
        terminal: &Terminal,
        work: impl FnOnce() -> anyhow::Result<()>,
    ) -> anyhow::Result<StageRun> {
        let inputs = hash(name, inputs)?;
        let path = self.folder.join(format!("{name}.json"));
        if let Some(stamp) = read(&path)
            && !self.fresh
            && stamp.inputs == inputs
            && contents(outputs).is_some_and(|outputs| outputs == stamp.outputs)
        {
            terminal.note(format!("{name}: done before, nothing has changed"));
            return Ok(StageRun { name: name.to_owned(), inputs, secs: stamp.secs, skipped: true });
        }
        if path.exists() {
            std::fs::remove_file(&path).with_context(|| format!("{}: cannot be removed", path.display()))?;
        }
        tracing::info!(stage = name, "begins");
        let started = Instant::now();
        work()?;
        let secs = started.elapsed().as_secs_f64();
        tracing::info!(stage = name, secs, "done");
        let outputs = contents(outputs)
            .with_context(|| format!("the stage `{name}` did not leave what it should have left"))?;
        write_json(&path, &Stamp { inputs: inputs.clone(), outputs, secs })?;
        Ok(StageRun { name: name.to_owned(), inputs, secs, skipped: false })
    }
}

impl Stamps {
    /// Takes `outputs` as they are now for what the stage `name` left; nothing where it has not been done.
    ///
    /// # Errors
    /// When the stamp cannot be written, or an output is not there.
    pub(super) fn renew(&self, name: &str, outputs: &[PathBuf]) -> anyhow::Result<()> {
        let path = self.folder.join(format!("{name}.json"));
        let Some(mut stamp) = read(&path) else { return Ok(()) };
        stamp.outputs = contents(outputs).with_context(|| format!("what the stage `{name}` left is gone"))?;
        write_json(&path, &stamp)
    }
}

/// A stamp that cannot be read is none.
fn read(path: &Path) -> Option<Stamp> {
    serde_json::from_slice(&std::fs::read(path).ok()?).ok()
}

fn hash(name: &str, inputs: &impl Serialize) -> anyhow::Result<String> {
    let text = serde_json::to_string(&(name, program_hash(), inputs)).context("hashing a stage's inputs")?;
    Ok(blake3::hash(text.as_bytes()).to_hex().to_string())
}

/// The content hash of each of `outputs`, or nothing where one is missing.
fn contents(outputs: &[PathBuf]) -> Option<Vec<String>> {
    outputs.iter().map(|output| content_hash(output).ok()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    #[test]
    fn a_stage_is_redone_exactly_when_something_changed() {
        let folder = tempfile::tempdir().unwrap();
        let output = folder.path().join("result");
        let terminal = Terminal::new(true);
        let done = Cell::new(0);
        let attempt = |fresh: bool, inputs: u32, fails: bool| {
            let stamps = Stamps::new(folder.path().join("stamps"), fresh);
            stamps.stage("work", &inputs, std::slice::from_ref(&output), &terminal, || {
                done.set(done.get() + 1);
                anyhow::ensure!(!fails, "interrupted");
                Ok(std::fs::write(&output, "x")?)
            })
        };
        assert!(!attempt(false, 1, false).unwrap().skipped);
        assert!(attempt(false, 1, false).unwrap().skipped, "nothing has changed");
        assert!(!attempt(false, 2, false).unwrap().skipped, "the inputs changed");
        assert!(!attempt(true, 2, false).unwrap().skipped, "everything was asked for");
        std::fs::write(&output, "y").unwrap();
        assert!(!attempt(false, 2, false).unwrap().skipped, "the output is another");
        std::fs::remove_file(&output).unwrap();
        assert!(!attempt(false, 2, false).unwrap().skipped, "the output is gone");
        assert!(attempt(false, 3, true).is_err());
        assert!(!attempt(false, 2, false).unwrap().skipped, "an interrupted stage is not done");
        assert_eq!(done.get(), 7);
    }
}
