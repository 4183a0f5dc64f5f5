//! The kernel as an operation of burn's back ends, and its place in the autodiff graph.
#![expect(deprecated, reason = "burn 0.22 still ships ndarray, and users ask to compare with it")]

use std::borrow::Cow;
use std::sync::Arc;

use burn::backend::autodiff::checkpoint::base::Checkpointer;
use burn::backend::autodiff::checkpoint::strategy::CheckpointStrategy;
use burn::backend::autodiff::grads::Gradients;
use burn::backend::autodiff::ops::{Backward, Ops, OpsKind};
use burn::backend::tensor::FloatTensor;
use burn::backend::{Autodiff, Backend, Flex, NdArray, TensorMetadata, backend_extension};
use burn::tensor::{DType, TensorData};

use super::kernel::{self, Edges};
use crate::host::{HostTensors, Lend, Real};

/// What the kernel knows about the edges besides tensors.
#[derive(Debug, Clone)]
pub(super) struct EdgeLayout {
    /// Source row of each edge.
    pub(super) sources: Arc<[u32]>,
    /// Edges per receiver.
    pub(super) per_receiver: usize,
    /// Channels C.
    pub(super) channels: usize,
    /// Whether there are five paths, or two that see no vectors.
    pub(super) source_vectors: bool,
}

/// The operation; the directions are constants.
#[backend_extension(Flex, NdArray, Autodiff)]
pub(super) trait MessageOps: Backend {
    /// `[4, R, C]` from `[E, paths · C]`, `[S, C]`, `[3, S, C]` and `[3, E, 1]`.
    fn messages(
        paths: FloatTensor<Self>,
        scalars: FloatTensor<Self>,
        vectors: FloatTensor<Self>,
        directions: FloatTensor<Self>,
        layout: EdgeLayout,
    ) -> FloatTensor<Self>;
}

impl MessageOps for Flex {
    fn messages(
        paths: FloatTensor<Flex>,
        scalars: FloatTensor<Flex>,
        vectors: FloatTensor<Flex>,
        directions: FloatTensor<Flex>,
        layout: EdgeLayout,
    ) -> FloatTensor<Flex> {
        forward::<Flex>(&[paths, scalars, vectors, directions], &layout)
    }
}

impl MessageOps for NdArray {
    fn messages(
        paths: FloatTensor<NdArray>,
        scalars: FloatTensor<NdArray>,
        vectors: FloatTensor<NdArray>,
        directions: FloatTensor<NdArray>,
        layout: EdgeLayout,
    ) -> FloatTensor<NdArray> {
        forward::<NdArray>(&[paths, scalars, vectors, directions], &layout)
    }
}

#[derive(Debug)]
struct Messages;

impl<B: MessageOps + HostTensors> Backward<B, 3> for Messages {
    type State = ([FloatTensor<B>; 4], EdgeLayout);

    fn backward(self, ops: Ops<Self::State, 3>, grads: &mut Gradients, _checkpointer: &mut Checkpointer) {
        let grad = grads.consume::<B>(&ops.node);
        let (inputs, layout) = ops.state;
        let device = grad.device();
        let computed = match grad.dtype() {
            DType::F64 => gradients::<B, f64>(&inputs, &layout, &grad),
            _ => gradients::<B, f32>(&inputs, &layout, &grad),
        };
        for (parent, data) in ops.parents.into_iter().zip(computed) {
            if let (Some(node), Some(data)) = (parent, data) {
                grads.register::<B>(node.id, B::float_from_data(data, &device));
            }
        }
    }
}

impl<B: MessageOps + HostTensors, C: CheckpointStrategy> MessageOps for Autodiff<B, C> {
    fn messages(
        paths: FloatTensor<Self>,
        scalars: FloatTensor<Self>,
        vectors: FloatTensor<Self>,
        directions: FloatTensor<Self>,
        layout: EdgeLayout,
    ) -> FloatTensor<Self> {
        let nodes = [paths.node(), scalars.node(), vectors.node()];
        let inputs = [paths, scalars, vectors, directions].map(|tensor| tensor.into_primitive());
        let forward = |[paths, scalars, vectors, directions]: [FloatTensor<B>; 4], layout| {
            B::messages(paths, scalars, vectors, directions, layout)
        };
        match Messages.prepare::<C>(nodes).compute_bound().stateful() {
            OpsKind::Tracked(prep) => prep.finish((inputs.clone(), layout.clone()), forward(inputs, layout)),
            OpsKind::UnTracked(prep) => prep.finish(forward(inputs, layout)),
        }
    }
}

fn forward<B: HostTensors>(inputs: &[FloatTensor<B>; 4], layout: &EdgeLayout) -> FloatTensor<B> {
    let shape = [4, layout.sources.len() / layout.per_receiver, layout.channels];
    let data = match inputs[0].dtype() {
        DType::F64 => TensorData::new(summed::<B, f64>(inputs, layout), shape),
        _ => TensorData::new(summed::<B, f32>(inputs, layout), shape),
    };
    B::float_from_data(data, &inputs[0].device())
}

fn summed<B: Lend<F>, F: Real>(inputs: &[FloatTensor<B>; 4], layout: &EdgeLayout) -> Vec<F> {
    let lent = inputs.each_ref().map(B::lend);
    kernel::messages(&edges(&lent, layout))
}

fn edges<'a, F: Clone>(lent: &'a [Cow<'a, [F]>; 4], layout: &'a EdgeLayout) -> Edges<'a, F> {
    let [paths, scalars, vectors, directions] = lent;
    Edges {
        sources: &layout.sources,
        per_receiver: layout.per_receiver,
        directions,
        paths,
        scalars,
        vectors: if layout.source_vectors { vectors } else { &[] },
        channels: layout.channels,
    }
}

/// Gradients of paths, scalars and, where they were read, vectors.
fn gradients<B: Lend<F>, F: Real>(
    inputs: &[FloatTensor<B>; 4],
    layout: &EdgeLayout,
    grad: &FloatTensor<B>,
) -> [Option<TensorData>; 3] {
    let lent = inputs.each_ref().map(B::lend);
    let computed = kernel::messages_backward(&edges(&lent, layout), &B::lend(grad));
    let [paths, scalars, vectors] = [0, 1, 2].map(|input: usize| inputs[input].shape());
    [
        Some(TensorData::new(computed.paths, paths)),
        Some(TensorData::new(computed.scalars, scalars)),
        layout.source_vectors.then(|| TensorData::new(computed.vectors, vectors)),
    ]
}
