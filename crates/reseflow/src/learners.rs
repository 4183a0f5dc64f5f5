//! What an experiment trains: its flows, and the references beside them.

use std::path::Path;

use reseflow_data::Dataset;
use reseflow_train::{ModelConfig, Resume, TrainRequest, TrainSummary, Trainable};

use crate::config::ExperimentConfig;
use crate::learning::train_with_progress;
use crate::output::Terminal;

/// One of the policies of an experiment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Learner {
    /// Flow 1, 2, …
    Flow(usize),
    /// The baseline, ET-SEED's diffusion.
    Baseline,
    /// The deterministic regressor.
    Regressor,
}

impl Learner {
    /// The name of what belongs to it: Flow 1's is `name` itself.
    pub fn name(self, name: &str) -> String {
        match self {
            Self::Flow(1) => name.to_owned(),
            Self::Flow(flow) => format!("{name}-{flow}"),
            Self::Baseline => format!("{name}-baseline"),
            Self::Regressor => format!("{name}-regressor"),
        }
    }

    /// The folder of its policy among those that ship for a task.
    pub fn shipped_name(self) -> String {
        match self {
            Self::Flow(flow) => format!("flow{flow}"),
            Self::Baseline => "etseed".to_owned(),
            Self::Regressor => "regressor".to_owned(),
        }
    }

    /// Everything that `config` trains: its flows, then the references.
    pub fn all(config: &ExperimentConfig) -> impl Iterator<Item = Self> {
        (1..=config.flows()).map(Self::Flow).chain(Self::references(config))
    }

    /// The references that `config` asks for.
    pub fn references(config: &ExperimentConfig) -> impl Iterator<Item = Self> {
        let baseline = config.baseline.is_some().then_some(Self::Baseline);
        baseline.into_iter().chain(config.regressor.then_some(Self::Regressor))
    }
}

/// A training from drawn weights: everything but the rounds of reflow.
#[derive(Debug, Clone, Copy)]
pub struct Training<'a> {
    /// Whose model and training count.
    pub config: &'a ExperimentConfig,
    /// The episodes to learn from.
    pub demonstrations: &'a Dataset,
    /// Held-out episodes, scored during training.
    pub validation: Option<&'a Dataset>,
    /// The checkpoint's folder.
    pub out: &'a Path,
    /// What becomes of the state that an interrupted training left.
    pub resume: Resume,
}

impl Training<'_> {
    /// Trains Flow 1 or one of the references, with the progress on the terminal.
    ///
    /// # Errors
    /// What the trainer reports.
    pub fn run(&self, learner: Learner, terminal: &Terminal) -> anyhow::Result<TrainSummary> {
        let ExperimentConfig { model, train, .. } = self.config;
        let label = learner.name("training");
        match learner {
            Learner::Flow(_) => self.train(model, train, &label, terminal),
            Learner::Baseline => {
                let baseline = self.config.baseline.clone().unwrap_or_default();
                baseline.validate(model, train)?;
                self.train(&baseline.model(model), &baseline.training(train), &label, terminal)
            }
            Learner::Regressor => self.train(&regressor(model), train, &label, terminal),
        }
    }

    fn train<M: Trainable>(
        &self,
        model: &M,
        train: &reseflow_train::TrainConfig,
        label: &str,
        terminal: &Terminal,
    ) -> anyhow::Result<TrainSummary> {
        let request = TrainRequest {
            model,
            train,
            demonstrations: self.demonstrations,
            mixture: None,
            validation: self.validation,
            start: None,
            resume: self.resume,
            device: self.config.device,
            out: self.out,
        };
        train_with_progress(&request, label, terminal)
    }
}

/// The regressor with a flow's network.
pub fn regressor(model: &ModelConfig) -> ModelConfig {
    ModelConfig { regression: true, ..model.clone() }
}
