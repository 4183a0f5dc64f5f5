//! Attention over neighbours with invariant weights (SE(3)-Transformers, arXiv 2006.10503).
//!
//! One tensor product makes keys and values along every edge, a linear map makes queries. The inner product of a query and a key
//! is the same in every frame, so queries go into the edges' frames, and only the weighted sum of the values comes back.
//! The softmax carries the graph's envelope, so a neighbour's say fades before it stops being one; and where the envelope's sum over all
//! neighbours fades, because all of them are about to stop being such, so does what is gathered.

use burn::module::Module;
use burn::tensor::activation::softmax;
use burn::tensor::{Device, Tensor};
use rand::Rng;

use super::edge_message::fused;
use super::{
    EdgeFrames, EdgeProduct, FiberFeatures, FiberLinear, FiberLinearConfig, RadialMlp, RadialMlpConfig,
    UniformFiber,
};
use crate::NetError;

/// Keeps the weights finite where no neighbour has any; f32 holds its square, by which gradients are divided.
const EPSILON: f64 = 1e-15;

/// Sizes of a [`NeighborAttention`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NeighborAttentionConfig {
    /// Features of senders and receivers, which are the same points.
    pub input: UniformFiber,
    /// The values, and what comes out. Keys and queries have as many channels, in the degrees that the input has too.
    pub output: UniformFiber,
    /// Heads, a divisor of the output's channels.
    pub heads: usize,
    /// The function of the length.
    pub radial: RadialMlpConfig,
}

/// One attention layer; see the module's description.
#[derive(Module, Debug)]
pub struct NeighborAttention {
    radial: RadialMlp,
    query: FiberLinear,
    #[module(skip)]
    product: EdgeProduct,
    #[module(skip)]
    heads: usize,
}

impl NeighborAttentionConfig {
    /// Checks that the heads divide the channels.
    ///
    /// # Errors
    /// [`NetError::Config`] where they do not.
    pub fn validate(&self) -> Result<(), NetError> {
        let channels = self.output.channels;
        if self.heads == 0 || channels == 0 || !channels.is_multiple_of(self.heads) {
            let heads = self.heads;
            return Err(NetError::Config(format!(
                "heads must divide the {channels} channels of the values, got {heads}"
            )));
        }
        Ok(())
    }

    /// Keys, then values.
    fn product(&self) -> EdgeProduct {
        let max_degree = self.input.max_degree.min(self.output.max_degree);
        let keys = UniformFiber { max_degree, channels: self.output.channels };
        EdgeProduct { input: self.input, outputs: vec![keys, self.output] }
    }

    /// Draws the weights.
    ///
    /// # Errors
    /// As [`Self::validate`].
    pub fn init<R: Rng + ?Sized>(&self, device: &Device, rng: &mut R) -> Result<NeighborAttention, NetError> {
        self.validate()?;
        let product = self.product();
        let query =
            FiberLinearConfig { input: self.input.fiber(), output: product.outputs[0].fiber(), bias: false };
        Ok(NeighborAttention {
            radial: self.radial.init(&product, device, rng),
            query: query.init(device, rng),
            product,
            heads: self.heads,
        })
    }
}

impl NeighborAttention {
    /// What every point gathers from its neighbours.
    ///
    /// # Shapes
    /// - `features`: P points, the input's fiber
    /// - output: P points, the output's fiber
    ///
    /// # Panics
    /// Where the features are of another fiber, there are not as many points as receivers, the edges have another radial basis, or their
    /// frames are of lower degrees than input or output.
    pub fn forward(&self, features: &FiberFeatures, edges: &EdgeFrames) -> FiberFeatures {
        let radial = self.radial.forward(edges.edges.radial.clone(), edges.presence.clone());
        let mut messages = fused(&self.product, features, radial, self.radial.weight(), edges);
        let (values, keys) = (messages.remove(1), messages.remove(0));
        let [count, rows, channels] = values.dims();
        let (heads, width) = (self.heads, channels / self.heads);
        let attention = self.weights(features, keys, edges).reshape([count, 1, heads, 1]);
        let weighed =
            (values.reshape([count, rows, heads, width]) * attention).reshape([count, rows, channels]);
        edges.sum_at_receivers(weighed, self.product.outputs[1].max_degree)
    }

    /// Invariant weights of every receiver's edges, which sum to what the envelope's do: one, and less where all neighbours are about to
    /// stop being such, `[E, heads]`.
    fn weights(&self, features: &FiberFeatures, keys: Tensor<3>, edges: &EdgeFrames) -> Tensor<2> {
        let [count, rows, channels] = keys.dims();
        let (heads, per_receiver) = (self.heads, edges.edges.per_receiver);
        let receivers = count / per_receiver;
        let queries = edges.at_receivers(&self.query.forward(features), self.product.outputs[0].max_degree);
        let width = channels / heads;
        let products = (queries.narrow(1, 0, rows) * keys).sum_dim(1).reshape([count, heads, width]);
        // A product, because the gradient of burn's division by a number is rounded to f32.
        let scale = ((rows * width) as f64).sqrt().recip();
        let logits = products.sum_dim(2).mul_scalar(scale).reshape([receivers, per_receiver, heads]);
        let envelope = edges.edges.weights.clone().reshape([receivers, per_receiver, 1]);
        let weights = softmax(logits, 1) * envelope.clone();
        let total = weights.clone().sum_dim(1).add_scalar(EPSILON);
        (weights * (envelope.sum_dim(1) / total)).reshape([count, heads])
    }
}
