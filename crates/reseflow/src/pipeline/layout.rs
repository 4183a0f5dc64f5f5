//! Where everything of a run lies.

use std::path::{Path, PathBuf};

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

    /// The result of a policy's evaluation.
    pub fn eval(&self, learner: Learner) -> PathBuf {
        self.root.join(learner.name("eval") + ".json")
    }

    /// The rollouts' result.
    pub fn rollout(&self) -> PathBuf {
        self.root.join("rollout.json")
    }

    /// The rollouts' log.
    pub fn log(&self) -> PathBuf {
        self.root.join("rollout.mcap")
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
