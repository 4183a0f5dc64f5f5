//! The baseline's checkpoint: a folder like a flow's, whose `config.toml` says `kind = "et_seed"`.

use std::path::Path;

use burn::module::{Module, ModuleVisitor, Param};
use burn::store::{ModuleSnapshot, SafetensorsStore};
use burn::tensor::{Device, Tensor};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde::{Deserialize, Serialize};

use super::config::EtSeedConfig;
use super::net::EtSeedNet;
use crate::TrainError;
use crate::checkpoint::{METRICS, WEIGHTS};

const CONFIG: &str = "config.toml";

/// What tells the baseline's checkpoint from a flow's.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Kind {
    EtSeed,
}

/// The contents of `config.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Contents {
    kind: Kind,
    baseline: EtSeedConfig,
}

/// Writes weights, configuration and the metrics' lines into the existing folder `folder`.
pub(super) fn write(
    folder: &Path,
    net: &EtSeedNet,
    config: &EtSeedConfig,
    metrics: &[u8],
) -> Result<(), TrainError> {
    let weights = folder.join(WEIGHTS);
    let fault = |path: &Path, fault: String| TrainError::Checkpoint { path: path.to_owned(), fault };
    let mut store = SafetensorsStore::from_file(&weights).clear_metadata().metadata("producer", "reseflow");
    net.save_into(&mut store).map_err(|error| fault(&weights, format!("{error}")))?;
    let path = folder.join(CONFIG);
    let contents = Contents { kind: Kind::EtSeed, baseline: config.clone() };
    let text = toml::to_string_pretty(&contents).map_err(|error| fault(&path, error.to_string()))?;
    std::fs::write(&path, text).map_err(|source| TrainError::Io { path, source })?;
    let path = folder.join(METRICS);
    std::fs::write(&path, metrics).map_err(|source| TrainError::Io { path, source })
}

/// Reads a checkpoint back.
pub(super) fn read(folder: &Path, device: &Device) -> Result<(EtSeedNet, EtSeedConfig), TrainError> {
    let path = folder.join(CONFIG);
    let fault = |path: &Path, fault: String| TrainError::Checkpoint { path: path.to_owned(), fault };
    let text =
        std::fs::read_to_string(&path).map_err(|source| TrainError::Io { path: path.clone(), source })?;
    let Contents { kind: Kind::EtSeed, baseline: config } = toml::from_str(&text)
        .map_err(|error| fault(&path, format!("not the baseline's configuration: {}", error.message())))?;
    config.validate().map_err(|error| fault(&path, error.to_string()))?;
    // The drawn weights are all replaced; any stream will do.
    let mut net = EtSeedNet::new(&config, device, &mut ChaCha8Rng::seed_from_u64(0));
    let weights = folder.join(WEIGHTS);
    if !weights.is_file() {
        return Err(fault(&weights, "there is no such file, expected the networks' weights".to_owned()));
    }
    let mut store = SafetensorsStore::from_file(&weights).validate(false).allow_partial(true);
    let loaded = net
        .load_from(&mut store)
        .map_err(|error| fault(&weights, format!("cut off, or no safetensors file: {error}")))?;
    let differences = loaded.errors.len() + loaded.missing.len() + loaded.unused.len();
    if differences > 0 {
        let text = format!("not the weights of the configured networks: {differences} differences");
        return Err(fault(&weights, text));
    }
    let mut finite = Finite(true);
    net.visit(&mut finite);
    if !finite.0 {
        return Err(fault(&weights, "there are weights that are not finite".to_owned()));
    }
    Ok((net, config))
}

/// Whether every weight is a finite number.
struct Finite(bool);

impl ModuleVisitor for Finite {
    fn visit_float<const D: usize>(&mut self, param: &Param<Tensor<D>>) {
        self.0 &= param.val().try_to_vec_as::<f64>().is_ok_and(|values| values.iter().all(|v| v.is_finite()));
    }
}
