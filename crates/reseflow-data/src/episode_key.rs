//! The name of an episode, from which its random stream follows.

use std::fmt;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde::{Deserialize, Serialize};

/// Which part of a data set an episode belongs to. Splits never share a random stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Split {
    /// Demonstrations to learn from.
    Train,
    /// For choosing checkpoints and settings.
    Validation,
    /// For reported figures only.
    Test,
    /// Poses, sizes and viewpoints outside the training distribution.
    Wide,
}

impl fmt::Display for Split {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Split::Train => "train",
            Split::Validation => "validation",
            Split::Test => "test",
            Split::Wide => "wide",
        })
    }
}

/// Everything that an episode's scene is drawn from.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct EpisodeKey {
    /// The task's registered name.
    pub task: String,
    /// The split.
    pub split: Split,
    /// The user's seed.
    pub seed: u64,
    /// The episode's index under that seed.
    pub index: u64,
    /// How many earlier attempts at this index were dropped.
    pub attempt: u32,
}

impl EpisodeKey {
    /// The random stream named `purpose` of this episode: a hash of the whole key, so that no two keys share a stream.
    pub fn rng(&self, purpose: &str) -> ChaCha8Rng {
        let mut hasher = blake3::Hasher::new_derive_key("reseflow episode stream v1");
        for text in [self.task.as_str(), &self.split.to_string(), purpose] {
            hasher.update(&(text.len() as u64).to_le_bytes());
            hasher.update(text.as_bytes());
        }
        hasher.update(&self.seed.to_le_bytes());
        hasher.update(&self.index.to_le_bytes());
        hasher.update(&self.attempt.to_le_bytes());
        ChaCha8Rng::from_seed(*hasher.finalize().as_bytes())
    }
}
