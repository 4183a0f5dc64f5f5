//! What the network costs at its default size: `cargo bench -p reseflow-net`. `net/decoder.rs` has the decoder by itself, `net/layers.rs`
//! the layers, `net/degrees.rs` what is made of features of all degrees.
//!
//! Where a throughput stands, it is in operations (multiplications and additions) per second; `peak_by_matrix_product` in
//! `net/degrees.rs` is what the machine reaches at most.

#[path = "net/decoder.rs"]
mod decoder;
#[path = "net/degrees.rs"]
mod degrees;
#[path = "net/layers.rs"]
mod layers;

use burn::tensor::{Device, Tensor};
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use reseflow_net::{
    CloudGraph, DriftNet, DriftNetConfig, EncodedScenes, EncoderConfig, EndpointPrediction, GraphConfig,
    GripperState, SceneContext, SceneState, TokenBatch,
};

fn main() {
    divan::main();
}

/// The CPU devices.
const DEVICES: [&str; 2] = ["flex", "ndarray"];

/// Scenes of a training batch.
const BATCH: usize = 16;

#[expect(deprecated, reason = "burn keeps ndarray until 0.23, and we promise that it works until then")]
fn device(name: &str) -> Device {
    if name == "ndarray" { Device::ndarray() } else { Device::flex() }
}

/// Points of a cloud, where nothing else is said.
const POINTS: usize = 100;

fn cloud(count: usize, rng: &mut ChaCha8Rng) -> (Vec<[f64; 3]>, Vec<[u8; 3]>) {
    let points = (0..count).map(|_| [(); 3].map(|()| rng.random_range(-0.25..0.25)));
    (points.collect(), vec![[255, 128, 0]; count])
}

fn gripper(rng: &mut ChaCha8Rng) -> GripperState {
    GripperState {
        columns: [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]],
        position_m: [(); 3].map(|()| rng.random_range(-0.2..0.2)),
        opening: 0.5,
    }
}

/// A network and a batch to put through it.
struct Workload {
    device: Device,
    net: DriftNet,
    /// `[O][B]`.
    graphs: Vec<Vec<CloudGraph>>,
    states: Vec<SceneState>,
    noise: Vec<Vec<GripperState>>,
    times: Vec<f64>,
}

impl Workload {
    fn new(device: Device, scenes: usize, points: usize) -> Workload {
        Self::with(&DriftNetConfig::default(), device, scenes, points)
    }

    #[expect(clippy::expect_used, reason = "a bench may end where its own input is wrong")]
    fn with(config: &DriftNetConfig, device: Device, scenes: usize, points: usize) -> Workload {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let (frames, horizon) = (config.decoder.frames, config.decoder.horizon);
        let mut graph = || {
            let (points, colors) = cloud(points, &mut rng);
            CloudGraph::build(&points, &colors, &config.encoder.graph).expect("the cloud is sound")
        };
        let graphs = (0..frames).map(|_| (0..scenes).map(|_| graph()).collect()).collect();
        let mut grippers = |count: usize| (0..count).map(|_| gripper(&mut rng)).collect::<Vec<_>>();
        let states = (0..scenes)
            .map(|_| SceneState { frames: grippers(frames), grasp: grippers(1)[0], progress: 0.3 })
            .collect();
        let noise = (0..scenes).map(|_| grippers(horizon)).collect();
        let net = config.init(&device, &mut rng).expect("the sizes make sense");
        Workload { device, net, graphs, states, noise, times: vec![0.4; scenes] }
    }

    #[expect(clippy::expect_used, reason = "a bench may end where its own input is wrong")]
    fn encode(&self) -> Vec<EncodedScenes> {
        let frame = |(frame, graphs): (usize, &Vec<CloudGraph>)| {
            let grippers: Vec<_> = self.states.iter().map(|state| state.frames[frame]).collect();
            self.net.encode(graphs, &grippers, &self.device).expect("sizes agree")
        };
        self.graphs.iter().enumerate().map(frame).collect()
    }

