//! A whole evaluation: files in, report out.

use std::path::PathBuf;

use reseflow_data::{Dataset, DatasetFile, Episode, ObservationHistory, Split};

use super::{EvalReport, StraightnessRow, noise_seeds, score_steps, trivial_scores};
use crate::error::{bad_input, sentence};
use crate::learning::load_policy;
use crate::output::Terminal;
use crate::provenance::Provenance;
use crate::rollouts::FIRST_SEED;
use reseflow_train::{DeviceKind, FlowPolicy, Straightness};

/// Episodes that the straightness is measured on.
const STRAIGHT_EPISODES: usize = 20;
/// Euler steps that it is measured with.
const STRAIGHT_STEPS: usize = 50;

/// What is to be evaluated, on what.
#[derive(Debug, Clone)]
pub struct EvalInputs {
    /// The checkpoint's folder.
    pub checkpoint: PathBuf,
    /// The held-out episodes.
    pub data: PathBuf,
    /// The training episodes, for the trivial predictors.
    pub train_data: Option<PathBuf>,
    /// Numbers of integration steps.
    pub steps: Vec<usize>,
    /// Noise seeds, from 3407 on.
    pub seeds: usize,
    /// Where to compute.
    pub device: DeviceKind,
}

/// The inputs, read and checked.
pub struct Loaded {
    policy: FlowPolicy,
    held_out: DatasetFile,
    training: Option<Dataset>,
}

impl EvalInputs {
    /// Reads the files.
    ///
    /// # Errors
    /// What is wrong with one of them.
    pub fn load(&self) -> anyhow::Result<Loaded> {
        Ok(Loaded {
            held_out: DatasetFile::read(&self.data)?,
            training: self.train_data.as_deref().map(Dataset::read).transpose()?,
            policy: load_policy(&self.checkpoint, self.device)?,
        })
    }
}

/// Scores the policy for every number of steps, and the trivial predictors where there is training data.
///
/// # Errors
/// When the data does not fit the policy.
pub fn evaluate(inputs: &EvalInputs, loaded: &Loaded, terminal: &Terminal) -> anyhow::Result<EvalReport> {
    let Loaded { policy, held_out, training } = loaded;
    let meta = held_out.dataset.meta.as_ref();
    let split = meta.and_then(|meta| meta.split);
    if split == Some(Split::Train) {
        let data = inputs.data.display();
        terminal.note(format!("{data}: says that it holds training episodes, not held-out ones"));
    }
    let seeds = noise_seeds(inputs.seeds);
    let progress = terminal.progress("evaluation", inputs.steps.len() as u64);
    let mut rows = Vec::with_capacity(inputs.steps.len());
    for &steps in &inputs.steps {
        rows.push(score_steps(policy, &held_out.dataset, &seeds, steps)?);
        progress.advance();
    }
    progress.finish();
    let trivial =
        training.as_ref().map(|training| trivial_scores(training, &held_out.dataset)).transpose()?;
    let text = |path: &PathBuf| path.display().to_string();
    Ok(EvalReport {
        rows,
        straightness: Some(straightness(policy, &held_out.dataset)?),
        trivial,
        task: meta.map(|meta| meta.task.clone()),
        split,
        episodes: held_out.dataset.len(),
        seeds,
        checkpoint: text(&inputs.checkpoint),
        data: text(&inputs.data),
        data_hash: held_out.content_hash.clone(),
        train_data: inputs.train_data.as_ref().map(text),
        config: checkpoint_config(&inputs.checkpoint),
        provenance: Provenance::gather(&format!("{:?}", inputs.device).to_lowercase()),
    })
}

/// Measures the flow from the first windows of at most [`STRAIGHT_EPISODES`] episodes.
fn straightness(policy: &FlowPolicy, held_out: &Dataset) -> anyhow::Result<StraightnessRow> {
    let horizon = policy.observation_horizon();
    let first = |episode: &Episode| ObservationHistory::at_step(&episode.observations, 0, horizon);
    let histories: Vec<_> = held_out.episodes.iter().take(STRAIGHT_EPISODES).map(first).collect();
    let measured = policy
        .straightness(&histories, FIRST_SEED, STRAIGHT_STEPS)
        .map_err(|fault| bad_input(sentence(&anyhow::Error::new(fault))))?;
    let Straightness { absolute, relative } = measured;
    Ok(StraightnessRow { absolute, relative, steps: STRAIGHT_STEPS })
}

/// The resolved configuration that lies in the checkpoint; `null` where there is none.
fn checkpoint_config(checkpoint: &std::path::Path) -> serde_json::Value {
    let text = std::fs::read_to_string(checkpoint.join("config.toml")).unwrap_or_default();
    match toml::from_str::<toml::Table>(&text) {
        Ok(table) if !table.is_empty() => serde_json::to_value(table).unwrap_or_default(),
        _ => serde_json::Value::Null,
    }
}
