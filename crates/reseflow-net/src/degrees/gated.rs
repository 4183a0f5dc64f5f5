//! The gated non-linearity (3D Steerable CNNs, arXiv 1807.02547): scalars go through silu, every other channel is multiplied by a
//! gate in (0, 1) that the scalars decide.

use burn::module::Module;
use burn::nn::Linear;
use burn::tensor::{Device, Tensor};
use rand::Rng;

use super::{Fiber, FiberFeatures};
use crate::init::linear;
use crate::silu::silu;

/// Sizes of a [`GatedNonlinearity`].
#[derive(Debug, Clone, PartialEq)]
pub struct GatedNonlinearityConfig {
    /// Channels in and out.
    pub fiber: Fiber,
}

/// One gate for each channel of degree 1 and above.
#[derive(Module, Debug)]
pub struct GatedNonlinearity {
    gates: Option<Linear>,
    #[module(skip)]
    channels: Vec<usize>,
}

impl GatedNonlinearityConfig {
    /// Draws the weights.
    pub fn init<R: Rng + ?Sized>(&self, device: &Device, rng: &mut R) -> GatedNonlinearity {
        let gates: usize = self.fiber.channels.iter().skip(1).sum();
        let scalars = self.fiber.channels[0];
        let gates = (gates > 0).then(|| linear([scalars, gates], 1.0, true, device, rng));
        GatedNonlinearity { gates, channels: self.fiber.channels.clone() }
    }
}

impl GatedNonlinearity {
    /// # Shapes
    /// - input and output: by degree `[2l + 1, P, Cₗ]`
    ///
    /// # Panics
    /// Where the input is of another fiber.
    pub fn forward(&self, input: FiberFeatures) -> FiberFeatures {
        input.must_be_of("GatedNonlinearity", self.channels.iter().copied());
        // 1/(1 + e⁻ˣ) by the hyperbolic tangent: burn's sigmoid is computed in f32 on ndarray, also where the tensor is f64.
        let open = |gates: Tensor<3>| gates.mul_scalar(0.5).tanh().add_scalar(1.0).mul_scalar(0.5);
        let gates = self.gates.as_ref().map(|gates| open(gates.forward(input.degrees[0].clone())));
        let mut first = 0;
        let degrees = input.degrees.into_iter().enumerate().map(|(degree, features)| match &gates {
            Some(gates) if degree > 0 => {
                let channels = features.dims()[2];
                first += channels;
                features * gates.clone().narrow(2, first - channels, channels)
            }
            _ => silu(features),
        });
        FiberFeatures { degrees: degrees.collect() }
    }
}
