//! The laws that both suites assert, each in its float type and on every device.

use burn::module::Module;
use reseflow_net::DriftNetConfig;

use super::gradients::{generic_loss, named_gradients};
use super::layers::{interaction_with_world_constant, layer_deviations};
use super::plain::plain;
use super::scene::{Cloud, Scene};
use super::trajectory::{Deviation, encode, predict, predict_one};
use super::weights::{drawn_net, shaken_net};
use super::world::World;
use super::{assert_caught, assert_small, devices, of_degree, rng, small, values, worse, worst_difference};

/// How far off a control must be to count as caught.
const CAUGHT: f64 = 1e-3;

pub(crate) fn every_layer_turns_with_the_world(tolerance: f64) {
    let mut worlds_rng = rng(1);
    let worlds: Vec<_> = (0..3).map(|_| World::rigid(&mut worlds_rng)).collect();
    for (name, device) in devices() {
        let mut worst: Vec<(&str, f64)> = Vec::new();
        for stream in 0..10 {
            let deviations = layer_deviations(&device, &worlds, 100 + stream);
            worst.resize(deviations.len(), ("", 0.0));
            for (worst, found) in worst.iter_mut().zip(deviations) {
                *worst = (found.layer, worse(worst.1, found.deviation));
            }
        }
        for (layer, deviation) in worst {
            assert_small(&format!("{name} {layer}"), deviation, tolerance);
        }
    }
}

/// Only what contains a cross product sees handedness; the rest commutes with reflections too.
pub(crate) fn handed_layers_tell_a_scene_from_its_mirror_image(tolerance: f64) {
    let worlds = [World::reflection(&mut rng(2))];
    for (name, device) in devices() {
        for found in layer_deviations(&device, &worlds, 200) {
            let what = format!("{name} mirrored {}", found.layer);
            if found.handed {
                assert_caught(&what, found.deviation, CAUGHT);
            } else {
                assert_small(&what, found.deviation, tolerance);
            }
        }
    }
}

pub(crate) fn a_world_constant_in_a_vector_channel_is_caught(tolerance: f64) {
    let worlds = [World::rigid(&mut rng(3))];
    for (name, device) in devices() {
        let deviation = |constant| interaction_with_world_constant(&device, &worlds, constant, 300);
        assert_small(&format!("{name} interaction without a constant"), deviation(0.0), tolerance);
        assert_caught(&format!("{name} interaction with a world constant"), deviation(0.02), CAUGHT);
    }
}

/// Scene `index`: every other one on a table with its centroid 1 m away, the others in a box.
pub(crate) fn example(index: u64, config: &DriftNetConfig) -> Scene {
    let mut rng = rng(1000 + index);
    match index % 2 {
        0 => Scene::in_a_box(100, &config.decoder, &mut rng),
        _ => Scene::on_a_table(&config.decoder, &mut rng),
    }
}

/// The worst deviation over `scenes` scenes, each with weights and a world of its own; `store` is what becomes of a scene on
/// its way to the network.
pub(crate) fn net_deviation(
    device: &burn::tensor::Device,
    config: &DriftNetConfig,
    scenes: u64,
    store: impl Fn(Scene) -> Scene,
) -> Deviation {
    let mut worst = Deviation::default();
    for index in 0..scenes {
        let mut rng = rng(2000 + index);
        let net = shaken_net(config, device, &mut rng);
        let (scene, world) = (example(index, config), World::rigid(&mut rng));
        let still = predict_one(&net, &store(scene.clone()), device);
        let moved = predict_one(&net, &store(scene.moved(&world)), device);
        worst = worst.worse(still.deviation(&moved, &world));
    }
    worst
}

/// Higher degrees are made in the first layer, go through two, and are used up in the last.
fn deep() -> DriftNetConfig {
    let mut config = small();
    config.encoder.layers = 4;
    config
}

