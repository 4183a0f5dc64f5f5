//! The network in twist form: body twists are numbers, so the same ones must come out wherever the scene stands.

use burn::module::{Module, ModuleMapper, Param};
use burn::tensor::{Device, Tensor};
use reseflow_lie::{Matrix3, Vector3};
use reseflow_net::{DriftNet, DriftNetConfig, Parameterisation, TokenBatch, TwistPrediction};

use super::gradients::{named_gradients, weighed};
use super::laws::example;
use super::scene::Scene;
use super::trajectory::encode;
use super::weights::{drawn_net, shaken_net};
use super::world::World;
use super::{assert_caught, assert_small, devices, rng, small, values, worse, worst_difference};

/// Metres that count as much as a radian where twists are compared.
const LENGTH_M: f64 = 0.1;

/// The same sizes, predicting twists.
pub(crate) fn in_twist_form(mut config: DriftNetConfig) -> DriftNetConfig {
    config.decoder.parameterisation = Parameterisation::Twist;
    config
}

/// The network's twists for `scenes`.
pub(crate) fn twists(net: &DriftNet, scenes: &[Scene], device: &Device) -> TwistPrediction {
    let encoded = encode(net, scenes, device);
    let states: Vec<_> = scenes.iter().map(Scene::state).collect();
    let context = net.context(&encoded, &states).expect("frames and states go together");
    let noise: Vec<_> = scenes.iter().map(|scene| scene.noise.clone()).collect();
    let times: Vec<_> = scenes.iter().map(|scene| scene.time).collect();
    let tokens = TokenBatch::new(&noise, &times, &context.origins_m, device).expect("one token list a scene");
    net.decode_twists(&context, &tokens).expect("the tokens have the network's horizon")
}

/// Every number of a prediction, metres over [`LENGTH_M`].
pub(crate) fn numbers(prediction: &TwistPrediction) -> Vec<f64> {
    let scaled = |twists: &Tensor<2>| {
        values(twists)
            .chunks_exact(6)
            .flat_map(|twist| [0, 1, 2, 3, 4, 5].map(|i| if i < 3 { twist[i] } else { twist[i] / LENGTH_M }))
            .collect::<Vec<_>>()
    };
    let mut all = scaled(&prediction.twists);
    all.extend(scaled(&prediction.node_twists));
    all.extend(values(&prediction.openings));
    all.extend(values(&prediction.weights));
    all.extend(values(&prediction.spread()));
    all
}

fn network(config: &DriftNetConfig, device: &Device, stream: u64) -> DriftNet {
    let mut rng = rng(stream);
    shaken_net(config, device, &mut rng)
}

pub(crate) fn a_moved_scene_gives_the_same_body_twists(tolerance: f64) {
    for (name, device) in devices() {
        for (size, config, scenes) in [("default", DriftNetConfig::default(), 12), ("small", small(), 24)] {
            let config = in_twist_form(config);
            let mut worst = 0.0;
            for index in 0..scenes {
                let (net, scene) = (network(&config, &device, 7100 + index), example(index, &config));
                let world = World::rigid(&mut rng(7150 + index));
                let [still, moved] = [&scene, &scene.moved(&world)]
                    .map(|scene| numbers(&twists(&net, std::slice::from_ref(scene), &device)));
                assert!(still.iter().any(|value| value.abs() > 0.1), "the twists are not trivial");
                worst = worse(worst, worst_difference(&still, &moved));
            }
            assert_small(&format!("{name} {size} net, body twists"), worst, tolerance);
        }
    }
}

/// A mirror image, and noise that stays behind, must not give the same twists.
pub(crate) fn body_twists_of_another_scene_are_others() {
    for (name, device) in devices() {
        let config = in_twist_form(small());
        for index in 0..4 {
            let (net, scene) = (network(&config, &device, 7200 + index), example(index, &config));
            let say = |scene: &Scene| numbers(&twists(&net, std::slice::from_ref(scene), &device));
            let still = say(&scene);
            let mut rng = rng(7250 + index);
            let mirror = World::reflection(&mut rng);
            let mirrored = worst_difference(&still, &say(&scene.moved(&mirror)));
            assert_caught(&format!("{name} twists of a mirrored scene"), mirrored, 1e-3);
            let behind = Scene { noise: scene.noise.clone(), ..scene.moved(&World::rigid(&mut rng)) };
            assert_caught(
                &format!("{name} twists where noise stays behind"),
                worst_difference(&still, &say(&behind)),
                1e-3,
            );
        }
    }
}

