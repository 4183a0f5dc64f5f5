//! K heat maps over the points of a scene, made of scalars and norms, under which features of every degree are averaged.

use burn::module::Module;
use burn::nn::Linear;
use burn::tensor::activation::softmax;
use burn::tensor::{Device, Tensor};
use rand::Rng;

use super::{Fiber, FiberFeatures};
use crate::init::linear;
use crate::shape::must_be;

/// Sizes of a [`FiberHeatMap`].
#[derive(Debug, Clone, PartialEq)]
pub struct FiberHeatMapConfig {
    /// The features that the maps look at.
    pub fiber: Fiber,
    /// Nodes K.
    pub nodes: usize,
}

/// Pools points into nodes; [`crate::HeatMap`] for all degrees.
#[derive(Module, Debug)]
pub struct FiberHeatMap {
    logits: Linear,
    #[module(skip)]
    channels: Vec<usize>,
}

impl FiberHeatMapConfig {
    /// Draws the weights; the gain makes the maps start out distinct.
    pub fn init<R: Rng + ?Sized>(&self, device: &Device, rng: &mut R) -> FiberHeatMap {
        let inputs = self.fiber.channels.iter().sum();
        let logits = linear([inputs, self.nodes], 4.0, false, device, rng);
        FiberHeatMap { logits, channels: self.fiber.channels.clone() }
    }
}

impl FiberHeatMap {
    /// # Shapes
    /// - `features`: B·M points, M for each scene
    /// - output: weights `[B, K, M]`, each row a distribution over the points of a scene
    ///
    /// # Panics
    /// Where the features are of another fiber, or no whole number of points for each scene.
    pub fn weights(&self, scenes: usize, features: &FiberFeatures) -> Tensor<3> {
        features.must_be_of("FiberHeatMap", self.channels.iter().copied());
        must_be(
            "FiberHeatMap: points left over by whole scenes",
            Some(0),
            features.points().checked_rem(scenes),
        );
        let scalars = features.degrees[0].clone();
        let norms = features.soft_norms(1e-3).into_iter().skip(1);
        let invariants = Tensor::cat(std::iter::once(scalars).chain(norms).collect(), 2);
        let logits = self.logits.forward(invariants);
        let [_, rows, nodes] = logits.dims();
        softmax(logits.reshape([scenes, rows / scenes, nodes]).swap_dims(1, 2), 2)
    }

    /// Averages under the heat maps.
    ///
    /// # Shapes
    /// - `weights`: `[B, K, M]`
    /// - `features`: B·M points
    /// - output: B·K nodes with the same fiber
    ///
    /// # Panics
    /// Where there are not B·M points.
    pub fn pool(weights: &Tensor<3>, features: &FiberFeatures) -> FiberFeatures {
        let [scenes, nodes, points] = weights.dims();
        must_be("FiberHeatMap: points of all scenes", scenes * points, features.points());
        let degree = |degree: &Tensor<3>| {
            let [components, _, channels] = degree.dims();
            weights
                .clone()
                .reshape([1, scenes, nodes, points])
                .matmul(degree.clone().reshape([components, scenes, points, channels]))
                .reshape([components, scenes * nodes, channels])
        };
        FiberFeatures { degrees: features.degrees.iter().map(degree).collect() }
    }
}
