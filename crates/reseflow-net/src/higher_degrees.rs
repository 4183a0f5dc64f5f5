//! What features of degrees above 1 add to the convolutions among the centres.
//!
//! Beside each convolution of degrees 0 and 1 runs one of degrees 0 … l_max on a few channels (Tensor Field Networks, arXiv 1802.08219),
//! ended by gates. It sees the centres' scalars and vectors, narrowed, and in the higher degrees what the ones before it said; what it
//! says in degrees 0 and 1 is widened and joins the message. The first makes the higher degrees and the last uses them up, so heat maps,
//! nodes and decoder are those of any network.

use burn::module::Module;
use burn::tensor::{Device, Tensor};
use rand::Rng;

use crate::Features;
use crate::degrees::{
    EdgeFrames, FiberFeatures, FiberLinear, FiberLinearConfig, GatedNonlinearity, GatedNonlinearityConfig,
    RadialMlpConfig, TensorProductConvolution, TensorProductConvolutionConfig, UniformFiber,
};

/// The centres have this many times the channels of these convolutions, which have a matrix for every path, edge and pair of channels.
const CHANNELS_DIV: usize = 4;

/// Hidden width of the radial networks.
const RADIAL_HIDDEN: usize = 32;

/// Sizes of [`HigherDegrees`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct HigherDegreesConfig {
    /// The highest degree l_max, at least 2.
    pub(crate) max_degree: usize,
    /// Channels C of the centres' scalars and vectors.
    pub(crate) channels: usize,
    /// Convolutions, at least 2.
    pub(crate) layers: usize,
    /// Radial basis functions R.
    pub(crate) radial: usize,
}

/// The convolutions of one encoder; see the module's description.
#[derive(Module, Debug)]
pub(crate) struct HigherDegrees {
    layers: Vec<Layer>,
}

#[derive(Module, Debug)]
struct Layer {
    narrow: FiberLinear,
    convolution: TensorProductConvolution,
    gates: GatedNonlinearity,
    widen: FiberLinear,
}

impl HigherDegreesConfig {
    /// Draws the weights.
    pub(crate) fn init<R: Rng + ?Sized>(&self, device: &Device, rng: &mut R) -> HigherDegrees {
        let channels = (self.channels / CHANNELS_DIV).max(1);
        let narrow = |max_degree| UniformFiber { max_degree, channels };
        let vectors = UniformFiber { max_degree: 1, channels: self.channels };
        let radial = RadialMlpConfig { radial: self.radial, hidden: RADIAL_HIDDEN };
        let map = |input: UniformFiber, output: UniformFiber| FiberLinearConfig {
            input: input.fiber(),
            output: output.fiber(),
            bias: false,
        };
        let layer = |index: usize| {
            let input = narrow(if index == 0 { 1 } else { self.max_degree });
            let output = narrow(if index + 1 == self.layers { 1 } else { self.max_degree });
            Layer {
                narrow: map(vectors, narrow(1)).init(device, rng),
                convolution: TensorProductConvolutionConfig { input, output, radial }.init(device, rng),
                gates: GatedNonlinearityConfig { fiber: output.fiber() }.init(device, rng),
                widen: map(narrow(1), vectors).init(device, rng),
            }
        };
        HigherDegrees { layers: (0..self.layers).map(layer).collect() }
    }
}

impl HigherDegrees {
    /// What convolution `layer` adds to the message, and the higher degrees after it.
    ///
    /// # Shapes
    /// - `features`: scalars `[P, C]`, vectors `[3, P, C]`
    /// - `higher`: degrees 2 … l_max as the convolution before left them, none for the first
    /// - output: scalars `[P, C]`, vectors `[3, P, C]`; degrees 2 … l_max, none after the last
    ///
    /// # Panics
    /// Where a tensor has another shape, the edges have another radial basis, or their frames are of lower degrees.
    pub(crate) fn forward(
        &self,
        layer: usize,
        features: &Features,
        higher: Vec<Tensor<3>>,
        frames: &EdgeFrames,
    ) -> (Features, Vec<Tensor<3>>) {
        let Layer { narrow, convolution, gates, widen } = &self.layers[layer];
        let mut input = narrow.forward(&FiberFeatures::from(features.clone()));
        input.degrees.extend(higher.iter().cloned());
        let mut output = gates.forward(convolution.forward(&input, frames));
        let said = output.degrees.split_off(2);
        let left = if higher.is_empty() {
            said
        } else {
            said.into_iter().zip(higher).map(|(said, before)| said + before).collect()
        };
        let widened = widen.forward(&output);
        (Features { scalars: widened.scalars(), vectors: widened.degrees[1].clone() }, left)
    }
}
