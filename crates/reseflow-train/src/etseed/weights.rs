//! Drawn weights, from a random stream on the host: one seed gives the same weights on every device.

use burn::module::Param;
use burn::nn::Linear;
use burn::tensor::{Device, Tensor, TensorData};
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

/// Independent normal draws with standard deviation `std`.
pub(super) fn normal<R: Rng + ?Sized>(
    shape: [usize; 2],
    std: f64,
    device: &Device,
    rng: &mut R,
) -> Param<Tensor<2>> {
    let values: Vec<f64> = (0..shape[0] * shape[1])
        .map(|_| {
            let draw: f64 = StandardNormal.sample(rng);
            std * draw
        })
        .collect();
    Param::from_data(TensorData::new(values, shape), device)
}

/// A linear map with weights ~ N(0, gain² / inputs) and, where asked for, a bias of zero.
pub(super) fn linear<R: Rng + ?Sized>(
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
