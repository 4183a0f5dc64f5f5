//! Where everything of a run lies.

use std::path::{Path, PathBuf};

use reseflow_train::WEIGHTS;

use super::RolloutSeries;
use crate::config::EvalSplit;
use crate::learners::Learner;

/// The paths inside a run's folder.
#[derive(Debug, Clone)]
pub struct Layout {
    root: PathBuf,
}

impl Layout {
    /// The layout of the run in `root`.
    pub fn new(root: PathBuf) -> Self {
        Self { root }
    }

    /// The run's folder.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// Every folder that files are written into.
    pub fn folders(&self) -> [PathBuf; 4] {
        [self.root.clone(), self.root.join("data"), self.pictures(), self.stamps()]
    }

    /// The file that a run locks.
    pub fn lock(&self) -> PathBuf {
        self.stamps().join("lock")
    }

    /// The resolved configuration.
    pub fn config(&self) -> PathBuf {
        self.root.join("config.toml")
    }

    /// The demonstrations of a split.
    pub fn data(&self, split: &str) -> PathBuf {
        self.root.join("data").join(format!("{split}.npz"))
    }

    /// The folder of a policy.
    pub fn checkpoint(&self, learner: Learner) -> PathBuf {
        self.root.join(learner.name("checkpoint"))
    }

    /// What the trainer noted, one JSON object a line.
    pub fn metrics(&self, learner: Learner) -> PathBuf {
        self.checkpoint(learner).join("metrics.jsonl")
    }

    /// The pairs that flow `flow`, from 2, learns from.
    pub fn pairs(&self, flow: usize) -> PathBuf {
        self.root.join("data").join(Learner::Flow(flow).name("pairs") + ".npz")
    }

    /// The name of a policy's evaluation on a split: its stage's, and its result's.
    pub fn eval_name(learner: Learner, split: EvalSplit) -> String {
        match split {
            EvalSplit::Test => learner.name("eval"),
            other => learner.name(&format!("eval-{}", other.name())),
        }
    }

    /// The result of a policy's evaluation.
    pub fn eval(&self, learner: Learner, split: EvalSplit) -> PathBuf {
        self.root.join(Self::eval_name(learner, split) + ".json")
    }

    /// What single plans take.
    pub fn latency(&self) -> PathBuf {
        self.root.join("latency.json")
    }

    /// The weights of a policy.
    pub fn weights(&self, learner: Learner) -> PathBuf {
        self.checkpoint(learner).join(WEIGHTS)
    }

    /// The comparison of solvers.
    pub fn samplers(&self) -> PathBuf {
        self.root.join("samplers.json")
    }

    /// The result of a series of rollouts.
    pub fn rollout(&self, series: &RolloutSeries) -> PathBuf {
        self.root.join(format!("{}.json", series.name))
    }

    /// The log of the first series.
    pub fn log(&self) -> PathBuf {
        self.root.join("rollout.mcap")
    }

    /// The curves of the trainings as a log.
    pub fn training_log(&self) -> PathBuf {
        self.root.join("training.mcap")
    }

    /// What the run amounts to.
    pub fn summary(&self) -> PathBuf {
        self.root.join("summary.json")
    }

    /// The folder of the pictures.
    pub fn pictures(&self) -> PathBuf {
        self.root.join("pictures")
    }

    /// A picture.
    pub fn picture(&self, name: &str) -> PathBuf {
        self.pictures().join(format!("{name}.png"))
    }

    /// What says which stages are finished.
    pub fn stamps(&self) -> PathBuf {
        self.root.join("stamps")
    }
}
