//! Between the plain values of the data crate and what the network reads and writes.

use burn::tensor::{Device, Tensor, TensorData};
use reseflow_data::{Action, ActionChunk, Observation};
use reseflow_flow::{ActionVelocity, ChunkVelocity, EndpointTargets, TwistTargets};
use reseflow_lie::{BodyTwist, Matrix3, SE3, SO3, Vector3};
use reseflow_net::{CloudGraph, EndpointPrediction, GraphConfig, GripperState, NetError, TwistPrediction};

use crate::TrainError;

/// A gripper pose and opening as the network's vectors.
pub(crate) fn token(world_from_gripper: &SE3, opening: f64) -> GripperState {
    let rotation = world_from_gripper.rotation.matrix();
    GripperState {
        columns: [0, 1, 2].map(|column| [0, 1, 2].map(|row| rotation[(row, column)])),
        position_m: world_from_gripper.translation.into(),
        opening,
    }
}

/// A trajectory as tokens.
pub(crate) fn tokens(chunk: &ActionChunk) -> Vec<GripperState> {
    chunk.iter().map(|action| token(&action.world_from_gripper, action.opening)).collect()
}

/// The graph of an observation's cloud.
pub(crate) fn graph(observation: &Observation, config: &GraphConfig) -> Result<CloudGraph, NetError> {
    let points: Vec<[f64; 3]> = observation.cloud.points.iter().map(|point| point.map(f64::from)).collect();
    CloudGraph::build(&points, &observation.cloud.colors, config)
}

/// A prediction on the host.
pub(crate) struct HostPrediction {
    /// The consensus, one chunk per scene.
    pub(crate) consensus: Vec<ActionChunk>,
    /// Every node's chunk, `[scene][node]`.
    pub(crate) nodes: Vec<Vec<ActionChunk>>,
    /// Consensus weights, `[scene][step][node]`.
    pub(crate) weights: Vec<Vec<Vec<f64>>>,
}

impl HostPrediction {
    /// Reads a prediction back and moves it from the scenes' origins to the world.
    pub(crate) fn new(prediction: &EndpointPrediction, origins_m: &[[f64; 3]]) -> Result<Self, TrainError> {
        let rotations = host(&prediction.rotations)?;
        let positions = host(&prediction.positions_m)?;
        let openings = host(&prediction.openings)?;
        let node_rotations = host(&prediction.node_rotations)?;
        let node_positions = host(&prediction.node_positions_m)?;
        let weights = host(&prediction.weights)?;
        let scenes = origins_m.len();
        let horizon = openings.len() / scenes;
        let nodes = weights.len() / openings.len();
        let pose = |rotations: &[f64], positions: &[f64], row: usize, origin: &[f64; 3]| {
            let rotation = Matrix3::from_row_slice(&rotations[9 * row..9 * row + 9]);
            let rotation = SO3::from_matrix(&rotation).map_err(|fault| {
                reseflow_flow::FlowError::Field(format!("predicted rotation {row}: {fault}"))
            })?;
            let translation = Vector3::from_fn(|axis, _| positions[3 * row + axis] + origin[axis]);
            Ok::<SE3, TrainError>(SE3 { rotation, translation })
        };
        let mut host = Self { consensus: Vec::new(), nodes: Vec::new(), weights: Vec::new() };
        for (scene, origin) in origins_m.iter().enumerate() {
            let rows = scene * horizon..(scene + 1) * horizon;
            let action = |rotations: &[f64], positions: &[f64], at: usize, row: usize| {
                let world_from_gripper = pose(rotations, positions, at, origin)?;
                Ok::<Action, TrainError>(Action { world_from_gripper, opening: openings[row] })
            };
            let consensus: Result<_, TrainError> =
                rows.clone().map(|row| action(&rotations, &positions, row, row)).collect();
            host.consensus.push(ActionChunk(consensus?));
            let mut per_node = Vec::with_capacity(nodes);
            for node in 0..nodes {
                let chunk: Result<_, TrainError> = (rows.clone())
                    .map(|row| action(&node_rotations, &node_positions, row * nodes + node, row))
                    .collect();
                per_node.push(ActionChunk(chunk?));
            }
            host.nodes.push(per_node);
            host.weights.push(rows.map(|row| weights[row * nodes..(row + 1) * nodes].to_vec()).collect());
        }
        Ok(host)
    }
}

/// Predicted velocities on the host, one chunk for each of `scenes` scenes.
pub(crate) fn velocities(
    prediction: &TwistPrediction,
    scenes: usize,
) -> Result<Vec<ChunkVelocity>, TrainError> {
    let (twists, openings) = (host(&prediction.twists)?, host(&prediction.openings)?);
    let velocity = |(twist, opening): (&[f64], &f64)| ActionVelocity {
        twist: BodyTwist::new(
            Vector3::from_column_slice(&twist[..3]),
            Vector3::from_column_slice(&twist[3..]),
        ),
        opening: *opening,
    };
    let all: Vec<ActionVelocity> = twists.chunks_exact(6).zip(&openings).map(velocity).collect();
    Ok(all.chunks(all.len() / scenes).map(|chunk| ChunkVelocity(chunk.to_vec())).collect())
}

/// N velocities as tensors.
pub(crate) fn twist_tensors(chunks: &[ChunkVelocity], device: &Device) -> TwistTargets {
    let (mut twists, mut openings) = (Vec::new(), Vec::new());
    for velocity in chunks.iter().flat_map(|chunk| &chunk.0) {
        twists.extend(velocity.twist.vector6().iter().copied());
        openings.push(velocity.opening);
    }
    let count = openings.len();
    TwistTargets {
        twists: Tensor::from_data(TensorData::new(twists, [count, 6]), device),
        openings: Tensor::from_data(TensorData::new(openings, [count, 1]), device),
    }
}

/// N poses and openings as tensors.
pub(crate) fn endpoint_tensors(
    actions: impl Iterator<Item = (SE3, f64)>,
    device: &Device,
) -> EndpointTargets {
    let (mut rotations, mut positions, mut openings) = (Vec::new(), Vec::new(), Vec::new());
    for (pose, opening) in actions {
        // nalgebra iterates by columns, tensors are laid out by rows.
        rotations.extend(pose.rotation.matrix().transpose().iter().copied());
        positions.extend(pose.translation.iter().copied());
        openings.push(opening);
    }
    let count = openings.len();
    EndpointTargets {
        rotations: Tensor::from_data(TensorData::new(rotations, [count, 3, 3]), device),
        positions_m: Tensor::from_data(TensorData::new(positions, [count, 3]), device),
        openings: Tensor::from_data(TensorData::new(openings, [count, 1]), device),
    }
}

/// A tensor's values in f64.
pub(crate) fn host<const D: usize>(tensor: &Tensor<D>) -> Result<Vec<f64>, TrainError> {
    tensor
        .try_to_vec_as::<f64>()
        .map_err(|fault| reseflow_flow::FlowError::Field(format!("reading a tensor back: {fault:?}")).into())
}
