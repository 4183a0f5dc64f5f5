//! From the simulator through the network back into the simulator: a policy that has learned one demonstration by heart solves
//! its scene by contact, closed loop, in one integration step.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

use reseflow_data::{Dataset, EpisodeKey, IgnoreEvents, Outcome, Policy, RolloutConfig, Split, rollout};
use reseflow_net::{EncoderConfig, GraphConfig};
use reseflow_sim::{GenerateRequest, generate, task};
use reseflow_train::{
    DeviceKind, FlowPolicy, ModelConfig, Resume, TrainConfig, TrainObserver, TrainRequest, UpdateMetrics,
    ValidationMetrics, train,
};

const SEED: u64 = 91;

struct Silent;

impl TrainObserver for Silent {
    fn on_update(&mut self, _metrics: &UpdateMetrics) {}
    fn on_validation(&mut self, _metrics: &ValidationMetrics) {}
}

/// A small policy after `updates` updates on the one episode of `data`.
fn trained(data: &Dataset, updates: usize) -> FlowPolicy {
    let mut model = ModelConfig::default();
    model.network.encoder = EncoderConfig {
        graph: GraphConfig { centres: 16, point_neighbors: 8, centre_neighbors: 6, color_m: 0.0 },
        channels: 16,
        layers: 1,
        ..EncoderConfig::default()
    };
    model.network.decoder.frames = 1;
    model.network.decoder.layers = 1;
    let config = TrainConfig {
        updates,
        batch_size: 8,
        shards: 2,
        learning_rate: 5e-3,
        warmup: 20,
        ema_decay: 0.98,
        seed: 1,
        ..TrainConfig::default()
    };
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("policy");
    let request = TrainRequest {
        model: &model,
        train: &config,
        demonstrations: data,
        mixture: None,
        validation: None,
        start: None,
        resume: Resume::Never,
        device: DeviceKind::Cpu,
        out: &out,
    };
    train(&request, &mut Silent).unwrap();
    FlowPolicy::load(&out, DeviceKind::Cpu).unwrap()
}

/// How `policy` fares in the first training scene, looking again after every three actions.
fn outcome(policy: &mut dyn Policy) -> Outcome {
    let task = task("triangle").unwrap();
    let key =
        EpisodeKey { task: "triangle".to_owned(), split: Split::Train, seed: SEED, index: 0, attempt: 0 };
    let mut scene = task.reset(&key).unwrap();
    let config =
        RolloutConfig { observation_horizon: 1, n_action_steps: 3, disturb_before: None, policy_seed: 5 };
    rollout(scene.as_mut(), &task.spec(), policy, &config, &mut IgnoreEvents).unwrap().outcome
}

#[test]
fn a_policy_that_knows_one_demonstration_by_heart_solves_its_scene() {
    let request = GenerateRequest::new(Split::Train, SEED, 1);
    let generated = generate(task("triangle").unwrap().as_ref(), &request, &|| {}).unwrap();
    let data = Dataset { episodes: generated.episodes, meta: None };

    let learned = outcome(&mut trained(&data, 400));
    assert!(learned.success, "{} is {:.3}", learned.measure_name, learned.measure);
    let untrained = outcome(&mut trained(&data, 1));
    assert!(!untrained.success, "the scene is solved by a policy that has learned nothing");
}
