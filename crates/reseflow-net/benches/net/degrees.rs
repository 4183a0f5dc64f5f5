//! Layers of degrees 0–1, 0–2 and 0–3: in the edge's frame and by paths, alone and in the networks.
//!
//! Throughput is in operations (multiplications and additions) per second; `peak_by_matrix_product` is what the machine reaches at most.

use burn::tensor::{Device, Tensor};
use divan::Bencher;
use divan::counter::ItemsCount;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use reseflow_net::degrees::{
    EdgeFrames, EdgeHarmonics, EdgeProduct, FiberFeatures, NeighborAttentionConfig, RadialMlpConfig,
    TensorProductConvolution, TensorProductConvolutionConfig, UniformFiber,
};
use reseflow_net::irreps::{components, components_up_to};
use reseflow_net::{
    CloudGraph, EdgeTensors, GraphConfig, ManiNodes, RadialBasis, SE3ManiNet, SE3ManiNetConfig,
};

use super::{BATCH, DEVICES, device, finish, gripper};

const GRAPH: GraphConfig =
    GraphConfig { centres: 128, point_neighbors: 16, centre_neighbors: 16, color_m: 0.0 };
const RADIAL: RadialBasis = RadialBasis { count: 8, max_m: 0.3 };
const RADIAL_MLP: RadialMlpConfig = RadialMlpConfig { radial: RADIAL.count, hidden: 32 };
const CHANNELS: usize = 8;

#[expect(clippy::expect_used, reason = "a bench may end where its own input is wrong")]
fn graph(points: usize, config: &GraphConfig, rng: &mut ChaCha8Rng) -> CloudGraph {
    let cloud: Vec<_> = (0..points).map(|_| [(); 3].map(|()| rng.random_range(-0.25..0.25))).collect();
    CloudGraph::build(&cloud, &vec![[255, 128, 0]; points], config).expect("the cloud is sound")
}

/// One layer's input: 128 points, 16 neighbours each, 8 channels.
pub(super) struct Layer {
    fiber: UniformFiber,
    pub(super) device: Device,
    pub(super) features: FiberFeatures,
    frames: EdgeFrames,
    harmonics: EdgeHarmonics,
    convolution: TensorProductConvolution,
}

impl Layer {
    #[expect(clippy::expect_used, reason = "a bench may end where its own input is wrong")]
    pub(super) fn new(device: Device, max_degree: usize) -> Layer {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let list = graph(GRAPH.centres, &GRAPH, &mut rng).centre_edges;
        let edges =
            EdgeTensors::collate([(&list, GRAPH.centres)], &RADIAL, &device).expect("the list is sound");
        let fiber = UniformFiber { max_degree, channels: CHANNELS };
        let convolution = TensorProductConvolutionConfig { input: fiber, output: fiber, radial: RADIAL_MLP };
        let degree = |degree| Tensor::ones([components(degree), GRAPH.centres, CHANNELS], &device);
        Layer {
            fiber,
            features: FiberFeatures { degrees: (0..=max_degree).map(degree).collect() },
            frames: EdgeFrames::new(edges, list.displacement_m.iter(), max_degree, &device)
                .expect("there is one displacement for each edge"),
            harmonics: EdgeHarmonics::new(list.displacement_m.iter(), 2 * max_degree, &device),
            convolution: convolution.init(&device, &mut rng),
            device,
        }
    }

    /// Operations of the convolution, with its radial network and the turns into the edges' frames and back.
    fn operations(&self, by_paths: bool) -> ItemsCount {
        let product = EdgeProduct { input: self.fiber, outputs: vec![self.fiber] };
        let hidden = RADIAL_MLP.hidden;
        let radial = 2 * hidden * (RADIAL_MLP.radial + hidden + product.weight_count());
        let turns = 4 * components_up_to(self.fiber.max_degree).pow(2) * CHANNELS;
        let product = if by_paths { product.operations_by_paths() } else { product.operations() + turns };
        ItemsCount::new(GRAPH.centres * GRAPH.centre_neighbors * (radial + product))
    }
}

pub(super) fn all(features: FiberFeatures) -> f32 {
    features.degrees.into_iter().map(finish).sum()
}

#[divan::bench(args = DEVICES)]
fn peak_by_matrix_product(bencher: Bencher, name: &str) {
    let size: usize = 512;
    let matrix: Tensor<2> = Tensor::ones([size, size], &device(name));
    let bencher = bencher.counter(ItemsCount::new(2 * size.pow(3)));
    bencher.bench(|| finish(matrix.clone().matmul(matrix.clone())));
}

#[divan::bench(args = DEVICES, consts = [1, 2, 3])]
fn convolution<const DEGREE: usize>(bencher: Bencher, name: &str) {
    let layer = Layer::new(device(name), DEGREE);
    let bencher = bencher.counter(layer.operations(false));
    bencher.bench(|| all(layer.convolution.forward(&layer.features, &layer.frames)));
}

