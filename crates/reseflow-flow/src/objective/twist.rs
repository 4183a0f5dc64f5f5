//! The objective of a network that predicts the drift itself: the paper's E‖ξ − ξ_θ(H^t, t)‖², on body twists, with the metres over
//! ℓ. It needs no weight: the path's velocity is bounded.

use burn::tensor::Tensor;

use super::{LossContext, LossParts, ObjectiveConfig, repeat_rows, twist_distance_squared};

/// Predicted drifts or their targets; N = B·L.
#[derive(Debug, Clone)]
pub struct TwistTargets {
    /// Body twists (ω, ρ), rad and metres per unit of flow time, `[N, 6]`.
    pub twists: Tensor<2>,
    /// Rates of the openings, `[N, 1]`.
    pub openings: Tensor<2>,
}

/// The objective of one batch of drifts; `nodes` are every node's body twists, `[N·K, 6]`.
pub fn twist_loss(
    predicted: &TwistTargets,
    nodes: Tensor<2>,
    targets: &TwistTargets,
    context: &LossContext,
    config: &ObjectiveConfig,
) -> LossParts {
    let [actions, _] = targets.twists.dims();
    let [node_rows, _] = nodes.dims();
    let spread = repeat_rows(targets.twists.clone(), node_rows / actions);
    let consensus = twist_distance_squared(predicted.twists.clone(), targets.twists.clone());
    let openings: Tensor<1> =
        (predicted.openings.clone() - targets.openings.clone()).square().reshape([actions]);
    config.combine(consensus, twist_distance_squared(nodes, spread), openings, context)
}
