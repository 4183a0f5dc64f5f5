//! Laws of the layers on features of all degrees beyond equivariance, which [`super::laws`] asserts of every layer.

use burn::module::Module;
use burn::tensor::{Device, Tensor};
use reseflow_lie_tensor::SE3Tensor;
use reseflow_net::degrees::{EdgeFrames, EdgeProduct, PathWeight, TensorProductConvolutionConfig};
use reseflow_net::{
    EdgeList, EdgeTensors, ManiLossConfig, ManiNodes, Nonlinearity, SE3ManiNet, SE3ManiNetConfig,
};
use serde_json::Value;

use super::degree_layers::{RADIAL_MLP, centre_edges, convolved, mani_net, uniform};
use super::fibers::{HostFiber, fiber_deviation};
use super::gradients::{named_gradients, weighed};
use super::layers::{GRAPH, RADIAL, SHAKE, clouds};
use super::mani_net::{features_on_host, homes, nodes, poses_on_host, small_mani_net};
use super::scene::Cloud;
use super::weights::shaken;
use super::world::World;
use super::{assert_caught, assert_small, devices, rng, tensor, values, worse};

pub(crate) const NONLINEARITIES: [Nonlinearity; 2] = [Nonlinearity::Norm, Nonlinearity::Gated];

pub(crate) fn the_product_in_the_edges_frame_is_the_sum_over_paths(tolerance: f64) {
    for (name, device) in devices() {
        for (input, output) in [(0, 3), (1, 1), (2, 2), (3, 3), (4, 4), (1, 4), (3, 0), (4, 2)] {
            let mut rng = rng(9000 + 10 * input as u64 + output as u64);
            let fibers = (uniform(input, 3), uniform(output, 2));
            let config =
                TensorProductConvolutionConfig { input: fibers.0, output: fibers.1, radial: RADIAL_MLP };
            let layer = shaken(config.init(&device, &mut rng), SHAKE, &mut rng);
            let lists = centre_edges(&clouds(&mut rng), &World::identity());
            let features = HostFiber::random(2 * GRAPH.centres, &fibers.0.fiber(), &mut rng);
            let [reduced, plain] =
                [false, true].map(|by_paths| convolved(&layer, fibers, by_paths, &features, &lists, &device));
            assert!(plain.size() > 0.1, "the output is not trivial");
            let error = reduced.difference(&plain) / plain.size().max(1.0);
            assert_small(&format!("{name} 0–{input} to 0–{output}, two forms"), error, tolerance);
        }
    }
}

fn numbers(value: &Value) -> Vec<f64> {
    let array = value.as_array().expect("an array");
    array.iter().map(|number| number.as_f64().expect("a number")).collect()
}

/// One edge, one source, one receiver, and the weights that `scripts/irreps_golden.py` drew.
pub(crate) fn the_product_is_that_of_e3nn(tolerance: f64) {
    let golden: Value =
        serde_json::from_str(include_str!("../golden/convolution.json")).expect("the file is JSON");
    let entries = golden.as_array().expect("a list");
    assert!(entries.len() >= 4);
    for (name, device) in devices() {
        for entry in entries {
            let sizes: Vec<usize> = numbers(&entry["sizes"]).into_iter().map(|size| size as usize).collect();
            let (input, output) = (uniform(sizes[0], sizes[1]), uniform(sizes[2], sizes[3]));
            let product = EdgeProduct { input, outputs: vec![output] };
            let path_weight = |weight: &PathWeight| {
                let PathWeight { path, channel_in, channel_out } = *weight;
                let wanted = [path.degree_in, path.degree_edge, path.degree_out].map(|degree| degree as f64);
                let all = entry["weights"].as_array().expect("a list");
                let found = all.iter().find(|weights| numbers(&weights["path"]) == wanted);
                numbers(&found.expect("e3nn has this path")["values"])
                    [channel_in * output.channels + channel_out]
            };
            let weights = product.kernel_weights(path_weight);
            let weights = product.split(&tensor(weights.clone(), [1, weights.len()], &device));

            let direction = numbers(&entry["direction"]);
            let list = EdgeList {
                per_receiver: 1,
                sources: vec![0],
                displacement_m: vec![[0, 1, 2].map(|axis| 0.1 * direction[axis])],
                weights: vec![1.0],
            };
            let edges = EdgeTensors::collate([(&list, 1)], &RADIAL, &device).expect("the list is sound");
            let max_degree = input.max_degree.max(output.max_degree);
            let frames = EdgeFrames::new(edges, list.displacement_m.iter(), max_degree, &device)
                .expect("there is one displacement");
            let degrees = |key: &str| -> Vec<Vec<f64>> {
                entry[key].as_array().expect("a list").iter().map(numbers).collect()
            };
            let features = HostFiber { points: 1, degrees: degrees("features") }.tensors(&device);
            let message = product.forward(frames.at_sources(&features, input.max_degree), weights).remove(0);
            let found = HostFiber::of(&frames.sum_at_receivers(message, output.max_degree));
            let expected = HostFiber { points: 1, degrees: degrees("output") };
            let error = found.difference(&expected) / expected.size().max(1.0);
            assert_small(&format!("{name} {sizes:?} against e3nn"), error, tolerance);
        }
    }
}

