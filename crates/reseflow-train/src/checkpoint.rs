//! A checkpoint: a folder with the averaged weights and the configuration, written aside and renamed.

use std::path::Path;

use burn::store::{ModuleSnapshot, SafetensorsStore};
use burn::tensor::Device;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use reseflow_net::DriftNet;

use crate::{ModelConfig, TrainError};

const WEIGHTS: &str = "model.safetensors";
const CONFIG: &str = "config.toml";

/// Writes weights and configuration into the existing folder `folder`.
pub(crate) fn write(folder: &Path, net: &DriftNet, config: &ModelConfig) -> Result<(), TrainError> {
    let weights = folder.join(WEIGHTS);
    let fault = |path: &Path, fault: String| TrainError::Checkpoint { path: path.to_owned(), fault };
    net.save_into(&mut SafetensorsStore::from_file(&weights))
        .map_err(|error| fault(&weights, format!("{error}")))?;
    let path = folder.join(CONFIG);
    let text = toml::to_string_pretty(config).map_err(|error| fault(&path, error.to_string()))?;
    std::fs::write(&path, text).map_err(|source| TrainError::Io { path, source })
}

/// Reads a checkpoint back.
pub(crate) fn read(folder: &Path, device: &Device) -> Result<(DriftNet, ModelConfig), TrainError> {
    let path = folder.join(CONFIG);
    let fault = |path: &Path, fault: String| TrainError::Checkpoint { path: path.to_owned(), fault };
    let text =
        std::fs::read_to_string(&path).map_err(|source| TrainError::Io { path: path.clone(), source })?;
    let config: ModelConfig = toml::from_str(&text)
        .map_err(|error| fault(&path, format!("not a model's configuration: {}", error.message())))?;
    config.validate()?;
    // The drawn weights are all replaced; any stream will do.
    let mut net = config.network.init(device, &mut ChaCha8Rng::seed_from_u64(0));
    let weights = folder.join(WEIGHTS);
    if !weights.is_file() {
        return Err(fault(&weights, "there is no such file, expected the network's weights".to_owned()));
    }
    let loaded = net.load_from(&mut SafetensorsStore::from_file(&weights)).map_err(|error| {
        let text = format!("{error:?}");
        fault(
            &weights,
            format!("not the weights of this network, or cut off: {}", text.lines().next().unwrap_or("")),
        )
    })?;
    if !loaded.missing.is_empty() || !loaded.unused.is_empty() {
        let counts = format!("{} tensors missing and {} unknown", loaded.missing.len(), loaded.unused.len());
        return Err(fault(&weights, format!("not the weights of the configured network: {counts}")));
    }
    Ok((net, config))
}
