//! Clouds without extent, without a plane, with ties everywhere, with very few or very many points, or far away: finite outputs and
//! gradients all the same.

use std::f64::consts::TAU;

use reseflow_lie::{Matrix3, SO3, Vector3};
use reseflow_net::SE3TransformerConfig;

use super::degree_laws::{NONLINEARITIES, example as mani_net_example, mani_net_loss};
use super::degree_layers::{frames, uniform};
use super::fibers::HostFiber;
use super::gradients::{generic_loss, named_gradients, weighed};
use super::laws::example;
use super::layers::{GRAPH, RADIAL};
use super::mani_net::{features_on_host, homes, nodes, poses_on_host, small_mani_net};
use super::scene::{Cloud, Scene, random_colors};
use super::trajectory::{Deviation, predict_one};
use super::weights::{shaken, shaken_net};
use super::world::World;
use super::{assert_small, devices, of_degree, rng, small, values, worse};

/// How far a faraway cloud is along each axis, metres.
const FAR_M: f64 = 10.0;

pub(crate) fn degenerate_clouds() -> Vec<(&'static str, Vec<[f64; 3]>)> {
    let grid = (0..36).map(|index| [0.05 * f64::from(index % 6), 0.05 * f64::from(index / 6), 0.4]);
    let corner = |bits: u32| [0, 1, 2].map(|axis| if bits >> axis & 1 == 0 { -0.1 } else { 0.1 });
    let ring = |index: u32| {
        let angle = TAU * f64::from(index % 12) / 12.0;
        [0.1 * angle.cos(), 0.1 * angle.sin(), if index < 12 { 0.0 } else { 0.05 }]
    };
    let tilted = SO3::exp(&Vector3::new(0.4, -0.9, 0.3));
    let on_a_plane = Cloud::in_a_box(50, &mut rng(6100)).points.into_iter();
    let on_a_plane = on_a_plane.map(|[x, y, _]| tilted.act(&Vector3::new(x, y, 0.0)).into());
    let far = Cloud::in_a_box(60, &mut rng(6101)).points.into_iter();
    vec![
        ("one point", vec![[0.3, -0.2, 0.5]]),
        ("one point at the origin", vec![[0.0; 3]]),
        ("two points", vec![[0.1, 0.0, 0.0], [0.0, 0.1, 0.0]]),
        ("thirty coincident points", vec![[0.7, 0.1, 0.3]; 30]),
        ("a line", (0..30).map(|index| [0.01 * f64::from(index), 0.02 * f64::from(index), 0.1]).collect()),
        ("five points", (0..5).map(|i| [0.1 * f64::from(i), f64::from(i * i) * 0.03, 0.2]).collect()),
        ("a regular grid", grid.collect()),
        ("a tilted plane", on_a_plane.collect()),
        ("the corners of a cube", (0..8).map(corner).collect()),
        ("two rings of twelve", (0..24).map(ring).collect()),
        ("two heaps", [vec![[0.0; 3]; 20], vec![[0.2, 0.0, 0.0]; 20]].concat()),
        ("4096 points", Cloud::in_a_box(4096, &mut rng(6102)).points),
        ("points ten metres away", far.map(|point| point.map(|value| value + FAR_M)).collect()),
    ]
}

pub(crate) fn degenerate_clouds_give_finite_trajectories_and_gradients() {
    for (name, device) in devices() {
        let tracked = device.clone().autodiff();
        for (what, points) in degenerate_clouds() {
            let mut rng = rng(6000);
            let config = of_degree(1 + points.len() % 3, small());
            let net = shaken_net(&config, &tracked, &mut rng);
            let colors = random_colors(points.len(), &mut rng);
            let clouds = vec![Cloud { points, colors }; config.decoder.frames];
            let scenes = [Scene::around(clouds, config.decoder.horizon, &mut rng)];
            let trajectory = predict_one(&net, &scenes[0], &tracked);
            for (rotation, position_m) in trajectory.consensus.iter().chain(&trajectory.nodes) {
                assert!(position_m.iter().all(|value| value.is_finite()), "{name} {what}: {position_m}");
                let error = rotation.transpose() * rotation - Matrix3::identity();
                assert!(error.norm() < 1e-4, "{name} {what}: not a rotation: {rotation}");
            }
            assert!(trajectory.scalars.iter().all(|value| value.is_finite()), "{name} {what}");
            let gradients = generic_loss(&net, &scenes, &tracked).backward();
            for (parameter, gradient) in named_gradients(&net, &gradients) {
                assert!(!gradient.is_empty(), "{name} {what}: no gradient for {parameter}");
                assert!(gradient.iter().all(|value| value.is_finite()), "{name} {what}: {parameter}");
            }
        }
    }
}

pub(crate) fn degenerate_clouds_give_finite_nodes_and_gradients() {
    for (name, device) in devices() {
        let tracked = device.clone().autodiff();
        for nonlinearity in NONLINEARITIES {
            for (what, points) in degenerate_clouds() {
                let (net, _) = mani_net_example(&small_mani_net(nonlinearity), &tracked, 9200);
                let colors = random_colors(points.len(), &mut rng(9201));
                let clouds = [Cloud { points, colors }];
                let nodes = nodes(&net, &clouds, &homes(1), &World::identity(), &tracked);
                for part in [features_on_host, poses_on_host] {
                    assert!(part(&nodes).size().is_finite(), "{name} {what}");
                }
                let gram = values(&nodes.rotations.clone().swap_dims(1, 2).matmul(nodes.rotations));
                let identity = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
                let error =
                    gram.iter().zip(identity.iter().cycle()).map(|(a, b)| (a - b).abs()).fold(0.0, worse);
                assert!(error < 1e-4, "{name} {what}: not rotations");
                let gradients = mani_net_loss(&net, &clouds, &tracked).backward();
                for (parameter, gradient) in named_gradients(&net, &gradients) {
                    assert!(!gradient.is_empty(), "{name} {what}: no gradient for {parameter}");
                    assert!(gradient.iter().all(|value| value.is_finite()), "{name} {what}: {parameter}");
                }
            }
        }
    }
}

