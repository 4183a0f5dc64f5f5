//! Poses that several nodes predict, their consensus, and how far the nodes are apart.
//!
//! A node's pose is two columns, made a rotation by Gram–Schmidt, and a position. The consensus averages columns and positions under
//! invariant weights and orthonormalises once.

use burn::tensor::Tensor;
use reseflow_lie_tensor::{SE3Tensor, geodesic_distance, gram_schmidt};

/// What K nodes say of N poses.
pub(crate) struct NodePoses {
    /// First columns, not normalised, `[3, N, K]`.
    pub(crate) first: Tensor<3>,
    /// Second columns, `[3, N, K]`.
    pub(crate) second: Tensor<3>,
    /// Positions, `[3, N, K]`.
    pub(crate) positions: Tensor<3>,
}

impl NodePoses {
    /// Rotations `[N, 3, 3]` and positions `[N, 3]` on which the nodes agree under `weights`, `[N, K]`.
    pub(crate) fn consensus(&self, weights: &Tensor<2>) -> (Tensor<3>, Tensor<2>) {
        let [rows, nodes] = weights.dims();
        let averaged = |values: &Tensor<3>| {
            (values.clone() * weights.clone().reshape([1, rows, nodes]))
                .sum_dim(2)
                .reshape([3, rows])
                .swap_dims(0, 1)
        };
        let rotations = gram_schmidt(averaged(&self.first), averaged(&self.second));
        (rotations, averaged(&self.positions))
    }

    /// Every node's rotation, `[N·K, 3, 3]`, and position, `[N·K, 3]`.
    pub(crate) fn poses(self) -> (Tensor<3>, Tensor<2>) {
        let [_, rows, nodes] = self.first.dims();
        let rows_of = |values: Tensor<3>| values.permute([1, 2, 0]).reshape([rows * nodes, 3]);
        (gram_schmidt(rows_of(self.first), rows_of(self.second)), rows_of(self.positions))
    }
}

/// The weighted root mean square of D_geo from K nodes' poses to their consensus, `[N]`: how little the nodes agree.
///
/// # Shapes
/// - `consensus`: N poses; `nodes`: N·K poses
/// - `weights`: `[N, K]`, which sum to one
pub(crate) fn spread(consensus: &SE3Tensor, nodes: &SE3Tensor, weights: &Tensor<2>) -> Tensor<1> {
    let [rows, per_row] = weights.dims();
    let repeated = SE3Tensor {
        rotation: consensus.rotation.clone().reshape([rows, 1, 9]).repeat_dim(1, per_row).reshape([
            rows * per_row,
            3,
            3,
        ]),
        translation: consensus
            .translation
            .clone()
            .reshape([rows, 1, 3])
            .repeat_dim(1, per_row)
            .reshape([rows * per_row, 3]),
    };
    let squares = geodesic_distance(&repeated, nodes).d_geo.square().reshape([rows, per_row]);
    root((squares * weights.clone()).sum_dim(1).reshape([rows]))
}

/// √x, softened so that its slope is finite where nodes agree.
pub(crate) fn root(squares: Tensor<1>) -> Tensor<1> {
    squares.add_scalar(1e-12).sqrt()
}