/// Of the features and all weights; three times the products of the forward pass, and the messages once more.
#[divan::bench(args = DEVICES, consts = [1, 2, 3])]
fn convolution_forward_and_backward<const DEGREE: usize>(bencher: Bencher, name: &str) {
    let layer = Layer::new(device(name).autodiff(), DEGREE);
    bencher.bench(|| {
        let features = layer.features.degrees.iter().map(|degree| degree.clone().require_grad());
        let features = FiberFeatures { degrees: features.collect() };
        let degrees = layer.convolution.forward(&features, &layer.frames).degrees.into_iter();
        degrees.map(|degree| degree.square().sum()).reduce(|a, b| a + b).map(|loss| loss.backward())
    });
}

#[divan::bench(args = DEVICES, consts = [1, 2, 3])]
fn convolution_by_paths<const DEGREE: usize>(bencher: Bencher, name: &str) {
    let layer = Layer::new(device(name), DEGREE);
    let bencher = bencher.counter(layer.operations(true));
    bencher
        .bench(|| all(layer.convolution.forward_by_paths(&layer.features, &layer.frames, &layer.harmonics)));
}

#[divan::bench(args = DEVICES, consts = [1, 2, 3])]
#[expect(clippy::expect_used, reason = "a bench may end where its own input is wrong")]
fn attention<const DEGREE: usize>(bencher: Bencher, name: &str) {
    let layer = Layer::new(device(name), DEGREE);
    let output = UniformFiber { channels: CHANNELS / 2, ..layer.fiber };
    let config = NeighborAttentionConfig { input: layer.fiber, output, heads: 1, radial: RADIAL_MLP };
    let attention = config.init(&layer.device, &mut ChaCha8Rng::seed_from_u64(3));
    let attention = attention.expect("one head divides the channels");
    bencher.bench(|| all(attention.forward(&layer.features, &layer.frames)));
}

/// Wigner matrices of 2048 edges, on the host and onto the device.
#[divan::bench(consts = [1, 2, 3])]
#[expect(clippy::expect_used, reason = "a bench may end where its own input is wrong")]
fn frames_of_edges<const DEGREE: usize>(bencher: Bencher) {
    let device = device("flex");
    let list = graph(GRAPH.centres, &GRAPH, &mut ChaCha8Rng::seed_from_u64(2)).centre_edges;
    let edges = EdgeTensors::collate([(&list, GRAPH.centres)], &RADIAL, &device).expect("the list is sound");
    bencher.bench(|| EdgeFrames::new(edges.clone(), list.displacement_m.iter(), DEGREE, &device));
}

/// SE3ManiNet with its default graph and clouds of some number of points.
struct Scenes {
    device: Device,
    net: SE3ManiNet,
    graphs: Vec<CloudGraph>,
    grippers: Vec<reseflow_net::GripperState>,
}

impl Scenes {
    #[expect(clippy::expect_used, reason = "a bench may end where its own input is wrong")]
    fn new(device: Device, max_degree: usize, points: usize, scenes: usize) -> Scenes {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let mut config = SE3ManiNetConfig::default();
        (config.transformer.max_degree, config.transformer.output.max_degree) = (max_degree, max_degree);
        Scenes {
            net: config.init(&device, &mut rng).expect("the sizes make sense"),
            graphs: (0..scenes).map(|_| graph(points, &config.graph, &mut rng)).collect(),
            grippers: (0..scenes).map(|_| gripper(&mut rng)).collect(),
            device,
        }
    }

    #[expect(clippy::expect_used, reason = "a bench may end where its own input is wrong")]
    fn encode(&self) -> ManiNodes {
        self.net.encode(&self.graphs, &self.grippers, &self.device).expect("one gripper a graph")
    }
}

#[divan::bench(args = DEVICES, consts = [1, 2, 3])]
fn mani_net_of_one_scene<const DEGREE: usize>(bencher: Bencher, name: &str) {
    let scenes = Scenes::new(device(name), DEGREE, 128, 1);
    bencher.bench(|| finish(scenes.encode().translations_m));
}

#[divan::bench(consts = [100, 128, 256, 1024])]
fn mani_net_of_points<const POINTS: usize>(bencher: Bencher) {
    let scenes = Scenes::new(device("flex"), 3, POINTS, 1);
    bencher.bench(|| finish(scenes.encode().translations_m));
}

#[divan::bench(args = DEVICES, consts = [1, 2, 3])]
fn mani_net_forward_and_backward_of_a_batch<const DEGREE: usize>(bencher: Bencher, name: &str) {
    let scenes = Scenes::new(device(name).autodiff(), DEGREE, 128, BATCH);
    bencher.bench(|| {
        let nodes = scenes.encode();
        (nodes.translations_m.square().sum() + nodes.rotations.square().sum()).backward()
    });
}
