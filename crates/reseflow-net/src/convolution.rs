//! Tensor-product convolution of degrees 0 and 1 along the edges of a neighbour graph.
//!
//! A message from j to i is the sum over the paths l_in ⊗ l_edge → l_out (0⊗0→0, 1⊗1→0, 0⊗1→1, 1⊗0→1, 1⊗1→1), each weighted per
//! channel by a function of what is invariant on the edge: its length and the scalars at its two ends (after Tensor Field
//! Networks, arXiv 1802.08219). Receivers take the envelope-weighted *mean*, so the output does not scale with the density.

use burn::module::Module;
use burn::nn::Linear;
use burn::tensor::{Device, Tensor};
use rand::Rng;

use crate::init::linear;
use crate::message::{EdgeActivations, fused};
use crate::{EdgeTensors, Features};

/// Sizes of a [`Convolution`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConvolutionConfig {
    /// Channels C of both degrees, at both ends.
    pub channels: usize,
    /// Radial basis functions R.
    pub radial: usize,
    /// Whether sources carry vectors; without, only the two paths from scalars exist.
    pub source_vectors: bool,
}

/// One convolution; see the module's description.
#[derive(Module, Debug)]
pub struct Convolution {
    source: Linear,
    receiver: Linear,
    edge: Linear,
    paths: Linear,
}

impl ConvolutionConfig {
    /// Draws the weights.
    pub fn init<R: Rng + ?Sized>(&self, device: &Device, rng: &mut R) -> Convolution {
        let channels = self.channels;
        let paths = if self.source_vectors { 5 } else { 2 };
        Convolution {
            source: linear([channels, channels], 1.0, false, device, rng),
            receiver: linear([channels, channels], 1.0, false, device, rng),
            edge: linear([self.radial, channels], 1.0, true, device, rng),
            paths: linear([channels, paths * channels], 1.0, false, device, rng),
        }
    }
}

impl Convolution {
    /// The mean message at every receiver.
    ///
    /// # Shapes
    /// - `sources`: S nodes, scalars `[S, C]` and, where the config says so, vectors `[3, S, C]`
    /// - `receiver_scalars`: `[P, C]`
    /// - output: scalars `[P, C]`, vectors `[3, P, C]`
    ///
    /// # Panics
    /// Where a tensor has another shape, or the edges have another radial basis.
    pub fn forward(&self, sources: &Features, receiver_scalars: Tensor<2>, edges: &EdgeTensors) -> Features {
        // What both ends contribute is linear, so it is computed at the nodes and only then spread over the edges.
        let activations = EdgeActivations {
            sources: self.source.forward(sources.scalars.clone()),
            receivers: self.receiver.forward(receiver_scalars),
            edges: self.edge.forward(edges.radial.clone()),
            matrix: self.paths.weight.val(),
        };
        fused(sources, activations, edges)
    }
}
