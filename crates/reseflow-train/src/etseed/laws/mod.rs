//! The laws of the kernels, their input and their objective; many are mistakes of the released code that must not come back.

mod kernels;
mod training;

use burn::tensor::{Device, Tensor};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use reseflow_data::{Action, ActionChunk, Dataset, Episode, Observation, PointCloud};
use reseflow_flow::{AnchoredChunk, Diffusion, EndpointTargets};
use reseflow_lie::{SE3, SO3, Vector3};
use reseflow_net::{DecoderConfig, DriftNetConfig, EncoderConfig, GraphConfig, RadialBasis};

use super::config::EtSeedConfig;
use super::input::{KernelInput, SceneView};
use super::net::EtSeedNet;
use crate::convert::host;
use crate::field::Seen;

const HORIZON: usize = 4;

fn rng(stream: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(stream)
}

fn device() -> Device {
    Device::flex()
}

fn pose(rng: &mut ChaCha8Rng, reach_m: f64) -> SE3 {
    SE3::new(SO3::sample_haar(rng), Vector3::from_fn(|_, _| rng.random_range(-reach_m..reach_m)))
}

fn config() -> EtSeedConfig {
    let encoder = EncoderConfig {
        graph: GraphConfig { centres: 8, point_neighbors: 6, centre_neighbors: 4, color_m: 0.0 },
        channels: 8,
        layers: 1,
        nodes: 2,
        point_radial: RadialBasis { count: 6, max_m: 0.12 },
        centre_radial: RadialBasis { count: 6, max_m: 0.3 },
        ..EncoderConfig::default()
    };
    let decoder = DecoderConfig {
        horizon: HORIZON,
        frames: 2,
        layers: 2,
        token_scalars: 16,
        token_vectors: 8,
        grasp_memory: true,
        ..DecoderConfig::default()
    };
    let network = DriftNetConfig { encoder, decoder, ..DriftNetConfig::default() };
    EtSeedConfig { network, ..EtSeedConfig::default() }
}

fn of_degrees_0_to_2() -> EtSeedConfig {
    let mut config = config();
    let encoder = &mut config.network.encoder;
    (encoder.layers, encoder.max_degree) = (2, 2);
    config
}

fn net(config: &EtSeedConfig, device: &Device) -> EtSeedNet {
    EtSeedNet::new(config, device, &mut rng(5)).expect("the sizes make sense")
}

/// A blob of coloured points with the gripper beside it.
fn observation(rng: &mut ChaCha8Rng) -> Observation {
    let point = |rng: &mut ChaCha8Rng| [0, 1, 2].map(|_| rng.random_range(-0.2_f32..0.2));
    let color = |rng: &mut ChaCha8Rng| [0, 1, 2].map(|_| rng.random::<u8>());
    let points: Vec<_> = (0..40).map(|_| point(rng)).collect();
    let colors = (0..40).map(|_| color(rng)).collect();
    Observation {
        cloud: PointCloud { points, colors },
        world_from_gripper: pose(rng, 0.2),
        gripper_opening: rng.random(),
    }
}

/// Two frames of one scene.
fn scene(stream: u64) -> [Observation; 2] {
    let mut rng = rng(stream);
    let first = observation(&mut rng);
    let mut second = first.clone();
    second.world_from_gripper = first.world_from_gripper * pose(&mut rng, 0.02);
    [first, second]
}

fn moved(world: &SE3, frames: &[Observation; 2]) -> [Observation; 2] {
    frames.clone().map(|mut frame| {
        for point in &mut frame.cloud.points {
            *point = world.act(&Vector3::from(point.map(f64::from))).map(|value| value as f32).into();
        }
        frame.world_from_gripper = *world * frame.world_from_gripper;
        frame
    })
}

fn view(frames: &[Observation; 2], config: &EtSeedConfig) -> SceneView {
    let world_from_grasp = frames[0].world_from_gripper;
    SceneView::new(&Seen { frames: frames.iter().collect(), world_from_grasp, elapsed: 1 }, config).unwrap()
}

/// A noisy trajectory at level `level`.
fn state(level: usize, stream: u64) -> AnchoredChunk {
    let mut rng = rng(stream);
    let diffusion = Diffusion::new(&config().diffusion).unwrap();
    let action = |_| reseflow_flow::AnchoredAction {
        anchor_from_gripper: pose(&mut rng, 0.2),
        opening: rng.random_range(-0.5..0.5),
    };
    let clean = AnchoredChunk((0..HORIZON).map(action).collect());
    diffusion.noised(&clean, level, &mut rng)
}

fn invariant(net: &EtSeedNet, views: &[&SceneView], states: &[AnchoredChunk]) -> EndpointTargets {
    let input = KernelInput::invariant(views, states, &vec![40; views.len()], 100, &device()).unwrap();
    let scenes = net.invariant.trunk.encode(views, &device()).unwrap();
    net.invariant.forward(&scenes, &input).unwrap()
}

fn equivariant(net: &EtSeedNet, views: &[&SceneView], chunks: &[ActionChunk]) -> EndpointTargets {
    let input = KernelInput::equivariant(views, chunks, &device()).unwrap();
    let scenes = net.equivariant.trunk.encode(views, &device()).unwrap();
    net.equivariant.forward(&scenes, &input).unwrap()
}

/// Every number of an answer: rotations by rows, positions over the length scale, openings.
fn numbers(of: &EndpointTargets) -> Vec<f64> {
    let positions: Tensor<2> = of.positions_m.clone().div_scalar(0.1);
    [host(&of.rotations).unwrap(), host(&positions).unwrap(), host(&of.openings).unwrap()].concat()
}

#[track_caller]
fn apart(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let worst = a.iter().zip(b).fold(0.0_f64, |worst, (a, b)| worst.max((a - b).abs()));
    assert!(a.iter().chain(b).all(|value| value.is_finite()));
    worst
}

/// `episodes` demonstrations of ten steps each.
fn data(episodes: usize) -> Dataset {
    let mut rng = rng(77);
    let mut episode = || {
        let observations = vec![observation(&mut rng); 10];
        let action = |_| Action { world_from_gripper: pose(&mut rng, 0.2), opening: 0.5 };
        Episode { observations, actions: (0..10).map(action).collect(), alternative: None, disturbance: None }
    };
    Dataset { episodes: (0..episodes).map(|_| episode()).collect(), meta: None }
}
