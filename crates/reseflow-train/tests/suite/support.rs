//! Simulated demonstrations, a network small enough for tests, and a folder to train into.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use reseflow_data::{Dataset, ObservationHistory, Split};
use reseflow_flow::{GripperPrior, ObjectiveConfig, Path as FlowPath, Prior, TimeSampling};
use reseflow_lie::geodesic_distance;
use reseflow_net::{DecoderConfig, DriftNetConfig, EncoderConfig, GraphConfig, RadialBasis};
use reseflow_sim::{GenerateRequest, generate, task};
use reseflow_train::{
    DeviceKind, FlowPolicy, ModelConfig, PolicySample, Resume, TrainConfig, TrainError, TrainObserver,
    TrainRequest, TrainSummary, UpdateMetrics, ValidationMetrics, train,
};
use serde_json::Value;

/// The expert's demonstrations of the rotating triangle.
pub(crate) fn demonstrations(split: Split, episodes: usize) -> Dataset {
    let task = task("triangle").unwrap();
    let generated = generate(task.as_ref(), &GenerateRequest::new(split, 17, episodes), &|| {}).unwrap();
    Dataset { episodes: generated.episodes, meta: None }
}

/// A network of a few thousand numbers.
pub(crate) fn tiny_model() -> ModelConfig {
    let graph = GraphConfig { centres: 8, point_neighbors: 6, centre_neighbors: 4, color_m: 0.0 };
    let encoder = EncoderConfig {
        graph,
        channels: 8,
        layers: 1,
        nodes: 2,
        point_radial: RadialBasis { count: 6, max_m: 0.12 },
        centre_radial: RadialBasis { count: 6, max_m: 0.3 },
        ..EncoderConfig::default()
    };
    let decoder = DecoderConfig {
        horizon: 10,
        frames: 2,
        layers: 1,
        token_scalars: 16,
        token_vectors: 8,
        grasp_memory: true,
        ..DecoderConfig::default()
    };
    let prior = GripperPrior { sigma_rotation_rad: 0.5, sigma_translation_m: 0.1, sigma_opening: 0.2 };
    let network = DriftNetConfig { encoder, decoder, ..DriftNetConfig::default() };
    ModelConfig { network, prior: Prior::Gripper(prior), path: FlowPath::Screw, regression: false }
}

/// A training of `updates` updates on small batches.
pub(crate) fn tiny_training(updates: usize) -> TrainConfig {
    TrainConfig {
        updates,
        batch_size: 4,
        shards: 2,
        learning_rate: 5e-3,
        warmup: 10,
        weight_decay: 1e-4,
        clip_norm: 1.0,
        ema_decay: 0.95,
        first_window_share: 0.3,
        validate_every: updates,
        seed: 1,
        time: TimeSampling { zero_share: 0.3, ..TimeSampling::default() },
        objective: ObjectiveConfig { nodes: 0.5, opening: 0.25, overlap: 0.01, ..ObjectiveConfig::default() },
        ..TrainConfig::default()
    }
}

/// Everything that a training reported.
#[derive(Debug, Default)]
pub(crate) struct Journal {
    /// The updates, in order.
    pub(crate) updates: Vec<UpdateMetrics>,
    /// The validations, in order.
    pub(crate) validations: Vec<ValidationMetrics>,
}

impl TrainObserver for Journal {
    fn on_update(&mut self, metrics: &UpdateMetrics) {
        self.updates.push(*metrics);
    }

    fn on_validation(&mut self, metrics: &ValidationMetrics) {
        self.validations.push(*metrics);
    }
}

/// A temporary folder for checkpoints.
pub(crate) struct Shelf(tempfile::TempDir);

impl Shelf {
    /// An empty folder.
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    /// The path of `name` in the folder.
    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// The names of everything in the folder, sorted.
    pub(crate) fn names(&self) -> Vec<String> {
        contents(self.0.path()).into_keys().collect()
    }

    /// Trains the tiny network on the CPU into the folder `name`.
    pub(crate) fn train(
        &self,
        name: &str,
        config: &TrainConfig,
        data: &Dataset,
        validation: Option<&Dataset>,
    ) -> Result<(TrainSummary, Journal), TrainError> {
        self.train_model(name, &tiny_model(), config, data, validation)
    }

    /// Trains a model on the CPU into the folder `name`.
    pub(crate) fn train_model(
        &self,
        name: &str,
        model: &ModelConfig,
        config: &TrainConfig,
        data: &Dataset,
        validation: Option<&Dataset>,
    ) -> Result<(TrainSummary, Journal), TrainError> {
        let (mut journal, out) = (Journal::default(), self.path(name));
        let request = TrainRequest {
            model,
            train: config,
            demonstrations: data,
            mixture: None,
            validation,
            start: None,
            resume: Resume::Never,
            device: DeviceKind::Cpu,
            out: &out,
        };
        let summary = train(&request, &mut journal)?;
        Ok((summary, journal))
    }

    /// The policy in the folder `name`.
    pub(crate) fn policy(&self, name: &str) -> FlowPolicy {
        FlowPolicy::load(&self.path(name), DeviceKind::Cpu).unwrap()
    }
}

/// The names in a folder, with the files' bytes (none for a folder).
pub(crate) fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap());
    let named = |entry: std::fs::DirEntry| {
        let bytes = if entry.path().is_file() { std::fs::read(entry.path()).unwrap() } else { Vec::new() };
        (entry.file_name().to_string_lossy().into_owned(), bytes)
    };
    entries.map(named).collect()
}

/// What a policy of two frames has seen at step `step` of every episode.
pub(crate) fn histories(data: &Dataset, step: usize) -> Vec<ObservationHistory> {
    let history =
        |episode: &reseflow_data::Episode| ObservationHistory::at_step(&episode.observations, step, 2);
    data.episodes.iter().map(history).collect()
}

/// The mean D_geo of samples `[episode][seed]`, drawn at the start, to the demonstrated actions.
pub(crate) fn mean_d_geo(samples: &[Vec<PolicySample>], data: &Dataset) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for (drawn, episode) in samples.iter().zip(&data.episodes) {
        for (predicted, wanted) in
            drawn.iter().flat_map(|sample| sample.consensus.iter().zip(&episode.actions))
        {
            sum += geodesic_distance(&predicted.world_from_gripper, &wanted.world_from_gripper).d_geo();
            count += 1.0;
        }
    }
    sum / count
}

/// The lines of the metrics without the speed, which no two runs share.
pub(crate) fn untimed(lines: &[u8]) -> Vec<Value> {
    let line = |text: &str| {
        let mut line: Value = serde_json::from_str(text).unwrap();
        line.as_object_mut().unwrap().remove("samples_per_sec");
        line
    };
    std::str::from_utf8(lines).unwrap().lines().map(line).collect()
}
