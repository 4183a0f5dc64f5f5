//! What the network costs at its default size: `cargo bench -p reseflow-net`. `net/degrees.rs` has the layers of all degrees.

#[path = "net/degrees.rs"]
mod degrees;

use burn::tensor::{Device, Tensor};
use divan::{Bencher, black_box};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use reseflow_net::{
    CloudGraph, DriftNet, DriftNetConfig, EncodedScenes, EndpointPrediction, GraphConfig, GripperState,
    SceneContext, SceneState, TokenBatch,
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

/// Points of a cloud.
const POINTS: usize = 100;

fn cloud(rng: &mut ChaCha8Rng) -> (Vec<[f64; 3]>, Vec<[u8; 3]>) {
    let points = (0..POINTS).map(|_| [(); 3].map(|()| rng.random_range(-0.25..0.25)));
    (points.collect(), (0..POINTS).map(|_| [255, 128, 0]).collect())
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
    #[expect(clippy::expect_used, reason = "a bench may end where its own input is wrong")]
    fn new(device: Device, scenes: usize) -> Workload {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let config = DriftNetConfig::default();
        let (frames, horizon) = (config.decoder.frames, config.decoder.horizon);
        let mut graph = || {
            let (points, colors) = cloud(&mut rng);
            CloudGraph::build(&points, &colors, &config.encoder.graph).expect("the cloud is sound")
        };
        let graphs = (0..frames).map(|_| (0..scenes).map(|_| graph()).collect()).collect();
        let mut grippers = |count: usize| (0..count).map(|_| gripper(&mut rng)).collect::<Vec<_>>();
        let states = (0..scenes).map(|_| SceneState { frames: grippers(frames), progress: 0.3 }).collect();
        let noise = (0..scenes).map(|_| grippers(horizon)).collect();
        let net = config.init(&device, &mut rng);
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

/// Reads a tensor back, so that no work is left over.
fn finish<const D: usize>(tensor: Tensor<D>) -> f32 {
    tensor.sum().into_scalar::<f32>()
}

#[divan::bench]
fn graph_of_a_cloud(bencher: Bencher) {
    let (points, colors) = cloud(&mut ChaCha8Rng::seed_from_u64(1));
    let config = GraphConfig::default();
    bencher.bench(|| CloudGraph::build(black_box(&points), &colors, &config));
}

#[divan::bench(args = DEVICES)]
fn encode_one_scene(bencher: Bencher, name: &str) {
    let workload = Workload::new(device(name), 1);
    bencher.bench(|| workload.encode().into_iter().map(|frame| finish(frame.positions)).sum::<f32>());
}

#[divan::bench(args = DEVICES, consts = [1, BATCH])]
fn decode<const SCENES: usize>(bencher: Bencher, name: &str) {
    let workload = Workload::new(device(name), SCENES);
    let context = workload.context();
    bencher.bench(|| finish(workload.decode(&context).positions_m));
}

#[divan::bench(args = DEVICES)]
fn forward_and_backward_of_a_batch(bencher: Bencher, name: &str) {
    let workload = Workload::new(device(name).autodiff(), BATCH);
    bencher.bench(|| {
        let predicted = workload.decode(&workload.context());
        (predicted.positions_m.square().sum() + predicted.rotations.square().sum()).backward()
    });
}