/// What the formula says, put together on the host: the consensus is the weighted mean, and the spread its weighted deviation.
pub(crate) fn the_consensus_twist_is_the_weighted_mean_of_the_nodes(tolerance: f64) {
    for (name, device) in devices() {
        let config = in_twist_form(small());
        let net = network(&config, &device, 7300);
        let prediction = twists(&net, &[example(0, &config), example(1, &config)], &device);
        let (nodes, weights) = (values(&prediction.node_twists), values(&prediction.weights));
        let count = config.encoder.nodes;
        let (twists, spreads) = (values(&prediction.twists), values(&prediction.spread()));
        for (row, (twist, spread)) in twists.chunks_exact(6).zip(&spreads).enumerate() {
            let of_node = |node: usize| &nodes[6 * (row * count + node)..][..6];
            let weight = |node: usize| weights[row * count + node];
            let mut mean = [0.0; 6];
            for node in 0..count {
                mean.iter_mut().zip(of_node(node)).for_each(|(mean, value)| *mean += weight(node) * value);
            }
            assert_small(&format!("{name} consensus"), worst_difference(&mean, twist), tolerance);
            let squared = |node: usize| -> f64 {
                weight(node) * of_node(node).iter().zip(&mean).map(|(a, b)| (a - b) * (a - b)).sum::<f64>()
            };
            let expected = (0..count).map(squared).sum::<f64>().sqrt();
            assert_small(&format!("{name} spread"), (spread - expected).abs(), tolerance.max(1e-6));
        }
    }
}

/// Turning one noisy pose about its own origin turns what is read in it, but for what its features see: with every layer's say
/// taken away, the vectors of the scene are all that is left, and they are the same vectors in another frame.
pub(crate) fn twists_are_read_in_the_frame_of_the_noisy_pose(tolerance: f64) {
    for (name, device) in devices() {
        let mut config = in_twist_form(small());
        config.decoder.layers = 0;
        let net = network(&config, &device, 7400).map(&mut SceneVectorsOnly { path: Vec::new() });
        let scene = example(0, &config);
        let turn = World::rigid(&mut rng(7401)).turn;
        let mut turned = scene.clone();
        for state in &mut turned.noise {
            let columns = state.columns.map(Vector3::from);
            let rotation = Matrix3::from_columns(&columns) * turn;
            state.columns = [0, 1, 2].map(|column| rotation.column(column).into_owned().into());
        }
        let say = |scene: &Scene| values(&twists(&net, std::slice::from_ref(scene), &device).twists);
        let (before, after) = (say(&scene), say(&turned));
        for (before, after) in before.chunks_exact(3).zip(after.chunks_exact(3)) {
            let expected = turn.transpose() * Vector3::from_row_slice(before);
            assert!(expected.norm() > 1e-3, "the velocities are not trivial");
            let error = (expected - Vector3::from_row_slice(after)).norm();
            assert_small(&format!("{name} the same velocity in a turned frame"), error, tolerance);
        }
    }
}

/// Sets to zero what scalars add to the twists and what the tokens' own vectors do.
struct SceneVectorsOnly {
    path: Vec<String>,
}

impl ModuleMapper for SceneVectorsOnly {
    fn enter_module(&mut self, name: &str, _: &str) {
        self.path.push(name.to_owned());
    }

    fn exit_module(&mut self, _: &str, _: &str) {
        self.path.pop();
    }

    fn map_float<const D: usize>(&mut self, param: Param<Tensor<D>>) -> Param<Tensor<D>> {
        let silent = ["twists", "vector_input", "consensus"];
        let silenced = self.path.iter().any(|name| silent.contains(&name.as_str()));
        if silenced { param.map(|weights| weights.zeros_like()) } else { param }
    }
}

/// A random linear functional of all outputs.
pub(crate) fn twist_loss(net: &DriftNet, scenes: &[Scene], device: &Device) -> Tensor<1> {
    let prediction = twists(net, scenes, device);
    let mut rng = rng(79);
    weighed(prediction.twists.clone(), &mut rng)
        + weighed(prediction.node_twists.clone(), &mut rng)
        + weighed(prediction.openings.clone(), &mut rng)
        + weighed(prediction.weights.clone(), &mut rng)
        + weighed(prediction.spread(), &mut rng)
}

pub(crate) fn every_parameter_of_the_twist_form_receives_a_gradient() {
    for (name, device) in devices() {
        let tracked = device.clone().autodiff();
        for config in [DriftNetConfig::default(), small()].map(in_twist_form) {
            let net = drawn_net(&config, &tracked, &mut rng(7500));
            let gradients =
                twist_loss(&net, &[example(0, &config), example(1, &config)], &tracked).backward();
            for (parameter, gradient) in named_gradients(&net, &gradients) {
                let norm = gradient.iter().map(|value| value * value).sum::<f64>().sqrt();
                assert!(norm.is_finite() && norm > 1e-9, "{name} {parameter}: gradient of norm {norm:e}");
            }
        }
    }
}
