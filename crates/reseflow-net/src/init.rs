//! Weight initialisation from a random stream on the host, so that one seed gives the same weights on every device.

use burn::module::Param;
use burn::nn::Linear;
use burn::tensor::{Device, Tensor, TensorData};
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

/// A tensor parameter of independent normal draws with standard deviation `std`.
pub fn normal<const D: usize, R: Rng + ?Sized>(
    shape: [usize; D],
    std: f64,
    device: &Device,
    rng: &mut R,
) -> Param<Tensor<D>> {
    normal_around(vec![0.0; shape.iter().product()], shape, std, device, rng)
}

/// The same about `means`.
fn normal_around<const D: usize, R: Rng + ?Sized>(
    means: Vec<f64>,
    shape: [usize; D],
    std: f64,
    device: &Device,
    rng: &mut R,
) -> Param<Tensor<D>> {
    let mut values = means;
    for value in &mut values {
        let draw: f64 = StandardNormal.sample(rng);
        *value += std * draw;
    }
    Param::from_data(TensorData::new(values, shape), device)
}

/// A linear map with weights ~ N(0, gain² / inputs) and, where asked for, a zero bias.
pub fn linear<R: Rng + ?Sized>(
    [inputs, outputs]: [usize; 2],
    gain: f64,
    bias: bool,
    device: &Device,
    rng: &mut R,
) -> Linear {
    let weight = normal([inputs, outputs], gain / (inputs as f64).sqrt(), device, rng);
    let bias = bias.then(|| Param::from_data(TensorData::new(vec![0.0; outputs], [outputs]), device));
    Linear { weight, bias }
}

/// A linear map without bias, with weights ~ N(mean, gain² / inputs).
pub(crate) fn linear_around<R: Rng + ?Sized>(
    means: Vec<f64>,
    [inputs, outputs]: [usize; 2],
    gain: f64,
    device: &Device,
    rng: &mut R,
) -> Linear {
    let std = gain / (inputs as f64).sqrt();
    Linear { weight: normal_around(means, [inputs, outputs], std, device, rng), bias: None }
}
