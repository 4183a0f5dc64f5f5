//! The baseline's objective: the mean rotation angle and the mean distance, neither squared.

use burn::tensor::Tensor;
use reseflow_flow::{EndpointTargets, LENGTH_SCALE_M};
use reseflow_lie_tensor::{SE3Tensor, geodesic_distance};

/// Σ w (θ + ‖Δp‖/ℓ + c |Δopening|) / Σ w, over N actions with weights `[N]`, `[1]`.
///
/// The angle between Ĥ X^k and X⁰ is that between Ĥ and its target; it is taken by `atan2`, so that it has a gradient however small.
pub(super) fn left_factor_loss(
    predicted: &EndpointTargets,
    targets: &EndpointTargets,
    weights: Tensor<1>,
    opening: f64,
) -> Tensor<1> {
    let poses = |of: &EndpointTargets| SE3Tensor {
        rotation: of.rotations.clone(),
        translation: of.positions_m.clone(),
    };
    let apart = geodesic_distance(&poses(predicted), &poses(targets));
    let [actions] = weights.dims();
    let openings: Tensor<1> =
        (predicted.openings.clone() - targets.openings.clone()).abs().reshape([actions]);
    let errors =
        apart.rotation_rad + apart.translation_m.div_scalar(LENGTH_SCALE_M) + openings.mul_scalar(opening);
    (errors * weights.clone()).sum() / weights.sum()
}
