//! A checkpoint: a folder with the averaged weights and the configuration, written aside and renamed.

use std::path::Path;

use burn::module::{Module, ModuleVisitor, Param};
use burn::store::{ApplyError, ApplyResult, ModuleSnapshot, SafetensorsStore};
use burn::tensor::{Device, Tensor};
use serde::{Deserialize, Serialize};

use crate::trainable::random_stream;
use crate::{MixtureConfig, PolicyKind, TrainConfig, TrainError, Trainable};

/// The averaged weights.
pub const WEIGHTS: &str = "model.safetensors";
const CONFIG: &str = "config.toml";
/// The averaged weights of the best validation, where those of the end became the policy.
pub(crate) const BEST: &str = "best.safetensors";
/// The averaged weights of the end, where those of the best validation became the policy.
pub(crate) const LAST: &str = "last.safetensors";
/// What the trainer noted, one JSON object a line.
pub(crate) const METRICS: &str = "metrics.jsonl";

/// Makes sure that a checkpoint may become the folder `out`: there is none, an empty one, or an older checkpoint.
///
/// # Errors
/// [`TrainError::Checkpoint`] where replacing `out` would lose anything else.
pub(crate) fn may_become(out: &Path) -> Result<(), TrainError> {
    let refuse = |fault: String| Err(TrainError::Checkpoint { path: out.to_owned(), fault });
    let io = |source| TrainError::Io { path: out.to_owned(), source };
    if out.file_name().is_none() {
        return refuse("expected the name of a folder for the checkpoint".to_owned());
    }
    match std::fs::symlink_metadata(out) {
        Err(absent) if absent.kind() == std::io::ErrorKind::NotFound => return Ok(()),
        Err(source) => return Err(io(source)),
        Ok(what) if !what.is_dir() => {
            return refuse("is not a folder, so no checkpoint can take its place".to_owned());
        }
        Ok(_) => {}
    }
    for entry in std::fs::read_dir(out).map_err(io)? {
        let name = entry.map_err(io)?.file_name();
        if ![WEIGHTS, BEST, LAST, CONFIG, METRICS].iter().any(|known| name == **known) {
            let name = name.to_string_lossy().into_owned();
            return refuse(format!(
                "holds `{name}`, which is no part of a checkpoint, so it is not replaced"
            ));
        }
    }
    Ok(())
}

/// Moves the finished folder `new` to `out`; an older checkpoint there is parked at `old` and returns where that fails.
pub(crate) fn put_in_place(new: &Path, out: &Path, old: &Path) -> std::io::Result<()> {
    let replaces = out.exists();
    if replaces {
        std::fs::rename(out, old)?;
    }
    let moved = std::fs::rename(new, out);
    if moved.is_err() && replaces {
        std::fs::rename(old, out)?;
    }
    moved
}

/// What a checkpoint's `config.toml` says.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CheckpointConfig<M> {
    /// What was trained.
    pub kind: PolicyKind,
    /// The task that was learned, where the demonstrations said it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub task: Option<String>,
    /// The network and what it is made of.
    pub model: M,
    /// How it was trained.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub train: Option<TrainConfig>,
    /// What the batches were mixed of, for Flow 2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mixture: Option<MixtureConfig>,
}

/// What can be read of a checkpoint of any kind, and of one that says no kind: a flow's, whose model is the whole file.
#[derive(Deserialize)]
struct Head {
    kind: Option<PolicyKind>,
    task: Option<String>,
}

/// What the checkpoint in `folder` is, and which task it has learned, where it says so.
///
/// # Errors
/// [`TrainError::Io`] and [`TrainError::Checkpoint`] where the folder holds no readable `config.toml`.
pub fn read_kind(folder: &Path) -> Result<(PolicyKind, Option<String>), TrainError> {
    let head = head(folder)?.0;
    Ok((head.kind.unwrap_or(PolicyKind::Flow), head.task))
}

/// The head of `config.toml`, and its text.
fn head(folder: &Path) -> Result<(Head, String), TrainError> {
    let path = folder.join(CONFIG);
    let text =
        std::fs::read_to_string(&path).map_err(|source| TrainError::Io { path: path.clone(), source })?;
    let head = toml::from_str(&text).map_err(|error: toml::de::Error| no_config(&path, error.message()))?;
    Ok((head, text))
}

fn no_config(path: &Path, reason: &str) -> TrainError {
    let fault = format!("not a checkpoint's configuration: {reason}");
    TrainError::Checkpoint { path: path.to_owned(), fault }
}

