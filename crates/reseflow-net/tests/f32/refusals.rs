//! What the network refuses, and how it says so.

use burn::tensor::Device;
use reseflow_lie::SE3;
use reseflow_net::{
    DriftNet, DriftNetConfig, EncodedScenes, GraphConfig, NetError, Parameterisation, RadialBasis,
    SceneBatch, SceneContext, SceneState, TokenBatch,
};

use crate::support::laws::example;
use crate::support::scene::{Cloud, Scene, gripper};
use crate::support::trajectory::{encode, predict};
use crate::support::twists::in_twist_form;
use crate::support::weights::drawn_net;
use crate::support::{devices, rng, small};

#[test]
fn a_size_that_makes_no_sense_is_named() {
    type Spoil = fn(&mut DriftNetConfig);
    let cases: [(&str, Spoil); 19] = [
        ("encoder.graph.centres", |config| config.encoder.graph.centres = 0),
        ("encoder.graph.point_neighbors", |config| config.encoder.graph.point_neighbors = 0),
        ("encoder.graph.centre_neighbors", |config| config.encoder.graph.centre_neighbors = 0),
        ("encoder.channels", |config| config.encoder.channels = 0),
        ("encoder.nodes", |config| config.encoder.nodes = 0),
        ("encoder.point_radial", |config| config.encoder.point_radial.count = 1),
        ("encoder.centre_radial", |config| config.encoder.centre_radial.max_m = f64::NAN),
        ("encoder.centre_radial", |config| config.encoder.centre_radial.max_m = 0.0),
        ("decoder.horizon", |config| config.decoder.horizon = 0),
        ("decoder.frames", |config| config.decoder.frames = 0),
        ("decoder.token_scalars", |config| config.decoder.token_scalars = 0),
        ("decoder.token_vectors", |config| config.decoder.token_vectors = 0),
        ("encoder.graph.color_m", |config| config.encoder.graph.color_m = -0.1),
        ("encoder.graph.color_m", |config| config.encoder.graph.color_m = f64::NAN),
        ("decoder.pointers", |config| config.decoder.pointers = 5),
        ("encoder.max_degree", |config| config.encoder.max_degree = 0),
        ("encoder.max_degree", |config| config.encoder.max_degree = 4),
        ("encoder.max_degree", |config| (config.encoder.max_degree, config.encoder.layers) = (2, 1)),
        ("encoder.max_degree", |config| (config.encoder.max_degree, config.encoder.layers) = (3, 0)),
    ];
    for (key, spoil) in cases {
        let mut config = DriftNetConfig::default();
        assert_eq!(config.validate(), Ok(()));
        spoil(&mut config);
        let error = config.validate().expect_err("the size makes no sense");
        assert!(error.to_string().contains(&format!("{key} ")), "{key}: {error}");
        let [(_, device), _] = devices();
        assert_eq!(config.init(&device, &mut rng(70)).map(|_| ()), Err(error));
    }
}

#[test]
fn the_smallest_valid_network_works() {
    let mut config = small();
    let encoder = &mut config.encoder;
    encoder.graph = GraphConfig { centres: 1, point_neighbors: 1, centre_neighbors: 1, color_m: 0.0 };
    (encoder.channels, encoder.layers, encoder.nodes) = (1, 0, 1);
    encoder.point_radial = RadialBasis { count: 2, max_m: 0.1 };
    let decoder = &mut config.decoder;
    (decoder.horizon, decoder.frames, decoder.layers) = (1, 1, 0);
    (decoder.token_scalars, decoder.token_vectors, decoder.pointers) = (1, 1, 1);
    assert_eq!(config.validate(), Ok(()));
    for (name, device) in devices() {
        let net = drawn_net(&config, &device, &mut rng(71));
        for index in 0..4 {
            let trajectory = predict(&net, &[example(index, &config)], &device).remove(0);
            assert!(trajectory.consensus[0].1.iter().all(|value| value.is_finite()), "{name}");
        }
    }
}

/// A network with two encoded scenes and their states.
struct Prepared {
    device: Device,
    net: DriftNet,
    scenes: [Scene; 2],
    encoded: Vec<EncodedScenes>,
    states: Vec<SceneState>,
}

impl Prepared {
    fn new() -> Prepared {
        let [(_, device), _] = devices();
        let config = small();
        let net = drawn_net(&config, &device, &mut rng(72));
        let scenes = [example(0, &config), example(1, &config)];
        let encoded = encode(&net, &scenes, &device);
        let states = scenes.iter().map(Scene::state).collect();
        Prepared { device, net, scenes, encoded, states }
    }

    fn context(&self) -> SceneContext {
        self.net.context(&self.encoded, &self.states).expect("frames and states go together")
    }
}

#[track_caller]
fn assert_mismatch<T: std::fmt::Debug>(result: Result<T, NetError>, wanted: [usize; 2], about: &str) {
    match result {
        Err(NetError::Mismatch { what, expected, got }) => {
            assert_eq!([expected, got], wanted);
            assert!(what.contains(about), "{what}");
        }
        other => panic!("expected a mismatch of {about}, got {other:?}"),
    }
}

