//! What `bench` and `equiv` start with: a policy, episodes to plan from, and perhaps a place for the result.

use std::path::{Path, PathBuf};

use reseflow_data::DatasetFile;
use reseflow_train::DeviceKind;

use crate::error::bad_input;
use crate::evaluation::note_task;
use crate::learning::{LearnedPolicy, find_policy};
use crate::output::{OutputFile, Terminal};

/// A policy and the episodes that it plans from.
pub(super) struct Planner {
    /// The checkpoint's folder.
    pub(super) folder: PathBuf,
    pub(super) policy: LearnedPolicy,
    /// At least one episode.
    pub(super) data: DatasetFile,
    pub(super) out: Option<OutputFile>,
}

impl Planner {
    /// Reads both, and makes sure that the result can be written.
    ///
    /// # Errors
    /// Bad input: what is wrong with one of them.
    pub(super) fn load(
        checkpoint: &Path,
        data: &Path,
        out: Option<&Path>,
        device: DeviceKind,
        terminal: &Terminal,
    ) -> anyhow::Result<Self> {
        let folder = find_policy(checkpoint)?;
        let policy = LearnedPolicy::load(&folder, device)?;
        let read = DatasetFile::read(data)?;
        if read.dataset.is_empty() {
            return Err(bad_input(format!("{}: holds no episode, expected at least one", data.display())));
        }
        note_task(&folder, data, &read.dataset, terminal)?;
        let out = out.map(|out| OutputFile::claim_apart(out, &[data, &folder])).transpose()?;
        Ok(Self { folder, policy, data: read, out })
    }
}