/// Degrees 0–3 over the points themselves, with either non-linearity.
pub(crate) fn degenerate_clouds_give_a_finite_transformer() {
    for (name, device) in devices() {
        let tracked = device.clone().autodiff();
        for nonlinearity in NONLINEARITIES {
            let config = SE3TransformerConfig {
                input: uniform(1, 3),
                channels: 4,
                output: uniform(2, 3),
                layers: 2,
                nonlinearity,
                radial: RADIAL.count,
                radial_hidden: 8,
                ..SE3TransformerConfig::default()
            };
            for (what, points) in degenerate_clouds() {
                let mut rng = rng(6200);
                let net = config.init(&tracked, &mut rng).expect("the sizes make sense");
                let net = shaken(net, 0.05, &mut rng);
                let colors = random_colors(points.len(), &mut rng);
                let edges = [Cloud { points, colors }.graph(&GRAPH).centre_edges];
                let input = HostFiber::random(GRAPH.centres, &config.input.fiber(), &mut rng);
                let output =
                    net.forward(input.tensors(&tracked), &frames(&edges, config.max_degree, &tracked));
                assert!(HostFiber::of(&output).size().is_finite(), "{name} {what}");
                let parts = output.degrees.into_iter().map(|degree| weighed(degree, &mut rng));
                let loss = parts.reduce(|a, b| a + b).expect("there are scalars");
                for (parameter, gradient) in named_gradients(&net, &loss.backward()) {
                    assert!(!gradient.is_empty(), "{name} {what}: no gradient for {parameter}");
                    assert!(gradient.iter().all(|value| value.is_finite()), "{name} {what}: {parameter}");
                }
            }
        }
    }
}

/// Clouds 3 m wide, turned and moved by ten metres along each axis; positions relative to that width. Rotations are read from sums of
/// unit vectors and of offsets over 0.1 m, whose rounding grows with the width: they may be off by as many times more as these clouds
/// are wider than those of the other laws (measured in f32: 2e-6). A node whose columns are short has its rounding raised as they are
/// normalised (measured in f32: 8e-5 where one is 0.07 long, most are 0.9; error times length stays below 1e-5): in one scene of
/// the twenty a node may be off five times as far.
pub(crate) fn a_wide_scene_far_away_gives_a_moved_trajectory(tolerance: f64) {
    const WIDTH_M: f64 = 3.0;
    const WIDENED: f64 = WIDTH_M / 0.5;
    for (name, device) in devices() {
        let (mut worst, mut node_rotations) = (Deviation::default(), Vec::new());
        for index in 0..20 {
            let config = small();
            let mut rng = rng(6400 + index);
            let net = shaken_net(&config, &device, &mut rng);
            let mut scene = Scene::in_a_box(100, &config.decoder, &mut rng);
            for point in scene.clouds.iter_mut().flat_map(|cloud| &mut cloud.points) {
                *point = point.map(|value| value * WIDENED);
            }
            let world = World { turn: SO3::sample_haar(&mut rng).matrix(), shift: Vector3::repeat(FAR_M) };
            let still = predict_one(&net, &scene, &device);
            let found = still.deviation(&predict_one(&net, &scene.moved(&world), &device), &world);
            node_rotations.push(found.node_rotation);
            worst = worst.worse(found);
        }
        node_rotations.sort_by(f64::total_cmp);
        let second = node_rotations[node_rotations.len() - 2];
        for (part, error, allowed) in [
            ("positions", worst.position_m / WIDTH_M, tolerance),
            ("openings and weights", worst.scalar, tolerance),
            ("nodes' positions", worst.node_position_m / WIDTH_M, tolerance),
            ("rotations", worst.rotation, WIDENED * tolerance),
            ("nodes' rotations, the worst scene", worst.node_rotation, 5.0 * WIDENED * tolerance),
            ("nodes' rotations, the others", second, WIDENED * tolerance),
        ] {
            assert_small(&format!("{name} 3 m wide and 10 m away, {part}"), error, allowed);
        }
    }
}

/// A scene and the same ten metres further along each axis, with coordinates as the suite's float type has them.
pub(crate) fn a_scene_ten_metres_away_gives_the_same_trajectory(tolerance: f64) {
    let world = World { turn: Matrix3::identity(), shift: Vector3::repeat(FAR_M) };
    let store = |scene: Scene| {
        let round = |value: f64| {
            if crate::FLOAT == burn::tensor::FloatDType::F32 { f64::from(value as f32) } else { value }
        };
        let cloud = |cloud: &Cloud| Cloud {
            points: cloud.points.iter().map(|point| point.map(round)).collect(),
            colors: cloud.colors.clone(),
        };
        Scene { clouds: scene.clouds.iter().map(cloud).collect(), ..scene }
    };
    for (name, device) in devices() {
        let mut worst = 0.0;
        for index in 0..10 {
            let config = small();
            let mut rng = rng(6300 + index);
            let net = shaken_net(&config, &device, &mut rng);
            let scene = example(index, &config);
            let near = predict_one(&net, &store(scene.clone()), &device);
            let far = predict_one(&net, &store(scene.moved(&world)), &device);
            worst = worse(worst, near.deviation(&far, &world).largest());
        }
        assert_small(&format!("{name} ten metres away"), worst, tolerance);
    }
}
