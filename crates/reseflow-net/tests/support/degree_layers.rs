//! How far every layer on features of all degrees is from commuting with a change of world frame.

use burn::tensor::Device;
use rand_chacha::ChaCha8Rng;
use reseflow_net::degrees::{
    EdgeFrames, EdgeHarmonics, Fiber, FiberHeatMap, FiberHeatMapConfig, FiberLayerNormConfig,
    FiberLinearConfig, GatedNonlinearityConfig, NeighborAttentionConfig, NormNonlinearityConfig,
    RadialMlpConfig, TensorProductConvolution, TensorProductConvolutionConfig, UniformFiber,
};
use reseflow_net::{EdgeList, EdgeTensors, ManiNodes, Nonlinearity, SE3TransformerConfig};

use super::fibers::{HostFiber, fiber_deviation};
use super::layers::{GRAPH, LayerDeviation, RADIAL, SHAKE, clouds};
use super::mani_net::{features_on_host, homes, nodes, small_mani_net};
use super::scene::Cloud;
use super::weights::shaken;
use super::world::World;
use super::{rng, values};

pub(crate) const RADIAL_MLP: RadialMlpConfig = RadialMlpConfig { radial: RADIAL.count, hidden: 8 };

pub(crate) const fn uniform(max_degree: usize, channels: usize) -> UniformFiber {
    UniformFiber { max_degree, channels }
}

/// Every public layer with weights, inputs and a cloud drawn from `stream`.
pub(crate) fn degree_layer_deviations(device: &Device, worlds: &[World], stream: u64) -> Vec<LayerDeviation> {
    let mut rng = rng(stream + 50_000);
    let rng = &mut rng;
    let entry = |layer, deviation, handed| LayerDeviation { layer, deviation, handed };
    let from_scalars = (uniform(0, 5), uniform(3, 2));
    let mixed = (uniform(2, 3), uniform(3, 2));
    let narrowing = (uniform(3, 2), uniform(1, 3));
    vec![
        entry("0–3 linear", linear(device, worlds, rng), false),
        entry("0→0–3 convolution", convolution(from_scalars, false, device, worlds, rng), false),
        entry("0–2→0–3 convolution", convolution(mixed, false, device, worlds, rng), true),
        entry("0–3→0–1 convolution", convolution(narrowing, false, device, worlds, rng), true),
        entry("0–2→0–3 convolution by paths", convolution(mixed, true, device, worlds, rng), true),
        entry("0→0–3 attention", attention((uniform(0, 5), uniform(3, 2)), device, worlds, rng), false),
        entry("0–3 attention", attention((uniform(3, 3), uniform(3, 4)), device, worlds, rng), true),
        entry("0–3 norm non-linearity", norm(device, worlds, rng), false),
        entry("0–3 gated non-linearity", gated(device, worlds, rng), false),
        entry("0–3 layer normalisation", layer_norm(device, worlds, rng), false),
        entry("0–3 heat map", heat_map(device, worlds, rng), false),
        entry("SE3Transformer, norms", transformer(Nonlinearity::Norm, device, worlds, rng), true),
        entry("SE3Transformer, gates", transformer(Nonlinearity::Gated, device, worlds, rng), true),
        entry("SE3ManiNet, norms", mani_net(Nonlinearity::Norm, features_on_host, device, worlds, rng), true),
        entry(
            "SE3ManiNet, gates",
            mani_net(Nonlinearity::Gated, features_on_host, device, worlds, rng),
            true,
        ),
    ]
}

/// The edges among the centres of some clouds, moved by `world`.
pub(crate) fn centre_edges(clouds: &[Cloud], world: &World) -> Vec<EdgeList> {
    clouds.iter().map(|cloud| cloud.moved(world).graph(&GRAPH).centre_edges).collect()
}

pub(crate) fn frames(lists: &[EdgeList], max_degree: usize, device: &Device) -> EdgeFrames {
    let edges = EdgeTensors::collate(lists.iter().map(|list| (list, GRAPH.centres)), &RADIAL, device);
    let displacements = lists.iter().flat_map(|list| &list.displacement_m);
    EdgeFrames::new(edges.expect("the lists are sound"), displacements, max_degree, device)
        .expect("there is one displacement for each edge")
}

/// A convolution's output over the centres of clouds.
pub(crate) fn convolved(
    layer: &TensorProductConvolution,
    (input, output): (UniformFiber, UniformFiber),
    by_paths: bool,
    features: &HostFiber,
    lists: &[EdgeList],
    device: &Device,
) -> HostFiber {
    let frames = frames(lists, input.max_degree.max(output.max_degree), device);
    let features = features.tensors(device);
    HostFiber::of(&if by_paths {
        let displacements = lists.iter().flat_map(|list| &list.displacement_m);
        let harmonics = EdgeHarmonics::new(displacements, input.max_degree + output.max_degree, device);
        layer.forward_by_paths(&features, &frames, &harmonics)
    } else {
        layer.forward(&features, &frames)
    })
}

fn several() -> Fiber {
    Fiber { channels: vec![6, 4, 1, 3] }
}

