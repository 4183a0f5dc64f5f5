//! Layers one by one: those without neighbours for degrees 0–1, 0–2 and 0–3, and those of the default network at its sizes. Convolutions
//! and attention of all degrees are in `degrees.rs`.

use burn::tensor::{Device, Tensor};
use divan::Bencher;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use reseflow_net::degrees::{
    FiberHeatMap, FiberHeatMapConfig, FiberLayerNormConfig, FiberLinearConfig, GatedNonlinearityConfig,
    NormNonlinearityConfig,
};
use reseflow_net::{
    ConvolutionConfig, DriftNetConfig, Features, HeatMap, HeatMapConfig, InteractionConfig,
    InvariantAttentionConfig, PointerAttentionConfig, SceneBatch,
};

use super::degrees::{Layer, all};
use super::{DEVICES, POINTS, Workload, device, finish};

fn rng() -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(5)
}

#[divan::bench(args = DEVICES, consts = [1, 2, 3])]
fn fiber_linear<const DEGREE: usize>(bencher: Bencher, name: &str) {
    let layer = Layer::new(device(name), DEGREE);
    let fiber = layer.features.fiber();
    let linear = FiberLinearConfig { input: fiber.clone(), output: fiber, bias: true };
    let linear = linear.init(&layer.device, &mut rng());
    bencher.bench(|| all(linear.forward(&layer.features)));
}

#[divan::bench(args = DEVICES, consts = [1, 2, 3])]
fn norm_nonlinearity<const DEGREE: usize>(bencher: Bencher, name: &str) {
    let layer = Layer::new(device(name), DEGREE);
    let norm = NormNonlinearityConfig { fiber: layer.features.fiber() }.init(&layer.device);
    bencher.bench(|| all(norm.forward(layer.features.clone())));
}

#[divan::bench(args = DEVICES, consts = [1, 2, 3])]
fn gated_nonlinearity<const DEGREE: usize>(bencher: Bencher, name: &str) {
    let layer = Layer::new(device(name), DEGREE);
    let gated = GatedNonlinearityConfig { fiber: layer.features.fiber() }.init(&layer.device, &mut rng());
    bencher.bench(|| all(gated.forward(layer.features.clone())));
}

#[divan::bench(args = DEVICES, consts = [1, 2, 3])]
fn fiber_layer_norm<const DEGREE: usize>(bencher: Bencher, name: &str) {
    let layer = Layer::new(device(name), DEGREE);
    let norm = FiberLayerNormConfig { fiber: layer.features.fiber() }.init(&layer.device);
    bencher.bench(|| all(norm.forward(layer.features.clone())));
}

/// The maps, and what they pool.
#[divan::bench(args = DEVICES, consts = [1, 2, 3])]
fn fiber_heat_map<const DEGREE: usize>(bencher: Bencher, name: &str) {
    let layer = Layer::new(device(name), DEGREE);
    let maps = FiberHeatMapConfig { fiber: layer.features.fiber(), nodes: 4 };
    let maps = maps.init(&layer.device, &mut rng());
    bencher.bench(|| {
        let weights = maps.weights(1, &layer.features);
        all(FiberHeatMap::pool(&weights, &layer.features))
    });
}

fn features(rows: usize, [scalars, vectors]: [usize; 2], device: &Device) -> Features {
    Features {
        scalars: Tensor::ones([rows, scalars], device),
        vectors: Tensor::ones([3, rows, vectors], device),
    }
}

fn both(features: Features) -> f32 {
    finish(features.scalars) + finish(features.vectors)
}

/// Among the centres of one scene.
#[divan::bench(args = DEVICES)]
#[expect(clippy::expect_used, reason = "a bench may end where its own input is wrong")]
fn convolution_of_degrees_0_and_1(bencher: Bencher, name: &str) {
    let workload = Workload::new(device(name), 1, POINTS);
    let encoder = DriftNetConfig::default().encoder;
    let (channels, radial) = (encoder.channels, encoder.centre_radial);
    let grippers = &workload.states[0].frames[..1];
    let (graphs, point_radial) = (&workload.graphs[0], &encoder.point_radial);
    let batch =
        SceneBatch::collate(graphs, grippers, point_radial, &radial, &workload.device).expect("sizes agree");
    let convolution = ConvolutionConfig { channels, radial: radial.count, source_vectors: true };
    let convolution = convolution.init(&workload.device, &mut rng());
    let sources = features(encoder.graph.centres, [channels; 2], &workload.device);
    bencher.bench(|| both(convolution.forward(&sources, sources.scalars.clone(), &batch.centre_edges)));
}

/// Of the encoder's centres.
#[divan::bench(args = DEVICES)]
fn heat_map_of_degrees_0_and_1(bencher: Bencher, name: &str) {
    let (device, encoder) = (device(name), DriftNetConfig::default().encoder);
    let maps = HeatMapConfig { channels: encoder.channels, nodes: encoder.nodes };
    let maps = maps.init(&device, &mut rng());
    let centres = features(encoder.graph.centres, [encoder.channels; 2], &device);
    bencher.bench(|| both(HeatMap::pool(&maps.weights(1, &centres), centres.clone())));
}

/// The tokens' and the nodes' or centres' sizes.
fn decoder_sizes() -> ([usize; 2], [usize; 2]) {
    let DriftNetConfig { encoder, decoder, .. } = DriftNetConfig::default();
    ([decoder.token_scalars, decoder.token_vectors], [encoder.channels, encoder.channels + 1])
}

/// Of the decoder's tokens.
#[divan::bench(args = DEVICES)]
fn interaction(bencher: Bencher, name: &str) {
    let (device, (token, _)) = (device(name), decoder_sizes());
    let layer = InteractionConfig { scalars: token[0], vectors: token[1], hidden: token[0] + 2 * token[1] };
    let layer = layer.init(&device, &mut rng());
    let tokens = features(DriftNetConfig::default().decoder.horizon, token, &device);
    bencher.bench(|| both(layer.forward(tokens.clone())));
}

/// From tokens to the nodes of all frames.
#[divan::bench(args = DEVICES)]
fn attention_to_nodes(bencher: Bencher, name: &str) {
    let (device, (token, node)) = (device(name), decoder_sizes());
    let DriftNetConfig { encoder, decoder, .. } = DriftNetConfig::default();
    let layer = InvariantAttentionConfig { query: token, memory: node, key: 32 };
    let layer = layer.init(&device, &mut rng());
    let tokens = features(decoder.horizon, token, &device);
    let nodes = features(decoder.frames * encoder.nodes, node, &device);
    bencher.bench(|| both(layer.forward(1, &tokens, &nodes)));
}

/// From tokens to the centres of all frames.
#[divan::bench(args = DEVICES)]
fn pointers_to_centres(bencher: Bencher, name: &str) {
    let (device, (token, node)) = (device(name), decoder_sizes());
    let DriftNetConfig { encoder, decoder, .. } = DriftNetConfig::default();
    let layer = PointerAttentionConfig { query: token, memory: node, heads: decoder.pointers, key: 16 };
    let layer = layer.init(&device, &mut rng());
    let tokens = features(decoder.horizon, token, &device);
    let centres = features(decoder.frames * encoder.graph.centres, node, &device);
    bencher.bench(|| both(layer.forward(1, &tokens, &centres)));
}