/// Default and small sizes; scenes, weights and worlds differ each time.
pub(crate) fn a_moved_scene_gives_a_moved_trajectory(tolerance: f64) {
    for (name, device) in devices() {
        for (net, config, scenes) in [
            ("default", DriftNetConfig::default(), 24),
            ("small", small(), 40),
            ("default 0–2", of_degree(2, DriftNetConfig::default()), 4),
            ("default 0–3", of_degree(3, DriftNetConfig::default()), 4),
            ("small 0–2", of_degree(2, small()), 20),
            ("small 0–3", of_degree(3, small()), 20),
            ("small 0–3 in four layers", of_degree(3, deep()), 6),
        ] {
            let worst = net_deviation(&device, &config, scenes, |scene| scene);
            let what = |part: &str| format!("{name} {net} net, {part}");
            assert_small(&what("positions, m"), worst.position_m, tolerance);
            assert_small(&what("rotations"), worst.rotation, tolerance);
            assert_small(&what("openings and weights"), worst.scalar, tolerance);
            assert_small(&what("nodes' positions, m"), worst.node_position_m, tolerance);
            assert_small(&what("nodes' rotations"), worst.node_rotation, tolerance);
        }
    }
}

/// The checker of the law above must fail where something is mirrored, or where a part of the scene stays behind.
pub(crate) fn a_scene_that_is_not_moved_rigidly_is_caught() {
    for (name, device) in devices() {
        for index in 0..6 {
            let mut rng = rng(3000 + index);
            let config = if index < 3 { small() } else { of_degree(index as usize / 2 + 1, small()) };
            let net = shaken_net(&config, &device, &mut rng);
            let scene = example(index, &config);
            let still = predict_one(&net, &scene, &device);
            let caught = |what: &str, presented: Scene, world: &World| {
                let found = still.deviation(&predict_one(&net, &presented, &device), world);
                assert_caught(&format!("{name} {what}, positions"), found.position_m, CAUGHT);
                assert_caught(&format!("{name} {what}, rotations"), found.rotation, CAUGHT);
            };
            let mirror = World::reflection(&mut rng);
            caught("a mirrored scene", scene.moved(&mirror), &mirror);
            let world = World::rigid(&mut rng);
            let moved = scene.moved(&world);
            let parts = |clouds: &Scene, grippers: &Scene, noise: &Scene| Scene {
                clouds: clouds.clouds.clone(),
                grippers: grippers.grippers.clone(),
                noise: noise.noise.clone(),
                ..scene.clone()
            };
            caught("a cloud left behind", parts(&scene, &moved, &moved), &world);
            caught("a gripper left behind", parts(&moved, &scene, &moved), &world);
            caught("noise left behind", parts(&moved, &moved, &scene), &world);
            let mut first_frame_left_behind = moved.clone();
            first_frame_left_behind.clouds[0] = scene.clouds[0].clone();
            caught("an earlier frame left behind", first_frame_left_behind, &world);
        }
    }
}

pub(crate) fn the_order_of_the_points_does_not_matter(tolerance: f64) {
    for (name, device) in devices() {
        let (mut nodes, mut trajectories) = (0.0, 0.0);
        for index in 0..10 {
            let mut rng = rng(4000 + index);
            let config = of_degree(1 + index as usize % 3, small());
            let net = shaken_net(&config, &device, &mut rng);
            let scene = example(index, &config);
            let shuffled = Scene {
                clouds: scene.clouds.iter().map(|cloud| cloud.shuffled(&mut rng)).collect(),
                ..scene.clone()
            };
            for (cloud, other) in scene.clouds.iter().zip(&shuffled.clouds) {
                let centres = |cloud: &Cloud| -> Vec<[f64; 3]> {
                    let chosen = cloud.graph(&config.encoder.graph).centres;
                    chosen.iter().map(|&centre| cloud.points[centre]).collect()
                };
                assert_eq!(centres(cloud), centres(other), "centres come in the same order");
                assert_ne!(cloud.points, other.points);
            }
            let encoded = |scene: &Scene| encode(&net, std::slice::from_ref(scene), &device);
            for (still, other) in encoded(&scene).iter().zip(&encoded(&shuffled)) {
                for (a, b) in [
                    (values(&still.positions), values(&other.positions)),
                    (values(&still.nodes.scalars), values(&other.nodes.scalars)),
                    (values(&still.nodes.vectors), values(&other.nodes.vectors)),
                    (values(&still.heat), values(&other.heat)),
                ] {
                    nodes = worse(nodes, worst_difference(&a, &b));
                }
            }
            let [still, other] = [&scene, &shuffled].map(|scene| predict_one(&net, scene, &device));
            trajectories = worse(trajectories, still.deviation(&other, &World::identity()).largest());
        }
        assert_small(&format!("{name} nodes of a shuffled cloud"), nodes, tolerance);
        assert_small(&format!("{name} trajectories of a shuffled cloud"), trajectories, tolerance);
    }
}

