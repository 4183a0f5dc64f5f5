//! What training minimises: the error of the consensus and, at half weight, of every node, plus the openings' squared error and the
//! heat maps' overlap.

mod endpoint;
mod twist;

use burn::tensor::Tensor;
use reseflow_lie_tensor::se3::split;
use serde::{Deserialize, Serialize};

use crate::{FlowError, LENGTH_SCALE_M, Path};

pub use endpoint::{EndpointTargets, NodeTargets, endpoint_loss};
pub use twist::{TwistTargets, twist_loss};

/// The largest weight that a configuration may give.
const LARGEST_WEIGHT: f64 = 1e6;

/// How a pose, or the drift towards it, is compared with its target.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PoseError {
    /// e² = ½‖R̂ − R‖²_F + ‖p̂ − p‖²/ℓ², smooth everywhere; for small angles θ² + ‖p̂ − p‖²/ℓ².
    #[default]
    Chordal,
    /// The paper's: e² = ‖ω̂ − ω‖² + ‖ρ̂ − ρ‖²/ℓ² between the predicted drift and the path's velocity, in endpoint form weighted by
    /// (1 − t)². It jumps where the way left is half a turn.
    Twist,
}

/// How errors are measured, and the weights of the objective's terms; the consensus pose has weight 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ObjectiveConfig {
    /// The error e of a pose.
    pub error: PoseError,
    /// The c of the pseudo-Huber loss 2c(√(e² + c²) − c), which is e² for small errors and 2ce for large ones; absent, the loss is
    /// e² itself.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pseudo_huber: Option<f64>,
    /// Weight of the mean over nodes.
    pub nodes: f64,
    /// Weight of the squared opening error.
    pub opening: f64,
    /// Weight of the heat maps' overlap.
    pub overlap: f64,
}

impl Default for ObjectiveConfig {
    fn default() -> Self {
        Self { error: PoseError::Chordal, pseudo_huber: None, nodes: 0.5, opening: 0.25, overlap: 0.01 }
    }
}

impl ObjectiveConfig {
    /// Checks every value.
    ///
    /// # Errors
    /// [`FlowError::Config`] naming the first that is out of range.
    pub fn validate(&self) -> Result<(), FlowError> {
        for (key, value) in [("nodes", self.nodes), ("opening", self.opening), ("overlap", self.overlap)] {
            if !(0.0..=LARGEST_WEIGHT).contains(&value) {
                let fault = format!("objective.{key} must lie in 0 to {LARGEST_WEIGHT}, got {value}");
                return Err(FlowError::Config(fault));
            }
        }
        match self.pseudo_huber {
            Some(c) if !c.is_finite() || c <= 0.0 => Err(FlowError::Config(format!(
                "objective.pseudo_huber must be a number greater than 0, got {c}"
            ))),
            _ => Ok(()),
        }
    }

    /// The loss of squared errors.
    fn robust(&self, squared: Tensor<1>) -> Tensor<1> {
        match self.pseudo_huber {
            // 2c(√(e² + c²) − c) without the difference of two nearly equal numbers.
            Some(c) => squared.clone().mul_scalar(2.0 * c) / (squared.add_scalar(c * c).sqrt() + c),
            None => squared,
        }
    }

    /// The objective from the squared errors of N consensus poses, of their N·K nodes and of N openings, each flat.
    fn combine(
        &self,
        consensus: Tensor<1>,
        nodes: Tensor<1>,
        openings: Tensor<1>,
        context: &LossContext,
    ) -> LossParts {
        let [actions] = consensus.dims();
        let [node_rows] = nodes.dims();
        let weights = context.weights.clone();
        let sum = weights.clone().sum();
        // Where no action counts the weights are zero as they are.
        let nothing = sum.clone().equal_elem(0.0);
        let weights = weights / sum.mask_fill(nothing, 1.0);

        let consensus = (self.robust(consensus) * weights.clone()).sum();
        let nodes = self.robust(nodes).reshape([actions, node_rows / actions]).mean_dim(1).reshape([actions]);
        let total = consensus.clone()
            + (nodes * weights.clone()).sum().mul_scalar(self.nodes)
            + (openings * weights).sum().mul_scalar(self.opening)
            + context.overlap.clone().mul_scalar(self.overlap);
        LossParts { total, consensus }
    }
}

/// What a batch is judged by beside its targets; N = B·L.
#[derive(Debug, Clone)]
pub struct LossContext {
    /// The geodesic from noise to data.
    pub path: Path,
    /// H^t, what the network was shown, in the targets' frames.
    pub states: EndpointTargets,
    /// One weight for each action, `[N]`; only their ratios matter. All zero, no action counts.
    pub weights: Tensor<1>,
    /// The heat maps' overlap, `[1]`.
    pub overlap: Tensor<1>,
}

/// The objective and what it is made of, each `[1]`.
#[derive(Debug, Clone)]
pub struct LossParts {
    /// The weighted sum.
    pub total: Tensor<1>,
    /// The consensus poses' part.
    pub consensus: Tensor<1>,
}

/// ‖ω̂ − ω‖² + ‖ρ̂ − ρ‖²/ℓ² of twists `[N, 6]`, `[N]`.
fn twist_distance_squared(predicted: Tensor<2>, target: Tensor<2>) -> Tensor<1> {
    let [rows, _] = target.dims();
    let (angular, linear) = split(predicted - target);
    let squares = angular.square().sum_dim(1)
        + linear.square().sum_dim(1).mul_scalar((LENGTH_SCALE_M * LENGTH_SCALE_M).recip());
    squares.reshape([rows])
}

/// Every row of `[N, C]` `times` times in a row: `[N·times, C]`.
fn repeat_rows(rows: Tensor<2>, times: usize) -> Tensor<2> {
    let [count, width] = rows.dims();
    rows.unsqueeze_dim::<3>(1).repeat_dim(1, times).reshape([count * times, width])
}
