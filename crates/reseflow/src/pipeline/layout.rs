//! Where everything of a run lies.

use std::path::{Path, PathBuf};

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

    /// The resolved configuration.
    pub fn config(&self) -> PathBuf {
        self.root.join("config.toml")
    }

    /// The demonstrations of a split.
    pub fn data(&self, split: &str) -> PathBuf {
        self.root.join("data").join(format!("{split}.npz"))
    }

    /// The trained policy's folder.
    pub fn checkpoint(&self) -> PathBuf {
        self.root.join("checkpoint")
    }

    /// What the trainer noted, one JSON object a line.
    pub fn metrics(&self) -> PathBuf {
        self.checkpoint().join("metrics.jsonl")
    }

    /// The evaluation's result.
    pub fn eval(&self) -> PathBuf {
        self.root.join("eval.json")
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
