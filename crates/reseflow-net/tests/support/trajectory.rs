//! The whole network from scenes to trajectories in the world frame, and how far two of them are apart.

use burn::tensor::Device;
use reseflow_lie::{Matrix3, Vector3};
use reseflow_net::{CloudGraph, DriftNet, EncodedScenes, EndpointPrediction, TokenBatch};

use super::scene::Scene;
use super::world::World;
use super::{values, worse, worst_difference};

/// What the network predicts for one scene.
#[derive(Debug, Clone)]
pub(crate) struct Trajectory {
    pub(crate) consensus: Vec<Pose>,
    /// Every node's poses, `[L·K]`.
    pub(crate) nodes: Vec<Pose>,
    /// Openings and consensus weights.
    pub(crate) scalars: Vec<f64>,
}

/// Rotation matrix and world position, metres.
pub(crate) type Pose = (Matrix3<f64>, Vector3<f64>);

/// The largest differences between two trajectories.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Deviation {
    pub(crate) position_m: f64,
    /// Frobenius norm.
    pub(crate) rotation: f64,
    pub(crate) node_position_m: f64,
    pub(crate) node_rotation: f64,
    pub(crate) scalar: f64,
}

impl Deviation {
    pub(crate) fn worse(self, other: Deviation) -> Deviation {
        Deviation {
            position_m: worse(self.position_m, other.position_m),
            rotation: worse(self.rotation, other.rotation),
            node_position_m: worse(self.node_position_m, other.node_position_m),
            node_rotation: worse(self.node_rotation, other.node_rotation),
            scalar: worse(self.scalar, other.scalar),
        }
    }

    /// The largest of all.
    pub(crate) fn largest(self) -> f64 {
        let Deviation { position_m, rotation, node_position_m, node_rotation, scalar } = self;
        [position_m, rotation, node_position_m, node_rotation, scalar].into_iter().fold(0.0, worse)
    }
}

impl Trajectory {
    /// How far `moved` is from this trajectory moved by `world`.
    pub(crate) fn deviation(&self, moved: &Trajectory, world: &World) -> Deviation {
        let [position_m, rotation] = poses_deviation(&self.consensus, &moved.consensus, world);
        let [node_position_m, node_rotation] = poses_deviation(&self.nodes, &moved.nodes, world);
        let scalar = worst_difference(&self.scalars, &moved.scalars);
        Deviation { position_m, rotation, node_position_m, node_rotation, scalar }
    }
}

fn poses_deviation(still: &[Pose], moved: &[Pose], world: &World) -> [f64; 2] {
    assert_eq!(still.len(), moved.len());
    let (mut position_m, mut rotation) = (0.0, 0.0);
    for (still, moved) in still.iter().zip(moved) {
        position_m = worse(position_m, (world.turn * still.1 + world.shift - moved.1).norm());
        rotation = worse(rotation, (world.rotation(&still.0) - moved.0).norm());
    }
    [position_m, rotation]
}

/// The graphs of `scenes` as the network's configuration has them, `[O][B]`, oldest frame first.
pub(crate) fn graphs(net: &DriftNet, scenes: &[Scene]) -> Vec<Vec<CloudGraph>> {
    let config = net.config();
    let frame =
        |frame: usize| scenes.iter().map(|scene| scene.clouds[frame].graph(&config.encoder.graph)).collect();
    (0..config.decoder.frames).map(frame).collect()
}

/// Encodes every frame of `scenes`, oldest first.
pub(crate) fn encode(net: &DriftNet, scenes: &[Scene], device: &Device) -> Vec<EncodedScenes> {
    encode_graphs(net, &graphs(net, scenes), scenes, device)
}

fn encode_graphs(
    net: &DriftNet,
    graphs: &[Vec<CloudGraph>],
    scenes: &[Scene],
    device: &Device,
) -> Vec<EncodedScenes> {
    let encoded = graphs.iter().enumerate().map(|(frame, graphs)| {
        let grippers: Vec<_> = scenes.iter().map(|scene| scene.grippers[frame]).collect();
        net.encode(graphs, &grippers, device).expect("the graphs have the network's sizes")
    });
    encoded.collect()
}

/// The network's endpoint for `scenes`, with the heat maps that led to it and the positions' origins.
pub(crate) fn endpoint(
    net: &DriftNet,
    scenes: &[Scene],
    device: &Device,
) -> (EndpointPrediction, Vec<EncodedScenes>, Vec<[f64; 3]>) {
    endpoint_on(net, &graphs(net, scenes), scenes, device)
}

/// The same on these graphs of the scenes' clouds.
pub(crate) fn endpoint_on(
    net: &DriftNet,
    graphs: &[Vec<CloudGraph>],
    scenes: &[Scene],
    device: &Device,
) -> (EndpointPrediction, Vec<EncodedScenes>, Vec<[f64; 3]>) {
    let encoded = encode_graphs(net, graphs, scenes, device);
    let states: Vec<_> = scenes.iter().map(Scene::state).collect();
    let context = net.context(&encoded, &states).expect("frames and states go together");
    let noise: Vec<_> = scenes.iter().map(|scene| scene.noise.clone()).collect();
    let times: Vec<_> = scenes.iter().map(|scene| scene.time).collect();
    let tokens = TokenBatch::new(&noise, &times, &context.origins_m, device).expect("one token list a scene");
    let prediction = net.decode(&context, &tokens).expect("the tokens have the network's horizon");
    (prediction, encoded, context.origins_m)
}

/// The network's trajectories for `scenes`.
pub(crate) fn predict(net: &DriftNet, scenes: &[Scene], device: &Device) -> Vec<Trajectory> {
    predict_on(net, &graphs(net, scenes), scenes, device)
}

/// The same on these graphs of the scenes' clouds.
pub(crate) fn predict_on(
    net: &DriftNet,
    graphs: &[Vec<CloudGraph>],
    scenes: &[Scene],
    device: &Device,
) -> Vec<Trajectory> {
    let (prediction, _, origins_m) = endpoint_on(net, graphs, scenes, device);
    let horizon = net.config().decoder.horizon;
    let nodes = net.config().encoder.nodes;
    let rotations = values(&prediction.rotations);
    let positions = values(&prediction.positions_m);
    let node_rotations = values(&prediction.node_rotations);
    let node_positions = values(&prediction.node_positions_m);
    let openings = values(&prediction.openings);
    let weights = values(&prediction.weights);
    let pose = |rotations: &[f64], positions: &[f64], row: usize, origin: &[f64; 3]| {
        (
            Matrix3::from_row_slice(&rotations[9 * row..9 * row + 9]),
            Vector3::from_row_slice(&positions[3 * row..3 * row + 3]) + Vector3::from(*origin),
        )
    };
    let scene = |(scene, origin): (usize, &[f64; 3])| {
        let rows = scene * horizon..(scene + 1) * horizon;
        let node_rows = rows.start * nodes..rows.end * nodes;
        Trajectory {
            consensus: rows.clone().map(|row| pose(&rotations, &positions, row, origin)).collect(),
            nodes: node_rows.clone().map(|row| pose(&node_rotations, &node_positions, row, origin)).collect(),
            scalars: openings[rows].iter().chain(&weights[node_rows]).copied().collect(),
        }
    };
    origins_m.iter().enumerate().map(scene).collect()
}

/// One scene alone.
pub(crate) fn predict_one(net: &DriftNet, scene: &Scene, device: &Device) -> Trajectory {
    predict(net, std::slice::from_ref(scene), device).remove(0)
}
