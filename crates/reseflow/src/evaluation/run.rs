//! A whole evaluation: files in, report out.

use std::path::{Path, PathBuf};

use reseflow_data::{Dataset, DatasetFile, Episode, ObservationHistory, Split};

use super::{
    EvalReport, SamplePolicy, StepsDifference, StraightnessRow, noise_seeds, score_steps, trivial_scores,
};
use crate::config::SolverChoice;
use crate::error::{about_data, bad_input};
use crate::learning::{LearnedPolicy, learned_task};
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
    /// How many of them, from the first; `None` for all.
    pub episodes: Option<usize>,
    /// The training episodes, for the trivial predictors.
    pub train_data: Option<PathBuf>,
    /// Numbers of integration steps; none stand for the usual ones of the policy's kind.
    pub steps: Vec<usize>,
    /// How flows are integrated.
    pub solver: SolverChoice,
    /// What D̄_geo is where there is one mode only.
    pub unimodal_d_geo: f64,
    /// Noise seeds, from 3407 on.
    pub seeds: usize,
    /// Where to compute.
    pub device: DeviceKind,
}

/// The inputs, read and checked.
pub struct Loaded {
    policy: LearnedPolicy,
    held_out: DatasetFile,
    training: Option<Dataset>,
}

impl Loaded {
    /// What is drawn from.
    pub(super) fn sampler(&self) -> &dyn SamplePolicy {
        self.policy.sampler()
    }

    /// The held-out episodes.
    pub(super) fn held_out(&self) -> &DatasetFile {
        &self.held_out
    }
}

impl EvalInputs {
    /// Reads the files.
    ///
    /// # Errors
    /// What is wrong with one of them.
    pub fn load(&self) -> anyhow::Result<Loaded> {
        let mut held_out = DatasetFile::read(&self.data)?;
        held_out.dataset.episodes.truncate(self.episodes.unwrap_or(usize::MAX));
        let mut episodes = held_out.dataset.episodes.iter();
        if let Some(index) = episodes.position(|episode| episode.disturbance.is_some()) {
            let data = self.data.display();
            return Err(bad_input(format!(
                "{data}: episode {index} was disturbed while it was recorded, expected held-out episodes that were not"
            )));
        }
        Ok(Loaded {
            held_out,
            training: self.train_data.as_deref().map(Dataset::read).transpose()?,
            policy: LearnedPolicy::load(&self.checkpoint, self.device)?,
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
    note_task(&inputs.checkpoint, &inputs.data, &held_out.dataset, terminal)?;
    let seeds = noise_seeds(inputs.seeds);
    let steps = if inputs.steps.is_empty() { policy.usual_steps() } else { inputs.steps.clone() };
    let solvers = inputs.solver.with_each(&steps);
    let progress = terminal.progress("evaluation", solvers.len() as u64);
    let mut rows = Vec::with_capacity(solvers.len());
    let about = |fault| about_data(&inputs.data, None, fault);
    for solver in &solvers {
        let row = score_steps(policy.sampler(), &held_out.dataset, &seeds, solver, inputs.unimodal_d_geo)
            .map_err(about)?;
        tracing::info!(
            solver = row.solver,
            steps = row.steps,
            evaluations = row.evaluations,
            d_geo = row.scores.d_geo_mean,
            secs = row.secs,
            "scored"
        );
        rows.push(row);
        progress.advance();
    }
    progress.finish();
    let trivial = match training {
        Some(training) => trivial_scores(training, &held_out.dataset)?,
        None => None,
    };
    if let (Some(data), None) = (&inputs.train_data, &trivial) {
        let data = data.display();
        terminal.note(format!("{data}: every episode was disturbed, so there are no trivial predictors"));
    }
    let text = |path: &PathBuf| path.display().to_string();
    Ok(EvalReport {
        against_most_steps: StepsDifference::of(&rows),
        rows,
        turned: None,
        straightness: policy
            .flow()
            .map(|flow| straightness(flow, &held_out.dataset))
            .transpose()
            .map_err(about)?,
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
        provenance: Provenance::gather(inputs.device.name()),
    })
}

/// Measures the flow from the first windows of at most [`STRAIGHT_EPISODES`] episodes.
fn straightness(policy: &FlowPolicy, held_out: &Dataset) -> anyhow::Result<StraightnessRow> {
    let horizon = policy.observation_horizon();
    let first = |episode: &Episode| ObservationHistory::at_step(&episode.observations, 0, horizon);
    let histories: Vec<_> = held_out.episodes.iter().take(STRAIGHT_EPISODES).map(first).collect();
    let Straightness { absolute, relative } = policy.straightness(&histories, FIRST_SEED, STRAIGHT_STEPS)?;
    Ok(StraightnessRow { absolute, relative, steps: STRAIGHT_STEPS })
}

/// Says so where the policy has learned another task than the one that the data is of.
///
/// # Errors
/// When the checkpoint cannot be read.
pub fn note_task(
    checkpoint: &Path,
    data: &Path,
    dataset: &Dataset,
    terminal: &Terminal,
) -> anyhow::Result<()> {
    let shown = dataset.meta.as_ref().map(|meta| meta.task.clone());
    if let (Some(learned), Some(shown)) = (learned_task(checkpoint)?, shown)
        && learned != shown
    {
        let (checkpoint, data) = (checkpoint.display(), data.display());
        terminal.note(format!(
            "warning: {checkpoint}: has learned the task `{learned}`, and {data} is of the task `{shown}`"
        ));
    }
    Ok(())
}

/// The whole configuration that lies in the checkpoint: task, model, training; `null` where there is none.
pub fn checkpoint_config(checkpoint: &Path) -> serde_json::Value {
    let text = std::fs::read_to_string(checkpoint.join("config.toml")).unwrap_or_default();
    match toml::from_str::<toml::Table>(&text) {
        Ok(table) if !table.is_empty() => serde_json::to_value(table).unwrap_or_default(),
        _ => serde_json::Value::Null,
    }
}