/// A convolution whose features are also told, in degree 2, which way the world's axes point.
pub(crate) fn a_world_constant_in_a_higher_degree_is_caught(tolerance: f64) {
    let worlds = [World::rigid(&mut rng(4))];
    for (name, device) in devices() {
        let deviation = |constant: f64| {
            let mut rng = rng(310);
            let fibers = (uniform(2, 3), uniform(2, 3));
            let config =
                TensorProductConvolutionConfig { input: fibers.0, output: fibers.1, radial: RADIAL_MLP };
            let (clouds, layer) = (clouds(&mut rng), config.init(&device, &mut rng));
            let input = HostFiber::random(2 * GRAPH.centres, &fibers.0.fiber(), &mut rng);
            fiber_deviation(&worlds, |world| {
                let mut input = input.moved(world);
                for first_channel in input.degrees[2][..2 * GRAPH.centres * 3].chunks_exact_mut(3) {
                    first_channel[0] += constant;
                }
                convolved(&layer, fibers, false, &input, &centre_edges(&clouds, world), &device)
            })
        };
        assert_small(&format!("{name} convolution without a constant"), deviation(0.0), tolerance);
        assert_caught(&format!("{name} convolution with a world constant"), deviation(0.1), 1e-3);
    }
}

/// Apart from the features, and for more networks, because orthonormalising two nearly parallel columns amplifies rounding: among
/// hundreds of nodes none may have such.
pub(crate) fn poses_of_nodes_turn_with_the_world(tolerance: f64) {
    let mut worlds_rng = rng(5);
    let worlds: Vec<_> = (0..3).map(|_| World::rigid(&mut worlds_rng)).collect();
    let mirrors = [World::reflection(&mut worlds_rng)];
    for (name, device) in devices() {
        for nonlinearity in NONLINEARITIES {
            let deviation = |worlds: &[World], stream: u64| {
                mani_net(nonlinearity, poses_on_host, &device, worlds, &mut rng(9400 + stream))
            };
            let worst = (0..20).map(|stream| deviation(&worlds, stream)).fold(0.0, worse);
            assert_small(&format!("{name} SE3ManiNet, {nonlinearity:?}, poses"), worst, tolerance);
            let mirrored = deviation(&mirrors, 0);
            assert_caught(&format!("{name} mirrored SE3ManiNet, {nonlinearity:?}, poses"), mirrored, 1e-3);
        }
    }
}

/// The network and its clouds, from one stream.
pub(crate) fn example(config: &SE3ManiNetConfig, device: &Device, stream: u64) -> (SE3ManiNet, Vec<Cloud>) {
    let mut rng = rng(stream);
    let net = config.init(device, &mut rng).expect("the sizes make sense");
    (shaken(net, 0.05, &mut rng), [40, 7, 25].map(|count| Cloud::in_a_box(count, &mut rng)).to_vec())
}

