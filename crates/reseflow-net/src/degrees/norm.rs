//! The norm non-linearity of the SE(3)-Transformer: each feature keeps its direction, and its length becomes a function of the lengths
//! of all channels of its degree, f = silu ∘ layer norm.

use burn::module::Module;
use burn::nn::{LayerNorm, LayerNormConfig};
use burn::tensor::Device;

use super::{Fiber, FiberFeatures};
use crate::silu::silu;

/// Lengths much below this count as zero. Features are of order one; a smaller softness would turn the rounding of a feature that is
/// nearly zero into a visible error of its direction.
const SOFTNESS: f64 = 0.1;

/// Sizes of a [`NormNonlinearity`].
#[derive(Debug, Clone, PartialEq)]
pub struct NormNonlinearityConfig {
    /// Channels in and out.
    pub fiber: Fiber,
}

/// x ↦ f(‖x‖) x/‖x‖, with norms that are smooth at zero.
#[derive(Module, Debug)]
pub struct NormNonlinearity {
    norms: Vec<LayerNorm>,
}

impl NormNonlinearityConfig {
    /// The layer as it starts out: no random weights.
    pub fn init(&self, device: &Device) -> NormNonlinearity {
        let norm =
            |&channels: &usize| LayerNormConfig::new(channels).with_epsilon(SOFTNESS * SOFTNESS).init(device);
        NormNonlinearity { norms: self.fiber.channels.iter().map(norm).collect() }
    }
}

impl NormNonlinearity {
    /// # Shapes
    /// - input and output: by degree `[2l + 1, P, Cₗ]`
    ///
    /// # Panics
    /// Where the input is of another fiber.
    pub fn forward(&self, input: FiberFeatures) -> FiberFeatures {
        input.must_be_of("NormNonlinearity", self.norms.iter().map(|norm| norm.gamma.dims()[0]));
        let norms = input.soft_norms(SOFTNESS);
        let degrees = input.degrees.into_iter().zip(norms).zip(&self.norms);
        let scaled = degrees.map(|((degree, norm), layer)| {
            let length = silu(layer.forward(norm.clone()));
            degree * (length / norm)
        });
        FiberFeatures { degrees: scaled.collect() }
    }
}
