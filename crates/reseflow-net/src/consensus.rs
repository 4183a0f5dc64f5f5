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
    /// Every node's trajectory, or its half-turn about the approach axes where that begins nearer to a gripper that closes along
    /// `closing`, `[3, B, 1]`; N counts the poses of B trajectories one after the other.
    pub(crate) fn nearer_half_turn(self, closing: &Tensor<3>) -> Self {
        let ([_, rows, nodes], [_, scenes, _]) = (self.first.dims(), closing.dims());
        let steps = rows / scenes;
        let begin =
            |column: &Tensor<3>| column.clone().reshape([3, scenes, steps, nodes]).narrow(2, 0, 1).detach();
        let (first, second) = (begin(&self.first), begin(&self.second));
        let closing = closing.clone().reshape([3, scenes, 1, 1]);
        let dot = |a: &Tensor<4>, b: &Tensor<4>| (a.clone() * b.clone()).sum_dim(0);
        // The second column's part across the first, along the closing direction, times ‖first‖².
        let along =
            dot(&second, &closing) * dot(&first, &first) - dot(&second, &first) * dot(&first, &closing);
        let sign = along.ones_like().mask_fill(along.lower_elem(0.0), -1.0);
        let turned = |column: Tensor<3>| {
            (column.reshape([3, scenes, steps, nodes]) * sign.clone()).reshape([3, rows, nodes])
        };
        Self { first: turned(self.first), second: turned(self.second), positions: self.positions }
    }

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
