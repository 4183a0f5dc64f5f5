//! Small constant tensors on the device and in the float type of another tensor.

use burn::tensor::{DType, Tensor, TensorData};

/// The tensor of `values` in row-major order, beside `like`.
pub(crate) fn constant<const D: usize, const E: usize>(
    values: &[f64],
    shape: [usize; D],
    like: &Tensor<E>,
) -> Tensor<D> {
    Tensor::from_data(TensorData::new(values.to_vec(), shape), (&like.device(), like.dtype()))
}

/// The distance from 1 to the next larger number of this float type.
pub(crate) fn epsilon(dtype: DType) -> f64 {
    dtype.finfo().map_or(f64::from(f32::EPSILON), |info| info.epsilon)
}
