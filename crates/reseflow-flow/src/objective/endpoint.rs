//! The objective of a network that predicts clean poses.

use burn::tensor::Tensor;
use reseflow_lie_tensor::{SE3Tensor, chordal_distance_squared};

use super::{LossContext, LossParts, ObjectiveConfig, PoseError, repeat_rows, twist_distance_squared};
use crate::LENGTH_SCALE_M;

/// Consensus predictions, their targets, or noisy actions; N = B·L.
#[derive(Debug, Clone)]
pub struct EndpointTargets {
    /// `[N, 3, 3]`.
    pub rotations: Tensor<3>,
    /// Metres, `[N, 3]`.
    pub positions_m: Tensor<2>,
    /// `[N, 1]`.
    pub openings: Tensor<2>,
}

impl EndpointTargets {
    fn poses(&self) -> SE3Tensor {
        SE3Tensor { rotation: self.rotations.clone(), translation: self.positions_m.clone() }
    }
}

/// Every node's predictions.
#[derive(Debug, Clone)]
pub struct NodeTargets {
    /// `[N·K, 3, 3]`.
    pub rotations: Tensor<3>,
    /// Metres, `[N·K, 3]`.
    pub positions_m: Tensor<2>,
}

/// The objective of one batch of clean poses.
///
/// With [`PoseError::Twist`] the drift is that of the prediction, (1 − t)⁻¹ times the displacement from H^t to Ĥ¹ along the path's
/// geodesic, and the weight (1 − t)² leaves the displacements themselves: nothing is divided.
pub fn endpoint_loss(
    predicted: &EndpointTargets,
    nodes: &NodeTargets,
    targets: &EndpointTargets,
    context: &LossContext,
    config: &ObjectiveConfig,
) -> LossParts {
    let [actions, _] = targets.positions_m.dims();
    let [node_rows, _] = nodes.positions_m.dims();
    let per_action = node_rows / actions;
    let (consensus, wanted) = (predicted.poses(), targets.poses());
    let nodes = SE3Tensor { rotation: nodes.rotations.clone(), translation: nodes.positions_m.clone() };
    let (consensus, nodes) = match config.error {
        PoseError::Chordal => {
            let spread = repeat_poses(&wanted, per_action);
            (chordal_error(&consensus, &wanted), chordal_error(&nodes, &spread))
        }
        PoseError::Twist => {
            let geodesic = context.path.geodesic();
            let states = context.states.poses();
            let target = geodesic.displacement(&states, &wanted);
            let spread = repeat_rows(target.clone(), per_action);
            let of_nodes = geodesic.displacement(&repeat_poses(&states, per_action), &nodes);
            let of_consensus = geodesic.displacement(&states, &consensus);
            (twist_distance_squared(of_consensus, target), twist_distance_squared(of_nodes, spread))
        }
    };
    let openings: Tensor<1> =
        (predicted.openings.clone() - targets.openings.clone()).square().reshape([actions]);
    config.combine(consensus, nodes, openings, context)
}

fn repeat_poses(poses: &SE3Tensor, times: usize) -> SE3Tensor {
    let rows = poses.len();
    let rotation = repeat_rows(poses.rotation.clone().reshape([rows, 9]), times);
    SE3Tensor {
        rotation: rotation.reshape([rows * times, 3, 3]),
        translation: repeat_rows(poses.translation.clone(), times),
    }
}

/// ½‖R̂ − R‖²_F + ‖p̂ − p‖²/ℓ², `[N]`.
fn chordal_error(predicted: &SE3Tensor, target: &SE3Tensor) -> Tensor<1> {
    let offset = predicted.translation.clone() - target.translation.clone();
    let offset: Tensor<1> = offset.square().sum_dim(1).reshape([target.len()]);
    chordal_distance_squared(predicted.rotation.clone(), target.rotation.clone()).mul_scalar(0.5)
        + offset.mul_scalar((LENGTH_SCALE_M * LENGTH_SCALE_M).recip())
}
