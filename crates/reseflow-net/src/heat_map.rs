//! K heat maps over the centres of a scene: each gives a node, a convex combination of positions and features.

use burn::module::Module;
use burn::nn::Linear;
use burn::tensor::activation::softmax;
use burn::tensor::{Device, Tensor};
use rand::Rng;

use crate::Features;
use crate::init::linear;

/// Sizes of a [`HeatMap`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeatMapConfig {
    /// Channels C of both degrees.
    pub channels: usize,
    /// Nodes K.
    pub nodes: usize,
}

/// Pools centres into nodes.
#[derive(Module, Debug)]
pub struct HeatMap {
    logits: Linear,
}

impl HeatMapConfig {
    /// Draws the weights; the gain makes the maps start out distinct.
    pub fn init<R: Rng + ?Sized>(&self, device: &Device, rng: &mut R) -> HeatMap {
        HeatMap { logits: linear([2 * self.channels, self.nodes], 4.0, false, device, rng) }
    }
}

impl HeatMap {
    /// # Shapes
    /// - `features`: scalars `[B·M, C]`, vectors `[3, B·M, C]`
    /// - output: weights `[B, K, M]`, each row a distribution over the centres
    ///
    /// # Panics
    /// Where a tensor has another shape, or no whole number of rows for each scene.
    pub fn weights(&self, scenes: usize, features: &Features) -> Tensor<3> {
        let norms = crate::dot(features.vectors.clone(), features.vectors.clone()).add_scalar(1e-6).sqrt();
        let logits = self.logits.forward(Tensor::cat(vec![features.scalars.clone(), norms], 1));
        let [rows, nodes] = logits.dims();
        softmax(logits.reshape([scenes, rows / scenes, nodes]).swap_dims(1, 2), 2)
    }

    /// Averages under the heat maps.
    ///
    /// # Shapes
    /// - `weights`: `[B, K, M]`
    /// - `features`: scalars `[B·M, C]`, vectors `[3, B·M, C']`
    /// - output: scalars `[B·K, C]`, vectors `[3, B·K, C']`
    ///
    /// # Panics
    /// Where a tensor has another shape.
    pub fn pool(weights: &Tensor<3>, features: Features) -> Features {
        let [scenes, nodes, centres] = weights.dims();
        let ([_, scalar_width], [_, _, vector_width]) = (features.scalars.dims(), features.vectors.dims());
        Features {
            scalars: weights
                .clone()
                .matmul(features.scalars.reshape([scenes, centres, scalar_width]))
                .reshape([scenes * nodes, scalar_width]),
            vectors: weights
                .clone()
                .reshape([1, scenes, nodes, centres])
                .matmul(features.vectors.reshape([3, scenes, centres, vector_width]))
                .reshape([3, scenes * nodes, vector_width]),
        }
    }

    /// Mean overlap Σₘ wₖₘ wⱼₘ / √(Σ wₖ² Σ wⱼ²) over pairs of different nodes, in \[0, 1\]; a penalty that keeps nodes apart.
    ///
    /// # Shapes
    /// - `weights`: `[B, K, M]`
    /// - output: `[1]`
    pub fn overlap(weights: &Tensor<3>) -> Tensor<1> {
        let [scenes, nodes, _] = weights.dims();
        let norm = weights.clone().square().sum_dim(2).add_scalar(1e-12).sqrt();
        let unit = weights.clone() / norm;
        let gram = unit.clone().matmul(unit.swap_dims(1, 2));
        let pairs = (scenes * nodes * (nodes - 1).max(1)) as f64;
        // The diagonal of the Gram matrix is one for every node.
        gram.sum().sub_scalar((scenes * nodes) as f64).mul_scalar(pairs.recip())
    }
}
