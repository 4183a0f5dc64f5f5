//! What a training is made of, as hashes: a state is used only for the program, configuration, data and start that it came from.

use std::path::Path;
use std::sync::LazyLock;

use reseflow_data::{Action, Dataset, Disturbance, Episode, Observation};
use reseflow_lie::SE3;
use serde::{Deserialize, Serialize};

use crate::{Mixture, TrainConfig, TrainError, TrainRequest, Trainable};

/// Hashes of everything that a training's bytes depend on.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Fingerprint {
    program: String,
    config: String,
    demonstrations: String,
    validation: Option<String>,
    start: Option<String>,
    mixture: Option<String>,
}

impl Fingerprint {
    /// The fingerprint of `request`.
    ///
    /// # Errors
    /// Where the checkpoint to start from cannot be read.
    pub(crate) fn of<M: Trainable>(request: &TrainRequest<'_, M>) -> Result<Self, TrainError> {
        // How often a state is saved changes nothing in what is computed.
        let train = TrainConfig { save_every: 0, ..request.train.clone() };
        let config = serde_json::to_vec(&(M::KIND, request.model, train, request.device))
            .map_err(|fault| TrainError::Config(fault.to_string()))?;
        Ok(Self {
            program: PROGRAM.clone(),
            config: blake3::hash(&config).to_hex().to_string(),
            demonstrations: hash_of_data(request.demonstrations),
            validation: request.validation.map(hash_of_data),
            start: request.start.map(hash_of_checkpoint).transpose()?,
            mixture: request.mixture.map(hash_of_mixture).transpose()?,
        })
    }

    /// What `other` differs in, if it does.
    pub(crate) fn difference(&self, other: &Self) -> Option<&'static str> {
        let differences = [
            (self.config != other.config, "with another configuration"),
            (self.demonstrations != other.demonstrations, "with other demonstrations"),
            (self.validation != other.validation, "with other validation episodes"),
            (self.start != other.start, "from other weights to start with"),
            (self.mixture != other.mixture, "with other pairs"),
            (self.program != other.program, "by another build of this program"),
        ];
        differences.into_iter().find_map(|(differs, how)| differs.then_some(how))
    }
}

/// The hash of the running program's file; its version where the file cannot be read.
static PROGRAM: LazyLock<String> = LazyLock::new(|| {
    let read = || -> std::io::Result<String> {
        let mut hasher = blake3::Hasher::new();
        hasher.update_reader(std::fs::File::open(std::env::current_exe()?)?)?;
        Ok(hasher.finalize().to_hex().to_string())
    };
    read().unwrap_or_else(|_| env!("CARGO_PKG_VERSION").to_owned())
});

fn hash_of_checkpoint(folder: &Path) -> Result<String, TrainError> {
    let path = folder.join(crate::checkpoint::WEIGHTS);
    let bytes = std::fs::read(&path).map_err(|source| TrainError::Io { path, source })?;
    Ok(blake3::hash(&bytes).to_hex().to_string())
}

fn hash_of_mixture(mixture: &Mixture<'_>) -> Result<String, TrainError> {
    let (config, windows) = mixture.parts();
    let config = serde_json::to_vec(config).map_err(|fault| TrainError::Config(fault.to_string()))?;
    let mut hasher = blake3::Hasher::new();
    hasher.update(&config);
    for of in windows {
        let mut bytes = Vec::new();
        for number in [of.window.episode, of.window.step, of.pairs.len()] {
            put_length(&mut bytes, number);
        }
        for pair in &of.pairs {
            put_actions(&mut bytes, &pair.noise.0);
            put_actions(&mut bytes, &pair.image.0);
        }
        hasher.update(&bytes);
    }
    Ok(hasher.finalize().to_hex().to_string())
}

fn hash_of_data(data: &Dataset) -> String {
    let mut hasher = blake3::Hasher::new();
    for episode in &data.episodes {
        hasher.update(&bytes_of_episode(episode));
    }
    hasher.finalize().to_hex().to_string()
}

/// An episode's values in order, every list with its length in front, so that no two episodes share their bytes.
fn bytes_of_episode(episode: &Episode) -> Vec<u8> {
    let mut bytes = Vec::new();
    put_length(&mut bytes, episode.observations.len());
    for Observation { cloud, world_from_gripper, gripper_opening } in &episode.observations {
        put_length(&mut bytes, cloud.points.len());
        bytes.extend(cloud.points.iter().flatten().flat_map(|value| value.to_le_bytes()));
        put_length(&mut bytes, cloud.colors.len());
        bytes.extend(cloud.colors.iter().flatten());
        put_pose(&mut bytes, world_from_gripper);
        bytes.extend(gripper_opening.to_le_bytes());
    }
    put_actions(&mut bytes, &episode.actions);
    let alternative = episode.alternative.as_deref().unwrap_or_default();
    put_length(&mut bytes, alternative.len());
    alternative.iter().for_each(|pose| put_pose(&mut bytes, pose));
    if let Some(Disturbance { before, answered_from }) = episode.disturbance {
        put_length(&mut bytes, before);
        put_length(&mut bytes, answered_from);
    }
    bytes
}

fn put_length(bytes: &mut Vec<u8>, length: usize) {
    bytes.extend((length as u64).to_le_bytes());
}

fn put_actions(bytes: &mut Vec<u8>, actions: &[Action]) {
    put_length(bytes, actions.len());
    for action in actions {
        put_pose(bytes, &action.world_from_gripper);
        bytes.extend(action.opening.to_le_bytes());
    }
}

fn put_pose(bytes: &mut Vec<u8>, pose: &SE3) {
    let rotation = pose.rotation.matrix();
    bytes.extend(rotation.iter().chain(pose.translation.iter()).flat_map(|value| value.to_le_bytes()));
}
