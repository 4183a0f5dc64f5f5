//! Layer normalisation that commutes with rotations (Equiformer, arXiv 2206.11990): scalars as usual, every other degree divided by
//! the root mean square of its components over the channels, with no mean taken off.

use burn::module::{Module, Param};
use burn::nn::{LayerNorm, LayerNormConfig};
use burn::tensor::{Device, Tensor, TensorData};

use super::{Fiber, FiberFeatures};

/// Keeps the scale of features that are all zero.
const EPSILON: f64 = 1e-5;

/// Sizes of a [`FiberLayerNorm`].
#[derive(Debug, Clone, PartialEq)]
pub struct FiberLayerNormConfig {
    /// Channels in and out.
    pub fiber: Fiber,
}

/// One scale for each channel, and an offset for each scalar.
#[derive(Module, Debug)]
pub struct FiberLayerNorm {
    scalars: LayerNorm,
    scales: Vec<Param<Tensor<1>>>,
}

impl FiberLayerNormConfig {
    /// The layer as it starts out, with scales of one.
    pub fn init(&self, device: &Device) -> FiberLayerNorm {
        let scale =
            |&channels: &usize| Param::from_data(TensorData::new(vec![1.0; channels], [channels]), device);
        FiberLayerNorm {
            scalars: LayerNormConfig::new(self.fiber.channels[0]).init(device),
            scales: self.fiber.channels.iter().skip(1).map(scale).collect(),
        }
    }
}

impl FiberLayerNorm {
    /// # Shapes
    /// - input and output: by degree `[2l + 1, P, Cₗ]`
    ///
    /// # Panics
    /// Where the input is of another fiber.
    pub fn forward(&self, input: FiberFeatures) -> FiberFeatures {
        let scales = self.scales.iter().map(|scale| scale.dims()[0]);
        let channels: Vec<usize> = std::iter::once(self.scalars.gamma.dims()[0]).chain(scales).collect();
        input.must_be_of("FiberLayerNorm", channels.into_iter());
        let mut degrees = input.degrees.into_iter();
        let scalars = degrees.next().map(|scalars| self.scalars.forward(scalars));
        let others = degrees.zip(&self.scales).map(|(degree, scale)| {
            let [components, _, channels] = degree.dims();
            let squares =
                degree.clone().square().sum_dim(0).mean_dim(2).mul_scalar((components as f64).recip());
            degree / squares.add_scalar(EPSILON).sqrt() * scale.val().reshape([1, 1, channels])
        });
        FiberFeatures { degrees: scalars.into_iter().chain(others).collect() }
    }
}