fn linear(device: &Device, worlds: &[World], rng: &mut ChaCha8Rng) -> f64 {
    let config =
        FiberLinearConfig { input: several(), output: Fiber { channels: vec![2, 5, 3] }, bias: true };
    let layer = shaken(config.init(device, rng), SHAKE, rng);
    let input = HostFiber::random(30, &several(), rng);
    fiber_deviation(worlds, |world| HostFiber::of(&layer.forward(&input.moved(world).tensors(device))))
}

fn convolution(
    fibers: (UniformFiber, UniformFiber),
    by_paths: bool,
    device: &Device,
    worlds: &[World],
    rng: &mut ChaCha8Rng,
) -> f64 {
    let config = TensorProductConvolutionConfig { input: fibers.0, output: fibers.1, radial: RADIAL_MLP };
    let (clouds, layer) = (clouds(rng), shaken(config.init(device, rng), SHAKE, rng));
    let input = HostFiber::random(2 * GRAPH.centres, &fibers.0.fiber(), rng);
    fiber_deviation(worlds, |world| {
        let lists = centre_edges(&clouds, world);
        convolved(&layer, fibers, by_paths, &input.moved(world), &lists, device)
    })
}

fn attention(
    (input, output): (UniformFiber, UniformFiber),
    device: &Device,
    worlds: &[World],
    rng: &mut ChaCha8Rng,
) -> f64 {
    let config = NeighborAttentionConfig { input, output, heads: 2, radial: RADIAL_MLP };
    let layer = |rng: &mut ChaCha8Rng| config.init(device, rng).expect("the heads divide the channels");
    let (clouds, layer) = (clouds(rng), shaken(layer(rng), SHAKE, rng));
    let features = HostFiber::random(2 * GRAPH.centres, &input.fiber(), rng);
    fiber_deviation(worlds, |world| {
        let edges = frames(&centre_edges(&clouds, world), 3, device);
        HostFiber::of(&layer.forward(&features.moved(world).tensors(device), &edges))
    })
}

fn norm(device: &Device, worlds: &[World], rng: &mut ChaCha8Rng) -> f64 {
    let layer = shaken(NormNonlinearityConfig { fiber: several() }.init(device), SHAKE, rng);
    let input = HostFiber::random(30, &several(), rng);
    fiber_deviation(worlds, |world| HostFiber::of(&layer.forward(input.moved(world).tensors(device))))
}

fn gated(device: &Device, worlds: &[World], rng: &mut ChaCha8Rng) -> f64 {
    let layer = shaken(GatedNonlinearityConfig { fiber: several() }.init(device, rng), SHAKE, rng);
    let input = HostFiber::random(30, &several(), rng);
    fiber_deviation(worlds, |world| HostFiber::of(&layer.forward(input.moved(world).tensors(device))))
}

fn layer_norm(device: &Device, worlds: &[World], rng: &mut ChaCha8Rng) -> f64 {
    let layer = shaken(FiberLayerNormConfig { fiber: several() }.init(device), SHAKE, rng);
    let input = HostFiber::random(30, &several(), rng);
    fiber_deviation(worlds, |world| HostFiber::of(&layer.forward(input.moved(world).tensors(device))))
}

/// The maps must not move at all, and what they pool must move with its inputs.
fn heat_map(device: &Device, worlds: &[World], rng: &mut ChaCha8Rng) -> f64 {
    let (scenes, rows) = (3, 3 * 11);
    let layer = FiberHeatMapConfig { fiber: several(), nodes: 4 }.init(device, rng);
    let layer = shaken(layer, SHAKE, rng);
    let input = HostFiber::random(rows, &several(), rng);
    fiber_deviation(worlds, |world| {
        let input = input.moved(world).tensors(device);
        let weights = layer.weights(scenes, &input);
        let mut output = HostFiber::of(&FiberHeatMap::pool(&weights, &input));
        output.degrees[0].extend(values(&weights));
        output
    })
}

fn transformer(nonlinearity: Nonlinearity, device: &Device, worlds: &[World], rng: &mut ChaCha8Rng) -> f64 {
    let config = SE3TransformerConfig {
        input: uniform(1, 3),
        channels: 4,
        output: uniform(2, 3),
        layers: 2,
        nonlinearity,
        radial: RADIAL.count,
        ..SE3TransformerConfig::default()
    };
    let net = config.init(device, rng).expect("the sizes make sense");
    let (clouds, net) = (clouds(rng), shaken(net, 0.05, rng));
    let features = HostFiber::random(2 * GRAPH.centres, &config.input.fiber(), rng);
    fiber_deviation(worlds, |world| {
        let edges = frames(&centre_edges(&clouds, world), config.max_degree, device);
        HostFiber::of(&net.forward(features.moved(world).tensors(device), &edges))
    })
}

/// What `part` of the nodes deviates.
pub(crate) fn mani_net(
    nonlinearity: Nonlinearity,
    part: fn(&ManiNodes) -> HostFiber,
    device: &Device,
    worlds: &[World],
    rng: &mut ChaCha8Rng,
) -> f64 {
    let net = small_mani_net(nonlinearity).init(device, rng).expect("the sizes make sense");
    let (clouds, net) = (clouds(rng), shaken(net, 0.05, rng));
    let grippers = homes(clouds.len());
    fiber_deviation(worlds, |world| part(&nodes(&net, &clouds, &grippers, world, device)))
}
