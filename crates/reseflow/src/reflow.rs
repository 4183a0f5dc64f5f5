//! Flow 2 out of Flow 1: pairs in a file that says where they come from, and the training that learns from them.

use std::path::Path;

use anyhow::Context;
use reseflow_data::{Dataset, DatasetFile, PairMeta, PairSet};
use reseflow_train::{
    Mixture, PairConfig, ReflowConfig, Resume, TrainRequest, TrainSummary, WEIGHTS, count_pair_windows,
    make_pairs,
};
use serde::Serialize;

use crate::config::ExperimentConfig;
use crate::error::bad_input;
use crate::learning::{load_flow, train_with_progress};
use crate::output::Terminal;

/// One round: the flow that it starts from, and the demonstrations.
#[derive(Debug, Clone, Copy)]
pub struct Round<'a> {
    /// Whose `train` table and device count.
    pub config: &'a ExperimentConfig,
    /// How the next flow is made.
    pub reflow: &'a ReflowConfig,
    /// The round, from 1.
    pub number: usize,
    /// The folder of the flow that it starts from.
    pub checkpoint: &'a Path,
    /// The demonstrations that that flow has learned from.
    pub data: &'a DatasetFile,
}

impl Round<'_> {
    /// Makes the pairs, writes them to `file` and reads them back.
    ///
    /// # Errors
    /// Bad input: a checkpoint that cannot be used, or observations that do not fit it.
    pub fn make_pairs(&self, file: &Path, terminal: &Terminal) -> anyhow::Result<PairSet> {
        let policy = load_flow(self.checkpoint, self.config.device)?;
        let config = self.pair_config();
        let demonstrations = &self.data.dataset;
        let progress = terminal.progress("pairs", count_pair_windows(demonstrations, &config) as u64);
        let advance = |windows: usize| (0..windows).for_each(|_| progress.advance());
        let windows = make_pairs(&policy, demonstrations, &config, &advance)?;
        progress.finish();
        PairSet { windows, meta: self.meta()? }.write(file)?;
        // As the file holds them, in f32: those who find it later train on the same numbers.
        Ok(PairSet::read(file)?)
    }

    /// The pairs in `file` if they are those that [`Round::make_pairs`] would make.
    ///
    /// # Errors
    /// Bad input: the file is there and is no pair file, so it is not replaced; or the checkpoint cannot be read.
    pub fn find_pairs(&self, file: &Path) -> anyhow::Result<Option<PairSet>> {
        if !file.exists() {
            return Ok(None);
        }
        let pairs = PairSet::read(file)?;
        Ok((pairs.meta == self.meta()?).then_some(pairs))
    }

    /// Trains the next flow from this one's averaged weights into the folder `out`.
    ///
    /// # Errors
    /// What the trainer reports.
    pub fn train(
        &self,
        pairs: &PairSet,
        validation: Option<&Dataset>,
        out: &Path,
        resume: Resume,
        terminal: &Terminal,
    ) -> anyhow::Result<TrainSummary> {
        let model = load_flow(self.checkpoint, self.config.device)?.model().clone();
        let demonstrations = &self.data.dataset;
        let horizon = model.network.decoder.horizon;
        let mixture = Mixture::new(self.reflow.mixture, &pairs.windows, demonstrations, horizon)?;
        let request = TrainRequest {
            model: &model,
            train: &self.reflow.training(&self.config.train, self.number),
            demonstrations,
            mixture: Some(&mixture),
            validation,
            start: Some(self.checkpoint),
            resume,
            device: self.config.device,
            out,
        };
        train_with_progress(&request, &format!("reflow {}", self.number), terminal)
    }

    fn pair_config(&self) -> PairConfig {
        self.reflow.pairs_of(self.number)
    }

    fn meta(&self) -> anyhow::Result<PairMeta> {
        Ok(PairMeta {
            checkpoint_hash: checkpoint_hash(self.checkpoint)?,
            data_hash: self.data.content_hash.clone(),
            settings: serde_json::to_value(self.pair_config())?,
        })
    }
}

/// What `reseflow reflow` reports.
#[derive(Debug, Serialize)]
pub struct ReflowReport {
    /// The pair file.
    pub pairs: String,
    /// Whether it was there already.
    pub pairs_found: bool,
    /// Windows with pairs.
    pub windows: usize,
    /// Pairs of each.
    pub noises: usize,
    /// The training.
    #[serde(flatten)]
    pub training: TrainSummary,
}

/// blake3 over a checkpoint's configuration and weights, in hexadecimal.
fn checkpoint_hash(folder: &Path) -> anyhow::Result<String> {
    if !folder.is_dir() {
        let place = folder.display();
        return Err(bad_input(format!("{place}: there is no such folder, expected a checkpoint's")));
    }
    let mut hasher = blake3::Hasher::new_derive_key("reseflow checkpoint v1");
    for name in ["config.toml", WEIGHTS] {
        let path = folder.join(name);
        let bytes = std::fs::read(&path).with_context(|| path.display().to_string())?;
        hasher.update(&(bytes.len() as u64).to_le_bytes());
        hasher.update(&bytes);
    }
    Ok(hasher.finalize().to_hex().to_string())
}
