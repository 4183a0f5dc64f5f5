//! Simulated demonstrations, networks small enough for tests, and a folder to train into.

use std::path::PathBuf;

use reseflow_data::{ActionChunk, Dataset, Episode, ObservationHistory, Split};
use reseflow_lie::geodesic_distance;
use reseflow_net::{DecoderConfig, DriftNetConfig, EncoderConfig, GraphConfig, RadialBasis};
use reseflow_sim::{GenerateRequest, generate, task};
use reseflow_train::{
    DeviceKind, EtSeedConfig, EtSeedPolicy, PolicySample, Resume, TrainConfig, TrainError, TrainObserver,
    TrainRequest, TrainSummary, UpdateMetrics, ValidationMetrics, train,
};

/// The expert's demonstrations of the rotating triangle.
pub(crate) fn demonstrations(split: Split, episodes: usize) -> Dataset {
    let task = task("triangle").unwrap();
    let generated = generate(task.as_ref(), &GenerateRequest::new(split, 17, episodes), &|| {}).unwrap();
    Dataset { episodes: generated.episodes, meta: None }
}

/// Two networks of a few thousand numbers.
pub(crate) fn tiny_config() -> EtSeedConfig {
    let encoder = EncoderConfig {
        graph: GraphConfig { centres: 8, point_neighbors: 6, centre_neighbors: 4, color_m: 0.0 },
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
        token_scalars: 32,
        token_vectors: 8,
        grasp_memory: true,
        ..DecoderConfig::default()
    };
    let network = DriftNetConfig { encoder, decoder, ..DriftNetConfig::default() };
    EtSeedConfig { network, ..EtSeedConfig::default() }
}

/// A training of `updates` updates on small batches.
pub(crate) fn tiny_training(updates: usize) -> TrainConfig {
    TrainConfig {
        updates,
        batch_size: 4,
        shards: 2,
        learning_rate: 5e-3,
        warmup: 10,
        ema_decay: 0.95,
        validate_every: updates,
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

    /// Trains the baseline on the CPU into the folder `name`.
    pub(crate) fn train(
        &self,
        name: &str,
        config: &EtSeedConfig,
        train_config: &TrainConfig,
        demonstrations: &Dataset,
        validation: Option<&Dataset>,
    ) -> Result<(TrainSummary, Journal), TrainError> {
        let (mut journal, out) = (Journal::default(), self.path(name));
        let request = TrainRequest {
            model: config,
            train: train_config,
            demonstrations,
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
    pub(crate) fn policy(&self, name: &str) -> EtSeedPolicy {
        EtSeedPolicy::load(&self.path(name), DeviceKind::Cpu).unwrap()
    }
}

/// What a policy of two frames has seen at step `step` of every episode.
pub(crate) fn histories(data: &Dataset, step: usize) -> Vec<ObservationHistory> {
    let history = |episode: &Episode| ObservationHistory::at_step(&episode.observations, step, 2);
    data.episodes.iter().map(history).collect()
}

/// D_geo of two trajectories, action by action.
pub(crate) fn errors(one: &ActionChunk, other: &ActionChunk) -> Vec<f64> {
    let pairs = one.iter().zip(other.iter());
    pairs.map(|(a, b)| geodesic_distance(&a.world_from_gripper, &b.world_from_gripper).d_geo()).collect()
}

/// The mean D_geo of samples `[episode][seed]`, drawn at the start, to the demonstrated actions.
pub(crate) fn mean_d_geo(samples: &[Vec<PolicySample>], data: &Dataset) -> f64 {
    let mut all = Vec::new();
    for (drawn, episode) in samples.iter().zip(&data.episodes) {
        for sample in drawn {
            all.extend(errors(&sample.consensus, &ActionChunk(episode.actions.clone())));
        }
    }
    all.iter().sum::<f64>() / all.len() as f64
}