#[test]
fn frames_and_states_that_do_not_go_together_are_refused() {
    let prepared = Prepared::new();
    let Prepared { device, net, scenes, encoded, states } = &prepared;
    assert_mismatch(net.context(&encoded[1..], states), [3, 2], "frames");
    assert_mismatch(net.context(&[], states), [3, 0], "frames");
    assert_mismatch(net.context(encoded, &states[..1]), [1, 2], "scenes");
    assert_mismatch(net.context(encoded, &[]), [0, 2], "scenes");
    let mut forgetful = states.clone();
    forgetful[1].frames.pop();
    assert_mismatch(net.context(encoded, &forgetful), [3, 2], "gripper states");
    let mut uneven = encoded.clone();
    uneven[0] = encode(net, &scenes[..1], device).remove(0);
    assert_mismatch(net.context(&uneven, states), [2, 1], "scenes");
}

#[test]
fn tokens_that_do_not_fit_are_refused() {
    let prepared = Prepared::new();
    let context = prepared.context();
    let noise: Vec<_> = prepared.scenes.iter().map(|scene| scene.noise.clone()).collect();
    let batch = |trajectories: &[Vec<_>], times: &[f64], origins: &[[f64; 3]]| {
        TokenBatch::new(trajectories, times, origins, &prepared.device)
    };
    let origins = &context.origins_m;
    assert_mismatch(batch(&noise[..1], &[0.1, 0.2], origins), [2, 1], "trajectories");
    assert_mismatch(batch(&noise, &[0.1], origins), [2, 1], "times");
    let ragged = [noise[0].clone(), noise[1][..4].to_vec()];
    assert_mismatch(batch(&ragged, &[0.1, 0.2], origins), [5, 4], "tokens");

    let short: Vec<_> = noise.iter().map(|trajectory| trajectory[..4].to_vec()).collect();
    let short = batch(&short, &[0.1, 0.2], origins).expect("both are equally short");
    assert_mismatch(prepared.net.decode(&context, &short), [5, 4], "tokens per trajectory");
    let lone = batch(&noise[..1], &[0.1], &origins[..1]).expect("one scene is a batch");
    assert_mismatch(prepared.net.decode(&context, &lone), [10, 5], "tokens in the batch");
}

#[test]
fn a_prediction_that_the_network_was_not_made_for_is_refused() {
    let prepared = Prepared::new();
    let context = prepared.context();
    let noise: Vec<_> = prepared.scenes.iter().map(|scene| scene.noise.clone()).collect();
    let tokens = TokenBatch::new(&noise, &[0.1, 0.2], &context.origins_m, &prepared.device)
        .expect("the tokens fit the context");
    let refused = prepared.net.decode_twists(&context, &tokens).map(|_| ());
    let (configured, asked) = (Parameterisation::Endpoint, Parameterisation::Twist);
    assert_eq!(refused, Err(NetError::Parameterisation { configured, asked }));

    let net = drawn_net(&in_twist_form(small()), &prepared.device, &mut rng(74));
    let context = net.context(&prepared.encoded, &prepared.states).expect("sizes are the same");
    let refused = net.decode(&context, &tokens).map(|_| ());
    assert_eq!(refused, Err(NetError::Parameterisation { configured: asked, asked: configured }));
    assert!(net.decode_twists(&context, &tokens).is_ok());
}

#[test]
fn graphs_of_different_sizes_are_refused() {
    let [(_, device), _] = devices();
    let mut rng = rng(73);
    let config = small().encoder;
    let cloud = Cloud::in_a_box(30, &mut rng);
    let home = gripper(&SE3::identity(), [2.0, 0.2], &mut rng);
    let collate = |spoil: fn(&mut GraphConfig)| {
        let mut other = config.graph;
        spoil(&mut other);
        let graphs = [cloud.graph(&config.graph), cloud.graph(&other)];
        let grippers = [home; 2];
        SceneBatch::collate(&graphs, &grippers, &config.point_radial, &config.centre_radial, &device)
    };
    assert!(collate(|_| ()).is_ok());
    assert_mismatch(collate(|graph| graph.centres = 9), [10, 9], "centres");
    assert_mismatch(collate(|graph| graph.point_neighbors = 7), [6, 7], "edges per centre");
    assert_mismatch(collate(|graph| graph.centre_neighbors = 3), [4, 3], "edges among centres");
    let none = SceneBatch::collate([], &[], &config.point_radial, &config.centre_radial, &device);
    assert_mismatch(none, [1, 0], "scenes");
    let graph = cloud.graph(&config.graph);
    let no_gripper = SceneBatch::collate([&graph], &[], &config.point_radial, &config.centre_radial, &device);
    assert_mismatch(no_gripper, [1, 0], "grippers");
}
