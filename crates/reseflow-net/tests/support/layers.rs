//! How far every layer is from commuting with a change of world frame, by the one check of [`deviation`].

use burn::tensor::Device;
use rand_chacha::ChaCha8Rng;
use reseflow_lie::SE3;
use reseflow_net::{
    Convolution, ConvolutionConfig, EncoderConfig, Features, GraphConfig, HeatMap, HeatMapConfig,
    InteractionConfig, InvariantAttentionConfig, PointerAttentionConfig, RadialBasis, SceneBatch,
};

use super::degree_layers::degree_layer_deviations;
use super::features::{HostFeatures, deviation};
use super::scene::{Cloud, gripper};
use super::weights::shaken;
use super::world::World;
use super::{normals, rng, tensor, values};

pub(crate) const GRAPH: GraphConfig =
    GraphConfig { centres: 12, point_neighbors: 8, centre_neighbors: 5, color_m: 0.0 };
pub(crate) const RADIAL: RadialBasis = RadialBasis { count: 6, max_m: 0.3 };
pub(crate) const CHANNELS: usize = 8;

/// Noise on every weight, so that no bias is zero.
pub(crate) const SHAKE: f64 = 0.1;

/// A layer's deviation.
pub(crate) struct LayerDeviation {
    pub(crate) layer: &'static str,
    pub(crate) deviation: f64,
    /// Whether the layer must see the difference between a scene and its mirror image.
    pub(crate) handed: bool,
}

/// Every public layer with weights, inputs and a cloud drawn from `stream`.
pub(crate) fn layer_deviations(device: &Device, worlds: &[World], stream: u64) -> Vec<LayerDeviation> {
    let mut rng = rng(stream);
    let higher = degree_layer_deviations(device, worlds, stream);
    let entry = |layer, deviation, handed| LayerDeviation { layer, deviation, handed };
    let layers = vec![
        entry("convolution of scalars", convolution_of_points(device, worlds, &mut rng), false),
        entry("convolution of scalars and vectors", convolution_of_centres(device, worlds, &mut rng), true),
        entry("interaction", interaction(device, worlds, &mut rng), true),
        entry("soft normalisation", soft_normalisation(device, worlds, &mut rng), false),
        entry("invariant attention", attention(device, worlds, &mut rng), false),
        entry("pointer attention", pointer_attention(device, worlds, &mut rng), false),
        entry("heat map", heat_map(device, worlds, &mut rng), false),
        entry("encoder", encoder(device, worlds, &mut rng), true),
    ];
    layers.into_iter().chain(higher).collect()
}

/// An interaction that is also told, by `constant` in one vector channel, which way the world's x axis points.
pub(crate) fn interaction_with_world_constant(
    device: &Device,
    worlds: &[World],
    constant: f64,
    stream: u64,
) -> f64 {
    let layer = InteractionConfig { scalars: 9, vectors: 5, hidden: 11 }.init(device, &mut rng(stream));
    let input = HostFeatures::random(30, [9, 5], &mut rng(stream + 1));
    deviation(worlds, |world| {
        let mut input = input.moved(world);
        for first_channel in input.vectors[..30 * 5].chunks_exact_mut(5) {
            first_channel[0] += constant;
        }
        HostFeatures::of(&layer.forward(input.tensors(device)))
    })
}

/// Two clouds in one batch, moved by `world`.
pub(crate) fn batch(clouds: &[Cloud], world: &World, device: &Device) -> SceneBatch {
    let graphs: Vec<_> = clouds.iter().map(|cloud| cloud.moved(world).graph(&GRAPH)).collect();
    let mut rng = rng(17);
    let grippers: Vec<_> =
        clouds.iter().map(|_| world.gripper(&gripper(&SE3::identity(), [2.0, 0.2], &mut rng))).collect();
    SceneBatch::collate(&graphs, &grippers, &RADIAL, &RADIAL, device).expect("the graphs have one size")
}

pub(crate) fn clouds(rng: &mut ChaCha8Rng) -> Vec<Cloud> {
    [40, 25].map(|count| Cloud::in_a_box(count, rng)).to_vec()
}

fn convolution(source_vectors: bool, device: &Device, rng: &mut ChaCha8Rng) -> Convolution {
    let config = ConvolutionConfig { channels: CHANNELS, radial: RADIAL.count, source_vectors };
    shaken(config.init(device, rng), SHAKE, rng)
}

fn convolution_of_points(device: &Device, worlds: &[World], rng: &mut ChaCha8Rng) -> f64 {
    let (clouds, layer) = (clouds(rng), convolution(false, device, rng));
    let points = HostFeatures::random(65, [CHANNELS, CHANNELS], rng);
    let receivers = normals(2 * GRAPH.centres * CHANNELS, rng);
    deviation(worlds, |world| {
        let edges = batch(&clouds, world, device).point_edges;
        let receivers = tensor(receivers.clone(), [2 * GRAPH.centres, CHANNELS], device);
        HostFeatures::of(&layer.forward(&points.moved(world).tensors(device), receivers, &edges))
    })
}

