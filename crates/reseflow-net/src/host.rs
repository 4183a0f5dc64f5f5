//! Tensors of the back ends that compute on the host, read as slices by operations of our own.
#![expect(deprecated, reason = "burn 0.22 still ships ndarray, and users ask to compare with it")]

use std::borrow::Cow;
use std::ops::{Add, AddAssign, Mul, Sub};

use burn::backend::ndarray::NdArrayTensor;
use burn::backend::tensor::FloatTensor;
use burn::backend::{Backend, DispatchDevice, Flex, NdArray};
use burn::tensor::{Device, Element, TensorData};

/// Whether a device, with or without autodiff, is one that the operations of this crate run on: flex or ndarray.
pub(crate) fn on_host(device: &Device) -> bool {
    matches!(
        device.clone().without_autodiff().as_dispatch(),
        DispatchDevice::Flex(_) | DispatchDevice::NdArray(_)
    )
}

/// f32 or f64, as the kernels compute with it.
pub(crate) trait Real:
    Element + Default + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + AddAssign
{
    /// 1.
    const ONE: Self;

    /// 1/(1 + e⁻ˣ), to rounding.
    fn sigmoid(self) -> Self;
}

impl Real for f32 {
    const ONE: f32 = 1.0;

    /// The exponential by Cephes' polynomial: without branches and tables, so that a loop of it is vectorised.
    #[inline]
    fn sigmoid(self) -> f32 {
        // Adding it rounds to an integer, which then lies in the lowest bits.
        const ROUND: f32 = 12_582_912.0;
        let x = (-self).clamp(-87.0, 87.0);
        let shifted = x * std::f32::consts::LOG2_E + ROUND;
        let power = shifted - ROUND;
        // ln 2 in two parts, the first of few bits.
        let rest = x - power * 0.693_359_4 + power * 2.121_944_4e-4;
        let series = [1.987_569_1e-4, 1.398_199_9e-3, 8.333_452e-3, 4.166_579_6e-2, 1.666_666_5e-1, 0.5];
        let series = series.into_iter().fold(0.0, |sum, coefficient| sum * rest + coefficient);
        let fraction = series * rest * rest + rest + 1.0;
        let exponential = f32::from_bits(fraction.to_bits().wrapping_add(shifted.to_bits() << 23));
        1.0 / (1.0 + exponential)
    }
}

impl Real for f64 {
    const ONE: f64 = 1.0;

    #[inline]
    fn sigmoid(self) -> f64 {
        1.0 / (1.0 + (-self).exp())
    }
}

/// A back end that lends a tensor's values in row-major order.
pub(crate) trait Lend<F: Clone>: Backend {
    /// The values: as they lie where they lie in order, else copied.
    fn lend(tensor: &FloatTensor<Self>) -> Cow<'_, [F]>;
}

/// A back end whose tensors lie in the host's memory, of either float type.
pub(crate) trait HostTensors: Lend<f32> + Lend<f64> {}

impl HostTensors for Flex {}
impl HostTensors for NdArray {}

impl Lend<f32> for Flex {
    fn lend(tensor: &FloatTensor<Flex>) -> Cow<'_, [f32]> {
        tensor.as_slice::<f32>().map_or_else(|| copied::<Flex, f32>(tensor), Cow::Borrowed)
    }
}

impl Lend<f64> for Flex {
    fn lend(tensor: &FloatTensor<Flex>) -> Cow<'_, [f64]> {
        tensor.as_slice::<f64>().map_or_else(|| copied::<Flex, f64>(tensor), Cow::Borrowed)
    }
}

impl Lend<f32> for NdArray {
    fn lend(tensor: &FloatTensor<NdArray>) -> Cow<'_, [f32]> {
        let lent = match tensor {
            NdArrayTensor::F32(storage) => storage.view().to_slice(),
            _ => None,
        };
        lent.map_or_else(|| copied::<NdArray, f32>(tensor), Cow::Borrowed)
    }
}

impl Lend<f64> for NdArray {
    fn lend(tensor: &FloatTensor<NdArray>) -> Cow<'_, [f64]> {
        let lent = match tensor {
            NdArrayTensor::F64(storage) => storage.view().to_slice(),
            _ => None,
        };
        lent.map_or_else(|| copied::<NdArray, f64>(tensor), Cow::Borrowed)
    }
}

#[expect(clippy::expect_used, reason = "the tensors of these back ends lie in the host's memory")]
fn copied<B: Backend, F: Element>(tensor: &FloatTensor<B>) -> Cow<'_, [F]> {
    let data: TensorData = burn::tensor::try_read_sync(B::float_into_data(tensor.clone()))
        .expect("tensors on the host are read at once")
        .expect("tensors on the host can be read");
    Cow::Owned(data.into_vec::<F>().expect("all inputs of an operation have one float type"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_back_ends_are_known_with_and_without_autodiff() {
        for device in [Device::flex(), Device::ndarray()] {
            assert!(on_host(&device) && on_host(&device.autodiff()));
        }
    }

    #[test]
    fn the_f32_sigmoid_is_that_of_f64_to_rounding() {
        let mut worst = 0.0_f64;
        for step in -200_000..=200_000_i32 {
            let x = step as f32 * 1e-4;
            let expected = f64::from(x).sigmoid();
            worst = worst.max((f64::from(x.sigmoid()) - expected).abs() / expected);
        }
        assert!(worst < 3e-7, "{worst:e}");
        for x in [f32::NEG_INFINITY, -1e30, -90.0] {
            assert!((0.0..1e-37).contains(&x.sigmoid()), "{x}");
        }
        for x in [f32::INFINITY, 1e30, 90.0] {
            assert_eq!(x.sigmoid(), 1.0, "{x}");
        }
    }
}
