//! The endpoint objective: the squared chordal distance of rotations, ½‖R̂ − R‖²_F ≈ θ², plus ‖p̂ − p‖²/ℓ², for the consensus and,
//! at half weight, for every node, plus the openings' squared error and the heat maps' overlap.

use burn::tensor::Tensor;
use reseflow_lie_tensor::chordal_distance_squared;
use serde::{Deserialize, Serialize};

use crate::LENGTH_SCALE_M;

/// Weights of the objective's terms; the consensus pose has weight 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ObjectiveConfig {
    /// Weight of the mean over nodes.
    pub nodes: f64,
    /// Weight of the squared opening error.
    pub opening: f64,
    /// Weight of the heat maps' overlap.
    pub overlap: f64,
}

impl Default for ObjectiveConfig {
    fn default() -> Self {
        Self { nodes: 0.5, opening: 0.25, overlap: 0.01 }
    }
}

/// Consensus predictions or their targets; N = B·L.
#[derive(Debug, Clone)]
pub struct EndpointTargets {
    /// `[N, 3, 3]`.
    pub rotations: Tensor<3>,
    /// Metres, `[N, 3]`.
    pub positions_m: Tensor<2>,
    /// `[N, 1]`.
    pub openings: Tensor<2>,
}

/// Every node's predictions.
#[derive(Debug, Clone)]
pub struct NodeTargets {
    /// `[N·K, 3, 3]`.
    pub rotations: Tensor<3>,
    /// Metres, `[N·K, 3]`.
    pub positions_m: Tensor<2>,
}

/// The objective and what it is made of, each `[1]`.
#[derive(Debug, Clone)]
pub struct LossParts {
    /// The weighted sum.
    pub total: Tensor<1>,
    /// The consensus poses' part.
    pub consensus: Tensor<1>,
}

/// The objective of one batch.
///
/// # Shapes
/// - `weights`: `[N]`, one for each target action
/// - `overlap`: `[1]`
pub fn endpoint_loss(
    predicted: &EndpointTargets,
    nodes: &NodeTargets,
    targets: &EndpointTargets,
    weights: Tensor<1>,
    overlap: Tensor<1>,
    config: &ObjectiveConfig,
) -> LossParts {
    let [actions] = weights.dims();
    let [node_rows, _] = nodes.positions_m.dims();
    let per_action = node_rows / actions;
    let normalized = weights.clone() / weights.sum();

    let consensus = pose_error(
        (predicted.rotations.clone(), predicted.positions_m.clone()),
        (targets.rotations.clone(), targets.positions_m.clone()),
    );
    let consensus = (consensus * normalized.clone()).sum();
    let spread_rotations = targets.rotations.clone().unsqueeze_dim::<4>(1).repeat_dim(1, per_action);
    let spread_positions = targets.positions_m.clone().unsqueeze_dim::<3>(1).repeat_dim(1, per_action);
    let node_error = pose_error(
        (nodes.rotations.clone(), nodes.positions_m.clone()),
        (spread_rotations.reshape([node_rows, 3, 3]), spread_positions.reshape([node_rows, 3])),
    );
    let node_error: Tensor<1> = node_error.reshape([actions, per_action]).mean_dim(1).reshape([actions]);
    let opening: Tensor<1> =
        (predicted.openings.clone() - targets.openings.clone()).square().reshape([actions]);
    let total = consensus.clone()
        + (node_error * normalized.clone()).sum().mul_scalar(config.nodes)
        + (opening * normalized).sum().mul_scalar(config.opening)
        + overlap.mul_scalar(config.overlap);
    LossParts { total, consensus }
}

/// ½‖R̂ − R‖²_F + ‖p̂ − p‖²/ℓ², `[N]`.
fn pose_error(predicted: (Tensor<3>, Tensor<2>), target: (Tensor<3>, Tensor<2>)) -> Tensor<1> {
    let [rows, _] = target.1.dims();
    let offset: Tensor<1> = (predicted.1 - target.1).square().sum_dim(1).reshape([rows]);
    chordal_distance_squared(predicted.0, target.0).mul_scalar(0.5)
        + offset.div_scalar(LENGTH_SCALE_M * LENGTH_SCALE_M)
}