pub(crate) fn scenes_of_one_batch_do_not_see_each_other(tolerance: f64) {
    for (name, device) in devices() {
        let mut rng = rng(5000);
        let config = of_degree(3, small());
        let net = shaken_net(&config, &device, &mut rng);
        let scenes: Vec<_> =
            [40, 100, 7, 1, 64].map(|count| Scene::in_a_box(count, &config.decoder, &mut rng)).to_vec();
        let together = predict(&net, &scenes, &device);
        for (scene, together) in scenes.iter().zip(&together) {
            let alone = predict_one(&net, scene, &device);
            let found = alone.deviation(together, &World::identity()).largest();
            let what = format!("{name} {} points, in a batch and alone", scene.clouds[0].points.len());
            assert_small(&what, found, tolerance);
        }
        let other = together[0].deviation(&together[1], &World::identity()).largest();
        assert_caught(&format!("{name} another scene's trajectory"), other, CAUGHT);
    }
}

/// The grasp says something to networks that are told of it, and nothing to others.
pub(crate) fn the_grasp_is_told_to_those_who_ask() {
    for (name, device) in devices() {
        for grasp_memory in [true, false] {
            let mut config = small();
            config.decoder.grasp_memory = grasp_memory;
            let net = shaken_net(&config, &device, &mut rng(5100));
            let (scene, other) = (example(0, &config), example(1, &config));
            let elsewhere = Scene { grasp: other.grasp, ..scene.clone() };
            let [still, other] = [&scene, &elsewhere].map(|scene| predict_one(&net, scene, &device));
            let found = still.deviation(&other, &World::identity()).largest();
            if grasp_memory {
                assert_caught(&format!("{name} another grasp"), found, 1e-3);
            } else {
                assert_eq!(found, 0.0, "{name}: a network without memory");
            }
        }
    }
}

pub(crate) fn every_parameter_receives_a_gradient() {
    for (name, device) in devices() {
        let tracked = device.clone().autodiff();
        let sizes = [
            ("default", DriftNetConfig::default()),
            ("default 0–2", of_degree(2, DriftNetConfig::default())),
            ("default 0–3", of_degree(3, DriftNetConfig::default())),
            ("small", small()),
            ("small 0–3 in four layers", of_degree(3, deep())),
            ("small and plain", plain(small())),
        ];
        for (size, config) in sizes {
            // As drawn, without noise on the biases: training must be able to start from there.
            let net = drawn_net(&config, &tracked, &mut rng(7000));
            let scenes = [example(0, &config), example(1, &config)];
            let gradients = generic_loss(&net, &scenes, &tracked).backward();
            let gradients = named_gradients(&net, &gradients);
            let count: usize = gradients.iter().map(|(_, gradient)| gradient.len()).sum();
            assert_eq!(count, net.num_params());
            for (parameter, gradient) in gradients {
                let norm = gradient.iter().map(|value| value * value).sum::<f64>().sqrt();
                assert!(
                    norm.is_finite() && norm > 1e-9,
                    "{name} {size} {parameter}: gradient of norm {norm:e}"
                );
            }
        }
    }
}

pub(crate) fn the_suite_runs_in_its_float_type() {
    for (name, device) in devices() {
        for device in [device.clone(), device.autodiff()] {
            let net = drawn_net(&small(), &device, &mut rng(8000));
            let encoded = encode(&net, &[example(0, &small())], &device);
            assert_eq!(encoded[0].positions.dtype(), crate::FLOAT.into(), "{name}");
        }
    }
}
