//! What SE3ManiNet is taught with: the error of the pose on which the nodes agree, those of every node, and the overlap of their maps.

use burn::tensor::Tensor;
use reseflow_lie_tensor::{SE3Tensor, chordal_distance_squared};

use super::ManiNodes;
use crate::shape::must_be;

/// The weights of [`ManiNodes::loss`]; the consensus has weight 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ManiLossConfig {
    /// The length ℓ in metres that counts as much as a radian.
    pub length_m: f64,
    /// Weight of the mean over the nodes, so that none idles.
    pub nodes: f64,
    /// Weight of the heat maps' overlap, so that nodes do not collapse.
    pub overlap: f64,
}

impl Default for ManiLossConfig {
    fn default() -> Self {
        Self { length_m: 0.15, nodes: 0.5, overlap: 0.01 }
    }
}

impl ManiNodes {
    /// The mean over the scenes of e² = ½‖R̂ − R‖²_F + ‖p̂ − p‖²/ℓ² of the consensus, with that of every node and the overlap, `[1]`.
    ///
    /// # Shapes
    /// - `targets`: B poses, translations in metres relative to [`ManiNodes::centroids_m`]
    ///
    /// # Panics
    /// Where there is not one target for each scene.
    pub fn loss(&self, targets: &SE3Tensor, config: &ManiLossConfig) -> Tensor<1> {
        let [scenes, nodes] = self.weights.dims();
        must_be("ManiNodes: targets", [scenes, 3], targets.translation.dims());
        let rows = scenes * nodes;
        let wanted = SE3Tensor {
            rotation: (targets.rotation.clone().reshape([scenes, 1, 9]))
                .repeat_dim(1, nodes)
                .reshape([rows, 3, 3]),
            translation: (targets.translation.clone().reshape([scenes, 1, 3]))
                .repeat_dim(1, nodes)
                .reshape([rows, 3]),
        };
        let error = |rotations: &Tensor<3>, positions_m: &Tensor<2>, wanted: &SE3Tensor| {
            let away = (positions_m.clone() - wanted.translation.clone()).square().sum_dim(1);
            let turned = chordal_distance_squared(rotations.clone(), wanted.rotation.clone());
            turned.mean().mul_scalar(0.5) + away.mean().mul_scalar(config.length_m.powi(-2))
        };
        error(&self.consensus_rotations, &self.consensus_positions_m, targets)
            + error(&self.rotations, &self.translations_m, &wanted).mul_scalar(config.nodes)
            + self.overlap().mul_scalar(config.overlap)
    }
}