fn convolution_of_centres(device: &Device, worlds: &[World], rng: &mut ChaCha8Rng) -> f64 {
    let (clouds, layer) = (clouds(rng), convolution(true, device, rng));
    let centres = HostFeatures::random(2 * GRAPH.centres, [CHANNELS, CHANNELS], rng);
    deviation(worlds, |world| {
        let edges = batch(&clouds, world, device).centre_edges;
        let centres = centres.moved(world).tensors(device);
        HostFeatures::of(&layer.forward(&centres, centres.scalars.clone(), &edges))
    })
}

fn interaction(device: &Device, worlds: &[World], rng: &mut ChaCha8Rng) -> f64 {
    let config = InteractionConfig { scalars: 9, vectors: 5, hidden: 11 };
    let layer = shaken(config.init(device, rng), SHAKE, rng);
    let input = HostFeatures::random(30, [9, 5], rng);
    deviation(worlds, |world| HostFeatures::of(&layer.forward(input.moved(world).tensors(device))))
}

fn soft_normalisation(device: &Device, worlds: &[World], rng: &mut ChaCha8Rng) -> f64 {
    let input = HostFeatures::random(30, [9, 5], rng);
    deviation(worlds, |world| HostFeatures::of(&input.moved(world).tensors(device).soft_normalize()))
}

fn attention(device: &Device, worlds: &[World], rng: &mut ChaCha8Rng) -> f64 {
    let config = InvariantAttentionConfig { query: [9, 5], memory: [7, 6], key: 4 };
    let layer = shaken(config.init(device, rng), SHAKE, rng);
    let (scenes, tokens, memory) =
        (3, HostFeatures::random(3 * 4, [9, 5], rng), HostFeatures::random(3 * 6, [7, 6], rng));
    deviation(worlds, |world| {
        let memory = memory.moved(world).tensors(device);
        HostFeatures::of(&layer.forward(scenes, &tokens.moved(world).tensors(device), &memory))
    })
}

fn pointer_attention(device: &Device, worlds: &[World], rng: &mut ChaCha8Rng) -> f64 {
    let config = PointerAttentionConfig { query: [9, 6], memory: [7, 5], heads: 3, key: 4 };
    let layer = shaken(config.init(device, rng), SHAKE, rng);
    let (scenes, tokens, memory) =
        (3, HostFeatures::random(3 * 4, [9, 6], rng), HostFeatures::random(3 * 6, [7, 5], rng));
    deviation(worlds, |world| {
        let memory = memory.moved(world).tensors(device);
        HostFeatures::of(&layer.forward(scenes, &tokens.moved(world).tensors(device), &memory))
    })
}

/// The maps must not move at all, and what they pool must move with its inputs.
fn heat_map(device: &Device, worlds: &[World], rng: &mut ChaCha8Rng) -> f64 {
    let (scenes, rows) = (3, 3 * 11);
    let layer = shaken(HeatMapConfig { channels: CHANNELS, nodes: 4 }.init(device, rng), SHAKE, rng);
    let input = HostFeatures::random(rows, [CHANNELS, CHANNELS], rng);
    deviation(worlds, |world| {
        let input = input.moved(world).tensors(device);
        let weights = layer.weights(scenes, &input);
        let mut output = HostFeatures::of(&HeatMap::pool(&weights, input));
        output.scalars.extend(values(&weights));
        output.scalars.extend(values(&HeatMap::overlap(&weights)));
        output
    })
}

/// Node features, positions relative to the centroid, and heat maps.
fn encoder(device: &Device, worlds: &[World], rng: &mut ChaCha8Rng) -> f64 {
    let config = EncoderConfig {
        graph: GRAPH,
        channels: CHANNELS,
        point_radial: RADIAL,
        centre_radial: RADIAL,
        ..EncoderConfig::default()
    };
    let layer = |rng: &mut ChaCha8Rng| config.init(device, rng).expect("the sizes make sense");
    let (clouds, layer) = (clouds(rng), shaken(layer(rng), SHAKE, rng));
    deviation(worlds, |world| {
        let encoded = layer.forward(&batch(&clouds, world, device));
        let with_position = burn::tensor::Tensor::cat(vec![encoded.nodes.vectors, encoded.positions], 2);
        let nodes = Features { scalars: encoded.nodes.scalars, vectors: with_position };
        let mut output = HostFeatures::of(&nodes);
        output.scalars.extend(values(&encoded.heat));
        output
    })
}
