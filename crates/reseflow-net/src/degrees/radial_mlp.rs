//! From the radial basis of an edge's length to the weights of its kernel: two hidden layers with layer normalisation, as in NVIDIA's
//! SE(3)-Transformer.

use burn::module::{Module, Param};
use burn::nn::{LayerNorm, LayerNormConfig, Linear};
use burn::tensor::{Device, Tensor, TensorData};
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

use super::EdgeProduct;
use crate::init::linear;
use crate::shape::must_be;
use crate::silu::silu;

/// Sizes of a [`RadialMlp`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RadialMlpConfig {
    /// Radial basis functions R.
    pub radial: usize,
    /// Hidden width H.
    pub hidden: usize,
}

/// R → H → H → W; see the module's description.
#[derive(Module, Debug)]
pub struct RadialMlp {
    first: Linear,
    first_norm: LayerNorm,
    second: Linear,
    second_norm: LayerNorm,
    weights: Linear,
}

/// 1/√(E silu(x)²) for a standard normal x.
const SILU_GAIN: f64 = 1.676;

impl RadialMlpConfig {
    /// Draws the weights for the kernels of `product`.
    pub fn init<R: Rng + ?Sized>(&self, product: &EdgeProduct, device: &Device, rng: &mut R) -> RadialMlp {
        let Self { radial, hidden } = *self;
        let norm = || LayerNormConfig::new(hidden).init(device);
        let gain = SILU_GAIN / (hidden as f64).sqrt();
        let deviations = product.standard_deviations();
        let mut values = Vec::with_capacity(hidden * deviations.len());
        for _ in 0..hidden {
            values.extend(deviations.iter().map(|deviation| {
                let draw: f64 = StandardNormal.sample(rng);
                gain * deviation * draw
            }));
        }
        let weight = Param::from_data(TensorData::new(values, [hidden, deviations.len()]), device);
        RadialMlp {
            first: linear([radial, hidden], 1.0, true, device, rng),
            first_norm: norm(),
            second: linear([hidden, hidden], SILU_GAIN, true, device, rng),
            second_norm: norm(),
            weights: Linear { weight, bias: None },
        }
    }
}

impl RadialMlp {
    /// What the last layer makes an edge's kernel weights of, times `scale`: a product with [`Self::weight`] are the weights.
    ///
    /// # Shapes
    /// - `radial`: `[E, R]`
    /// - `scale`: `[E, 1]`
    /// - output: `[E, H]`
    ///
    /// # Panics
    /// Where a tensor has another shape.
    pub fn forward(&self, radial: Tensor<2>, scale: Tensor<2>) -> Tensor<2> {
        let [basis, _] = self.first.weight.dims();
        must_be("RadialMlp: radial features", [scale.dims()[0], basis], radial.dims());
        let hidden = silu(self.first_norm.forward(self.first.forward(radial)));
        silu(self.second_norm.forward(self.second.forward(hidden))) * scale
    }

    /// The last layer, `[H, W]`, for the product that [`RadialMlpConfig::init`] was given.
    pub fn weight(&self) -> Tensor<2> {
        self.weights.weight.val()
    }
}
