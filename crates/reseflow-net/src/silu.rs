//! silu(x) = x/(1 + e⁻ˣ) as one operation with its own backward pass.
//!
//! burn's is a sigmoid and a product, which takes six passes over the tensor with its backward pass and calls a scalar exponential at
//! every element; on ndarray it also rounds f64 to f32.
#![expect(deprecated, reason = "burn 0.22 still ships ndarray, and users ask to compare with it")]

use burn::backend::autodiff::checkpoint::base::Checkpointer;
use burn::backend::autodiff::checkpoint::strategy::CheckpointStrategy;
use burn::backend::autodiff::grads::Gradients;
use burn::backend::autodiff::ops::{Backward, Ops, OpsKind};
use burn::backend::tensor::FloatTensor;
use burn::backend::{Autodiff, Backend, Dispatch, Flex, NdArray, TensorMetadata, backend_extension};
use burn::tensor::{DType, Tensor, TensorData, activation};

use crate::host::{HostTensors, Lend, Real, on_host};

/// silu of every element; on devices other than flex and ndarray by burn's own operations.
///
/// # Shapes
/// Any, and the output's is the input's.
pub fn silu<const D: usize>(input: Tensor<D>) -> Tensor<D> {
    if !on_host(&input.device()) {
        return activation::silu(input);
    }
    Tensor::from_dispatch(<Dispatch as SiluOps>::silu(input.into_dispatch()))
}

/// The operation.
#[backend_extension(Flex, NdArray, Autodiff)]
pub(crate) trait SiluOps: Backend {
    /// silu of every element.
    fn silu(input: FloatTensor<Self>) -> FloatTensor<Self>;
}

impl SiluOps for Flex {
    fn silu(input: FloatTensor<Flex>) -> FloatTensor<Flex> {
        forward::<Flex>(input)
    }
}

impl SiluOps for NdArray {
    fn silu(input: FloatTensor<NdArray>) -> FloatTensor<NdArray> {
        forward::<NdArray>(input)
    }
}

#[derive(Debug)]
struct Silu;

impl<B: SiluOps + HostTensors> Backward<B, 1> for Silu {
    type State = FloatTensor<B>;

    fn backward(self, ops: Ops<Self::State, 1>, grads: &mut Gradients, _checkpointer: &mut Checkpointer) {
        let grad = grads.consume::<B>(&ops.node);
        let (input, device) = (ops.state, grad.device());
        let data = match grad.dtype() {
            DType::F64 => slopes::<B, f64>(&input, &grad),
            _ => slopes::<B, f32>(&input, &grad),
        };
        if let [Some(parent)] = ops.parents {
            grads.register::<B>(parent.id, B::float_from_data(data, &device));
        }
    }
}

impl<B: SiluOps + HostTensors, C: CheckpointStrategy> SiluOps for Autodiff<B, C> {
    fn silu(input: FloatTensor<Self>) -> FloatTensor<Self> {
        let node = input.node();
        let input = input.into_primitive();
        match Silu.prepare::<C>([node]).compute_bound().stateful() {
            OpsKind::Tracked(prep) => prep.finish(input.clone(), B::silu(input)),
            OpsKind::UnTracked(prep) => prep.finish(B::silu(input)),
        }
    }
}

fn forward<B: HostTensors>(input: FloatTensor<B>) -> FloatTensor<B> {
    let device = input.device();
    let data = match input.dtype() {
        DType::F64 => values::<B, f64>(&input),
        _ => values::<B, f32>(&input),
    };
    B::float_from_data(data, &device)
}

fn values<B: Lend<F>, F: Real>(input: &FloatTensor<B>) -> TensorData {
    let values: Vec<F> = B::lend(input).iter().map(|&x| x * x.sigmoid()).collect();
    TensorData::new(values, input.shape())
}

/// grad · σ (1 + x (1 − σ)).
fn slopes<B: Lend<F>, F: Real>(input: &FloatTensor<B>, grad: &FloatTensor<B>) -> TensorData {
    let (inputs, grads) = (B::lend(input), B::lend(grad));
    let slope = |(&x, &grad): (&F, &F)| {
        let sigmoid = x.sigmoid();
        grad * sigmoid * (F::ONE + x * (F::ONE - sigmoid))
    };
    TensorData::new(inputs.iter().zip(grads.iter()).map(slope).collect::<Vec<F>>(), input.shape())
}
