//! The kernel as an operation of burn's back ends, and its place in the autodiff graph.
#![expect(deprecated, reason = "burn 0.22 still ships ndarray, and users ask to compare with it")]

use std::sync::Arc;

use burn::backend::autodiff::checkpoint::base::Checkpointer;
use burn::backend::autodiff::checkpoint::strategy::CheckpointStrategy;
use burn::backend::autodiff::grads::Gradients;
use burn::backend::autodiff::ops::{Backward, Ops, OpsKind};
use burn::backend::tensor::FloatTensor;
use burn::backend::{Autodiff, Backend, Flex, NdArray, TensorMetadata, backend_extension};
use burn::tensor::{DType, TensorData};

use super::kernel::{self, Edges};

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
    ) -> FloatTensor<Self> {
        let device = paths.device();
        let inputs = [paths, scalars, vectors, directions].map(read::<Self>);
        let shape = [4, layout.sources.len() / layout.per_receiver, layout.channels];
        let data = match inputs[0].dtype() {
            DType::F64 => TensorData::new(kernel::messages(&edges::<f64>(&inputs, &layout)), shape),
            _ => TensorData::new(kernel::messages(&edges::<f32>(&inputs, &layout)), shape),
        };
        Self::float_from_data(data, &device)
    }
}

impl MessageOps for Flex {}
impl MessageOps for NdArray {}

#[derive(Debug)]
struct Messages;

impl<B: MessageOps> Backward<B, 3> for Messages {
    type State = ([FloatTensor<B>; 4], EdgeLayout);

    fn backward(self, ops: Ops<Self::State, 3>, grads: &mut Gradients, _checkpointer: &mut Checkpointer) {
        let grad = grads.consume::<B>(&ops.node);
        let (inputs, layout) = ops.state;
        let device = grad.device();
        let grad = read::<B>(grad);
        let inputs = inputs.map(read::<B>);
        let computed = match grad.dtype() {
            DType::F64 => backward::<f64>(&inputs, &layout, &grad),
            _ => backward::<f32>(&inputs, &layout, &grad),
        };
        for (parent, data) in ops.parents.into_iter().zip(computed) {
            if let (Some(node), Some(data)) = (parent, data) {
                grads.register::<B>(node.id, B::float_from_data(data, &device));
            }
        }
    }
}

impl<B: MessageOps, C: CheckpointStrategy> MessageOps for Autodiff<B, C> {
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

/// A tensor on the host; free of copies where nobody else holds it.
#[expect(clippy::expect_used, reason = "the tensors of these back ends lie in the host's memory")]
fn read<B: Backend>(tensor: FloatTensor<B>) -> TensorData {
    burn::tensor::try_read_sync(B::float_into_data(tensor))
        .expect("tensors on the host are read at once")
        .expect("tensors on the host can be read")
}

#[expect(clippy::expect_used, reason = "all inputs of an operation have one float type")]
fn floats<F: burn::tensor::Element + 'static>(data: &TensorData) -> &[F] {
    data.as_slice::<F>().expect("all inputs have one float type")
}

fn edges<'a, F: burn::tensor::Element + kernel::Real>(
    inputs: &'a [TensorData; 4],
    layout: &'a EdgeLayout,
) -> Edges<'a, F> {
    let [paths, scalars, vectors, directions] = inputs;
    Edges {
        sources: &layout.sources,
        per_receiver: layout.per_receiver,
        directions: floats(directions),
        paths: floats(paths),
        scalars: floats(scalars),
        vectors: if layout.source_vectors { floats(vectors) } else { &[] },
        channels: layout.channels,
    }
}

/// Gradients of paths, scalars and, where they were read, vectors.
fn backward<F: burn::tensor::Element + kernel::Real>(
    inputs: &[TensorData; 4],
    layout: &EdgeLayout,
    grad: &TensorData,
) -> [Option<TensorData>; 3] {
    let computed = kernel::messages_backward(&edges::<F>(inputs, layout), floats(grad));
    let [paths, scalars, vectors] = [0, 1, 2].map(|input| inputs[input].shape().clone());
    [
        Some(TensorData::new(computed.paths, paths)),
        Some(TensorData::new(computed.scalars, scalars)),
        layout.source_vectors.then(|| TensorData::new(computed.vectors, vectors)),
    ]
}