pub(crate) fn nodes_see_neither_the_order_of_points_nor_other_scenes(tolerance: f64) {
    for (name, device) in devices() {
        let (mut shuffled_error, mut alone_error, mut other) = (0.0, 0.0, f64::INFINITY);
        for (stream, nonlinearity) in (9100..9106).zip(NONLINEARITIES.into_iter().cycle()) {
            let (net, clouds) = example(&small_mani_net(nonlinearity), &device, stream);
            let say = |clouds: &[Cloud]| {
                let grippers = vec![homes(1).remove(0); clouds.len()];
                nodes(&net, clouds, &grippers, &World::identity(), &device)
            };
            let together = say(&clouds);
            let shuffled: Vec<_> = clouds.iter().map(|cloud| cloud.shuffled(&mut rng(stream))).collect();
            let shuffled = say(&shuffled);
            for part in [features_on_host, poses_on_host] {
                shuffled_error = worse(shuffled_error, part(&together).difference(&part(&shuffled)));
            }
            let scene = |nodes: &ManiNodes, index: usize| {
                let rows = |degree: &Tensor<3>| degree.clone().narrow(1, index * 3, 3);
                let rotations = nodes.rotations.clone().swap_dims(0, 1);
                let all = nodes.features.degrees.iter().chain([&rotations]);
                let degrees = all.map(|degree| values(&rows(degree)));
                HostFiber { points: 3, degrees: degrees.collect() }
            };
            for (index, cloud) in clouds.iter().enumerate() {
                let alone = scene(&say(std::slice::from_ref(cloud)), 0);
                alone_error = worse(alone_error, alone.difference(&scene(&together, index)));
                other = other.min(alone.difference(&scene(&together, (index + 1) % 3)));
            }
        }
        assert_small(&format!("{name} SE3ManiNet, shuffled clouds"), shuffled_error, tolerance);
        assert_small(&format!("{name} SE3ManiNet, in a batch and alone"), alone_error, tolerance);
        assert_caught(&format!("{name} SE3ManiNet, another scene"), other, 1e-3);
    }
}

/// A random linear functional of everything that the network says.
pub(crate) fn mani_net_loss(net: &SE3ManiNet, clouds: &[Cloud], device: &Device) -> Tensor<1> {
    let nodes = nodes(net, clouds, &homes(clouds.len()), &World::identity(), device);
    let mut rng = rng(78);
    let features = nodes.features.degrees.iter().map(|degree| weighed(degree.clone(), &mut rng));
    let features = features.reduce(|a, b| a + b).expect("there are scalars");
    let home = SE3Tensor {
        rotation: Tensor::<2>::eye(3, device).unsqueeze_dim::<3>(0).repeat_dim(0, clouds.len()),
        translation: Tensor::zeros([clouds.len(), 3], device),
    };
    features
        + nodes.loss(&home, &ManiLossConfig::default())
        + weighed(nodes.rotations.clone(), &mut rng)
        + weighed(nodes.translations_m.clone(), &mut rng)
        + weighed(nodes.consensus_rotations.clone(), &mut rng)
        + weighed(nodes.consensus_positions_m.clone(), &mut rng)
        + weighed(nodes.spread(), &mut rng)
        + weighed(nodes.heat.clone(), &mut rng)
        + nodes.overlap()
}

pub(crate) fn every_parameter_of_mani_net_receives_a_gradient() {
    for (name, device) in devices() {
        let tracked = device.clone().autodiff();
        let default = SE3ManiNetConfig::default();
        for config in [small_mani_net(Nonlinearity::Norm), small_mani_net(Nonlinearity::Gated), default] {
            let net = config.init(&tracked, &mut rng(9300)).expect("the sizes make sense");
            let (_, clouds) = example(&config, &device, 9301);
            let gradients = mani_net_loss(&net, &clouds, &tracked).backward();
            let gradients = named_gradients(&net, &gradients);
            let count: usize = gradients.iter().map(|(_, gradient)| gradient.len()).sum();
            assert_eq!(count, net.num_params());
            for (parameter, gradient) in gradients {
                let norm = gradient.iter().map(|value| value * value).sum::<f64>().sqrt();
                assert!(norm.is_finite() && norm > 1e-9, "{name} {parameter}: gradient of norm {norm:e}");
            }
        }
    }
}