/// Writes weights, configuration and the metrics' lines into the existing folder `folder`.
pub(crate) fn write<M: Trainable>(
    folder: &Path,
    net: &M::Net,
    config: &CheckpointConfig<M>,
    metrics: &[u8],
) -> Result<(), TrainError> {
    write_weights(&folder.join(WEIGHTS), net)?;
    let path = folder.join(CONFIG);
    let text = toml::to_string_pretty(config)
        .map_err(|error| TrainError::Checkpoint { path: path.clone(), fault: error.to_string() })?;
    std::fs::write(&path, text).map_err(|source| TrainError::Io { path, source })?;
    let path = folder.join(METRICS);
    std::fs::write(&path, metrics).map_err(|source| TrainError::Io { path, source })
}

/// Writes the weights of `net` to `path`.
///
/// # Errors
/// [`TrainError::Checkpoint`] where a weight is no finite number, [`TrainError::Io`].
pub(crate) fn write_weights<N: Module>(path: &Path, net: &N) -> Result<(), TrainError> {
    let fault = |fault: String| TrainError::Checkpoint { path: path.to_owned(), fault };
    if !is_finite(net) {
        return Err(fault(
            "the trained weights are not finite; train with a smaller learning rate".to_owned(),
        ));
    }
    // burn's own metadata lie in a hash map, in another order each time; a single entry keeps the bytes the same. In memory first:
    // the file that the store itself makes is its owner's alone.
    let mut store = SafetensorsStore::from_bytes(None).clear_metadata().metadata("producer", "reseflow");
    let weights = net.save_into(&mut store).and_then(|()| store.get_bytes());
    let weights = weights.map_err(|error| fault(error.to_string()))?;
    std::fs::write(path, weights).map_err(|source| TrainError::Io { path: path.to_owned(), source })
}

/// Reads a checkpoint of the kind of `M` back.
pub(crate) fn read<M: Trainable>(
    folder: &Path,
    device: &Device,
) -> Result<(M::Net, CheckpointConfig<M>), TrainError> {
    let path = folder.join(CONFIG);
    let fault = |path: &Path, fault: String| TrainError::Checkpoint { path: path.to_owned(), fault };
    let (head, text) = head(folder)?;
    let kind = head.kind.unwrap_or(PolicyKind::Flow);
    if kind != M::KIND {
        let (expected, got) = (M::KIND.name(), kind.name());
        return Err(fault(
            &path,
            format!("is the checkpoint of a policy of kind `{got}`, expected `{expected}`"),
        ));
    }
    let parsed = match head.kind {
        Some(_) => toml::from_str(&text),
        None => toml::from_str(&text).map(|model| CheckpointConfig {
            kind,
            task: None,
            model,
            train: None,
            mixture: None,
        }),
    };
    let config: CheckpointConfig<M> = parsed.map_err(|error| no_config(&path, error.message()))?;
    config.model.check().map_err(|error| fault(&path, error.to_string()))?;
    // The drawn weights are all replaced; any stream will do.
    let mut net = config.model.init(device, &mut random_stream(0, 0))?;
    let weights = folder.join(WEIGHTS);
    if !weights.is_file() {
        return Err(fault(&weights, "there is no such file, expected the network's weights".to_owned()));
    }
    let mut store = SafetensorsStore::from_file(&weights).validate(false).allow_partial(true);
    let loaded = net
        .load_from(&mut store)
        .map_err(|error| fault(&weights, format!("cut off, or no safetensors file: {error}")))?;
    if let Some(text) = misfit(&loaded) {
        return Err(fault(&weights, format!("not the weights of the configured network: {text}")));
    }
    if !is_finite(&net) {
        return Err(fault(&weights, "there are weights that are not finite".to_owned()));
    }
    Ok((net, config))
}

/// How a file's tensors differ from the network's, if they do: the first difference, and how many more there are.
fn misfit(loaded: &ApplyResult) -> Option<String> {
    let errors = loaded.errors.iter().map(|error| match error {
        ApplyError::ShapeMismatch { path, expected, found } => {
            format!("`{path}` has the shape {:?}, expected {:?}", found.as_slice(), expected.as_slice())
        }
        other => other.to_string(),
    });
    let missing = loaded.missing.iter().map(|(path, _)| format!("`{path}` is missing"));
    let unused = loaded.unused.iter().map(|path| format!("`{path}` is unknown"));
    let mut faults = errors.chain(missing).chain(unused);
    let first = faults.next()?;
    Some(match faults.count() {
        0 => first,
        more => format!("{first}, and {more} more differences"),
    })
}

/// Whether every weight is a finite number.
fn is_finite<N: Module>(net: &N) -> bool {
    let mut finite = Finite(true);
    net.visit(&mut finite);
    finite.0
}

/// Notes a weight that is not finite.
struct Finite(bool);

impl ModuleVisitor for Finite {
    fn visit_float<const D: usize>(&mut self, param: &Param<Tensor<D>>) {
        self.0 &= param.val().try_to_vec_as::<f64>().is_ok_and(|values| values.iter().all(|v| v.is_finite()));
    }
}
