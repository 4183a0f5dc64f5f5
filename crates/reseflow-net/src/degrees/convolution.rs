//! Tensor-product convolution: every receiver takes the envelope-weighted mean of what its neighbours send, each feature multiplied
//! with the harmonics of its edge and weighted by functions of the edge's length (Tensor Field Networks, arXiv 1802.08219).

use burn::module::Module;
use burn::tensor::{Device, Tensor};
use rand::Rng;

use super::edge_message::fused;
use super::{
    EdgeFrames, EdgeHarmonics, EdgeProduct, FiberFeatures, RadialMlp, RadialMlpConfig, UniformFiber,
};

/// Sizes of a [`TensorProductConvolution`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TensorProductConvolutionConfig {
    /// The sources' features.
    pub input: UniformFiber,
    /// The receivers'.
    pub output: UniformFiber,
    /// The function of the length.
    pub radial: RadialMlpConfig,
}

/// One convolution; see the module's description.
#[derive(Module, Debug)]
pub struct TensorProductConvolution {
    radial: RadialMlp,
    #[module(skip)]
    product: EdgeProduct,
}

impl TensorProductConvolutionConfig {
    /// Draws the weights.
    pub fn init<R: Rng + ?Sized>(&self, device: &Device, rng: &mut R) -> TensorProductConvolution {
        let product = EdgeProduct { input: self.input, outputs: vec![self.output] };
        TensorProductConvolution { radial: self.radial.init(&product, device, rng), product }
    }
}

impl TensorProductConvolution {
    /// The mean message at every receiver, computed in the edges' frames.
    ///
    /// # Shapes
    /// - `sources`: S points, the input's fiber
    /// - output: P points, the output's fiber
    ///
    /// # Panics
    /// Where the sources are of another fiber, the edges have another radial basis, or their frames are of lower degrees than input or
    /// output.
    pub fn forward(&self, sources: &FiberFeatures, edges: &EdgeFrames) -> FiberFeatures {
        let message =
            fused(&self.product, sources, self.radial_features(edges), self.radial.weight(), edges).remove(0);
        edges.sum_at_receivers(message, self.product.outputs[0].max_degree)
    }

    /// The same path by path in the world's frame: slow, and the oracle of [`Self::forward`].
    ///
    /// # Shapes
    /// As [`Self::forward`]; `harmonics` up to degree l_in + l_out.
    ///
    /// # Panics
    /// As [`Self::forward`], and where `harmonics` are of lower degrees.
    pub fn forward_by_paths(
        &self,
        sources: &FiberFeatures,
        edges: &EdgeFrames,
        harmonics: &EdgeHarmonics,
    ) -> FiberFeatures {
        let weights = self.radial_features(edges).matmul(self.radial.weight());
        let messages = self.product.forward_by_paths(sources, &weights, edges, harmonics).remove(0);
        let per_receiver = edges.edges.per_receiver;
        let sum = |message: Tensor<3>| {
            let [edges, components, channels] = message.dims();
            let receivers = edges / per_receiver;
            message
                .reshape([receivers, per_receiver, components * channels])
                .sum_dim(1)
                .reshape([receivers, components, channels])
                .swap_dims(0, 1)
        };
        FiberFeatures { degrees: messages.into_iter().map(sum).collect() }
    }

    /// What kernel weights are made of, the mean's weights among them, `[E, H]`.
    fn radial_features(&self, edges: &EdgeFrames) -> Tensor<2> {
        let mean = edges.edges.weights.clone() * edges.presence.clone();
        self.radial.forward(edges.edges.radial.clone(), mean)
    }
}
