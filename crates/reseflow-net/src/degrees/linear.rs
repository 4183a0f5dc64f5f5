//! Linear maps between channels of the same degree, the only ones that commute with rotations.

use burn::module::Module;
use burn::nn::Linear;
use burn::tensor::Device;
use rand::Rng;

use super::{Fiber, FiberFeatures};
use crate::init::linear;

/// Sizes of a [`FiberLinear`].
#[derive(Debug, Clone, PartialEq)]
pub struct FiberLinearConfig {
    /// Channels in; degrees that the output lacks are not looked at.
    pub input: Fiber,
    /// Channels out, in degrees that the input has.
    pub output: Fiber,
    /// Whether scalars get a bias.
    pub bias: bool,
}

/// One matrix a degree.
#[derive(Module, Debug)]
pub struct FiberLinear {
    degrees: Vec<Linear>,
}

impl FiberLinearConfig {
    /// Draws the weights.
    ///
    /// # Panics
    /// Where the output has a degree that the input lacks.
    pub fn init<R: Rng + ?Sized>(&self, device: &Device, rng: &mut R) -> FiberLinear {
        let [input, output] = [&self.input, &self.output].map(Fiber::max_degree);
        assert!(output <= input, "FiberLinear: expected an output of degrees up to {input}, got {output}");
        let channels = self.input.channels.iter().zip(&self.output.channels);
        let degree =
            |(degree, (&input, &output))| linear([input, output], 1.0, self.bias && degree == 0, device, rng);
        FiberLinear { degrees: channels.enumerate().map(degree).collect() }
    }
}

impl FiberLinear {
    /// # Shapes
    /// - input: by degree `[2l + 1, P, Cₗ]`
    /// - output: by degree `[2l + 1, P, C'ₗ]`
    ///
    /// # Panics
    /// Where the input lacks a degree of the output, or has another shape.
    pub fn forward(&self, input: &FiberFeatures) -> FiberFeatures {
        input.must_have("FiberLinear", self.degrees.iter().map(|linear| linear.weight.dims()[0]));
        let degrees = self.degrees.iter().zip(&input.degrees);
        FiberFeatures { degrees: degrees.map(|(linear, degree)| linear.forward(degree.clone())).collect() }
    }
}