    #[expect(clippy::expect_used, reason = "a bench may end where its own input is wrong")]
    fn context(&self) -> SceneContext {
        self.net.context(&self.encode(), &self.states).expect("sizes agree")
    }

    #[expect(clippy::expect_used, reason = "a bench may end where its own input is wrong")]
    fn decode(&self, context: &SceneContext) -> EndpointPrediction {
        let tokens = TokenBatch::new(&self.noise, &self.times, &context.origins_m, &self.device);
        self.net.decode(context, &tokens.expect("sizes agree")).expect("sizes agree")
    }
}

/// Operations of a matrix product.
fn product(rows: usize, inputs: usize, outputs: usize) -> usize {
    2 * rows * inputs * outputs
}

/// Operations of the encoder's matrix products for one frame of one scene.
fn encoder_operations(points: usize) -> usize {
    let EncoderConfig { graph, channels, layers, nodes, point_radial, centre_radial, .. } =
        DriftNetConfig::default().encoder;
    let GraphConfig { centres, point_neighbors, centre_neighbors, .. } = graph;
    let convolution = |sources: usize, neighbors: usize, radial: usize, paths: usize| {
        let edges = centres * neighbors;
        product(sources, channels, channels)
            + product(centres, channels, channels)
            + product(edges, radial, channels)
            + product(edges, channels, paths * channels)
    };
    let interaction =
        product(3 * centres, channels, 3 * channels) + 2 * product(centres, 3 * channels, 2 * channels);
    product(points, 3, channels)
        + product(centres, channels, channels)
        + product(3 * centres, 5, channels)
        + convolution(points, point_neighbors, point_radial.count, 2)
        + layers * convolution(centres, centre_neighbors, centre_radial.count, 5)
        + (layers + 1) * interaction
        + product(centres, 2 * channels, nodes)
        + product(nodes, centres, channels + 3 * (channels + 1))
}

/// Reads a tensor back, so that no work is left over.
fn finish<const D: usize>(tensor: Tensor<D>) -> f32 {
    tensor.sum().into_scalar::<f32>()
}

#[divan::bench]
fn graph_of_a_cloud(bencher: Bencher) {
    let (points, colors) = cloud(POINTS, &mut ChaCha8Rng::seed_from_u64(1));
    let config = GraphConfig::default();
    bencher.bench(|| CloudGraph::build(black_box(&points), &colors, &config));
}

/// Both frames of one scene.
#[divan::bench(args = DEVICES, consts = [100, 128, 256, 1024])]
fn encode<const POINTS: usize>(bencher: Bencher, name: &str) {
    let workload = Workload::new(device(name), 1, POINTS);
    let bencher = bencher.counter(ItemsCount::new(2 * encoder_operations(POINTS)));
    bencher.bench(|| workload.encode().into_iter().map(|frame| finish(frame.positions)).sum::<f32>());
}

/// A batch; a backward pass has two products for each of the forward pass, and the convolutions make theirs again.
#[divan::bench(args = DEVICES, consts = [100, 128, 256, 1024])]
fn encode_forward_and_backward<const POINTS: usize>(bencher: Bencher, name: &str) {
    let workload = Workload::new(device(name).autodiff(), BATCH, POINTS);
    let bencher = bencher.counter(ItemsCount::new(3 * 2 * BATCH * encoder_operations(POINTS)));
    bencher.bench(|| {
        let losses = workload.encode().into_iter().map(|frame| frame.positions.square().sum());
        losses.reduce(|a, b| a + b).map(|loss| loss.backward())
    });
}

/// Encoder and decoder, with features of degrees 0 to this among the centres.
#[divan::bench(args = DEVICES, consts = [1, 2, 3])]
fn forward_and_backward_of_a_batch<const DEGREE: usize>(bencher: Bencher, name: &str) {
    let mut config = DriftNetConfig::default();
    config.encoder.max_degree = DEGREE;
    let workload = Workload::with(&config, device(name).autodiff(), BATCH, POINTS);
    bencher.bench(|| {
        let predicted = workload.decode(&workload.context());
        (predicted.positions_m.square().sum() + predicted.rotations.square().sum()).backward()
    });
}
