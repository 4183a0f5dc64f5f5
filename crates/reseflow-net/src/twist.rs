//! What the decoder says in twist form: the paper's ξ_θ, a velocity of every noisy pose along the flow, in that pose's own frame.
//!
//! A node k at x_k gives two vectors of the world's frame, an angular velocity ω_k and a velocity v_k at the node, so the gripper's
//! origin p moves with v_k + ω_k × (p − x_k), as on a rigid body that turns about the node. Contracted with the axes of the noisy
//! pose these are invariant components, (Rᵀω_k, Rᵀv), and so are the numbers that the token's scalars add to them. No velocity changes
//! when the scene and the poses are moved.

use burn::tensor::Tensor;
use burn::tensor::activation::softmax;

use crate::consensus::root;
use crate::tokens::OFFSET_SCALE_M;
use crate::{Decoder, Features, SceneContext, TokenBatch, cross};

/// Components of a twist.
pub(crate) const TWIST_WIDTH: usize = 6;

/// The predicted velocities of the noisy trajectories, per unit of flow time.
#[derive(Debug, Clone)]
pub struct TwistPrediction {
    /// Consensus body twists (ω, ρ), rad and metres, in the frames of the noisy poses, `[B·L, 6]`.
    pub twists: Tensor<2>,
    /// Rates of the openings, `[B·L, 1]`.
    pub openings: Tensor<2>,
    /// Every node's body twists in the same frames, `[B·L·K, 6]`.
    pub node_twists: Tensor<2>,
    /// Consensus weights, `[B·L, K]`.
    pub weights: Tensor<2>,
}

impl TwistPrediction {
    /// The weighted root mean square distance from the nodes' twists to the consensus, radians and metres in squares as in D_geo,
    /// per unit of flow time, `[B·L]`: how unsure the network is.
    pub fn spread(&self) -> Tensor<1> {
        let [rows, nodes] = self.weights.dims();
        let apart = self.node_twists.clone().reshape([rows, nodes, TWIST_WIDTH])
            - self.twists.clone().reshape([rows, 1, TWIST_WIDTH]);
        let squares = apart.square().sum_dim(2).reshape([rows, nodes]);
        root((squares * self.weights.clone()).sum_dim(1).reshape([rows]))
    }
}

impl Decoder {
    /// Twists of every node and their consensus from the tokens' final features.
    ///
    /// # Shapes
    /// - `tokens`: B·L, in the scenes' order
    /// - `features`: scalars `[B·L, D]`, vectors `[3, B·L, V]`
    pub(crate) fn read_out_twists(
        &self,
        context: &SceneContext,
        tokens: &TokenBatch,
        features: Features,
    ) -> TwistPrediction {
        let (nodes, scenes, horizon) = (self.nodes, context.origins_m.len(), tokens.horizon);
        let rows = scenes * horizon;
        let weights = softmax(self.consensus.forward(features.scalars.clone()), 1);
        let openings = self.opening.forward(features.scalars.clone());

        // [3, B, L, 2, K]: angular velocity, and velocity at the node over the offset scale.
        let velocities = self.poses.forward(features.vectors).reshape([3, scenes, horizon, 2 * nodes])
            + context.skip.clone().reshape([3, scenes, 1, 2 * nodes]);
        let velocities = velocities.reshape([3, rows, 2, nodes]);
        let part = |index: usize| velocities.clone().narrow(2, index, 1).reshape([3, rows, nodes]);
        let (angular, at_node) = (part(0), part(1));
        let position = tokens.vectors.clone().narrow(2, 3, 1).reshape([3, scenes, horizon, 1]);
        let from_node = (position - context.node_positions.clone().reshape([3, scenes, 1, nodes]))
            .reshape([3, rows, nodes]);
        let linear = at_node + cross(angular.clone(), from_node);

        // [B·L, K, 3]: components along the three axes of R, which are the tokens' first vectors.
        let axes = tokens.vectors.clone().narrow(2, 0, 3).swap_dims(0, 1);
        let in_body = |vectors: Tensor<3>| vectors.permute([1, 2, 0]).matmul(axes.clone());
        let twists = Tensor::cat(vec![in_body(angular), in_body(linear)], 2);
        let twists = match &self.twists {
            Some(from_scalars) => {
                twists + from_scalars.forward(features.scalars).reshape([rows, nodes, TWIST_WIDTH])
            }
            None => twists,
        };
        let (angular, linear) = (twists.clone().narrow(2, 0, 3), twists.narrow(2, 3, 3));
        let twists = Tensor::cat(vec![angular, linear.mul_scalar(OFFSET_SCALE_M)], 2);
        let consensus = (twists.clone() * weights.clone().reshape([rows, nodes, 1])).sum_dim(1);
        TwistPrediction {
            twists: consensus.reshape([rows, TWIST_WIDTH]),
            openings,
            node_twists: twists.reshape([rows * nodes, TWIST_WIDTH]),
            weights,
        }
    }
}
