//! The kernel as an operation of burn's back ends, and its place in the autodiff graph.
#![expect(deprecated, reason = "burn 0.22 still ships ndarray, and users ask to compare with it")]
#![expect(clippy::too_many_arguments, reason = "burn's dispatch takes tensors one by one")]

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

use burn::backend::autodiff::checkpoint::base::Checkpointer;
use burn::backend::autodiff::checkpoint::strategy::CheckpointStrategy;
use burn::backend::autodiff::grads::Gradients;
use burn::backend::autodiff::ops::{Backward, Ops, OpsKind};
use burn::backend::tensor::{Device, FloatTensor};
use burn::backend::{Autodiff, Backend, Flex, NdArray, TensorMetadata, backend_extension};
use burn::tensor::{DType, TensorData};

use super::kernel::{self, Edges};
use crate::host::{HostTensors, Lend, Real};

/// Edges whose path weights are made at a time: few enough that they lie well in a core's cache.
const TILE: usize = 256;

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

impl EdgeLayout {
    /// The edges, some at a time.
    fn tiles(&self) -> impl Iterator<Item = Range<usize>> + use<> {
        let count = self.sources.len();
        (0..count).step_by(TILE).map(move |first| first..(first + TILE).min(count))
    }
}

/// The operation; the last two tensors are constants.
#[backend_extension(Flex, NdArray, Autodiff)]
pub(super) trait MessageOps: Backend {
    /// `[4, R, C]` from what sources `[S, C]`, receivers `[R, C]` and edges `[E, C]` say, the matrix of the path weights
    /// `[C, paths · C]`, the sources' features `[S, C]` and `[3, S, C]`, the directions `[3, E, 1]` and the envelope `[E, 1]`.
    fn messages(
        of_sources: FloatTensor<Self>,
        of_receivers: FloatTensor<Self>,
        of_edges: FloatTensor<Self>,
        matrix: FloatTensor<Self>,
        scalars: FloatTensor<Self>,
        vectors: FloatTensor<Self>,
        directions: FloatTensor<Self>,
        envelope: FloatTensor<Self>,
        layout: EdgeLayout,
    ) -> FloatTensor<Self>;
}

impl MessageOps for Flex {
    fn messages(
        of_sources: FloatTensor<Flex>,
        of_receivers: FloatTensor<Flex>,
        of_edges: FloatTensor<Flex>,
        matrix: FloatTensor<Flex>,
        scalars: FloatTensor<Flex>,
        vectors: FloatTensor<Flex>,
        directions: FloatTensor<Flex>,
        envelope: FloatTensor<Flex>,
        layout: EdgeLayout,
    ) -> FloatTensor<Flex> {
        let inputs = [of_sources, of_receivers, of_edges, matrix, scalars, vectors, directions, envelope];
        forward::<Flex>(&inputs, &layout)
    }
}

impl MessageOps for NdArray {
    fn messages(
        of_sources: FloatTensor<NdArray>,
        of_receivers: FloatTensor<NdArray>,
        of_edges: FloatTensor<NdArray>,
        matrix: FloatTensor<NdArray>,
        scalars: FloatTensor<NdArray>,
        vectors: FloatTensor<NdArray>,
        directions: FloatTensor<NdArray>,
        envelope: FloatTensor<NdArray>,
        layout: EdgeLayout,
    ) -> FloatTensor<NdArray> {
        let inputs = [of_sources, of_receivers, of_edges, matrix, scalars, vectors, directions, envelope];
        forward::<NdArray>(&inputs, &layout)
    }
}

#[derive(Debug)]
struct Messages;

impl<B: MessageOps + HostTensors> Backward<B, 6> for Messages {
    type State = ([FloatTensor<B>; 8], EdgeLayout);

    fn backward(self, ops: Ops<Self::State, 6>, grads: &mut Gradients, _checkpointer: &mut Checkpointer) {
        let grad = grads.consume::<B>(&ops.node);
        let (inputs, layout) = ops.state;
        let computed = match grad.dtype() {
            DType::F64 => gradients::<B, f64>(&inputs, &layout, &grad),
            _ => gradients::<B, f32>(&inputs, &layout, &grad),
        };
        for (parent, gradient) in ops.parents.into_iter().zip(computed) {
            if let (Some(node), Some(gradient)) = (parent, gradient) {
                grads.register::<B>(node.id, gradient);
            }
        }
    }
}

impl<B: MessageOps + HostTensors, C: CheckpointStrategy> MessageOps for Autodiff<B, C> {
    fn messages(
        of_sources: FloatTensor<Self>,
        of_receivers: FloatTensor<Self>,
        of_edges: FloatTensor<Self>,
        matrix: FloatTensor<Self>,
        scalars: FloatTensor<Self>,
        vectors: FloatTensor<Self>,
        directions: FloatTensor<Self>,
        envelope: FloatTensor<Self>,
        layout: EdgeLayout,
    ) -> FloatTensor<Self> {
        let inputs = [of_sources, of_receivers, of_edges, matrix, scalars, vectors, directions, envelope];
        let nodes = [0, 1, 2, 3, 4, 5].map(|input: usize| inputs[input].node());
        let inputs = inputs.map(|tensor| tensor.into_primitive());
        let forward = |inputs: [FloatTensor<B>; 8], layout| {
            let [of_sources, of_receivers, of_edges, matrix, scalars, vectors, directions, envelope] = inputs;
            B::messages(
                of_sources,
                of_receivers,
                of_edges,
                matrix,
                scalars,
                vectors,
                directions,
                envelope,
                layout,
            )
        };
        match Messages.prepare::<C>(nodes).compute_bound().stateful() {
            OpsKind::Tracked(prep) => prep.finish((inputs.clone(), layout.clone()), forward(inputs, layout)),
            OpsKind::UnTracked(prep) => prep.finish(forward(inputs, layout)),
        }
    }
}

fn forward<B: HostTensors>(inputs: &[FloatTensor<B>; 8], layout: &EdgeLayout) -> FloatTensor<B> {
    let data = match inputs[0].dtype() {
        DType::F64 => summed::<B, f64>(inputs, layout),
        _ => summed::<B, f32>(inputs, layout),
    };
    B::float_from_data(data, &inputs[0].device())
}

fn edges<'a, F: Clone>(lent: &'a [Cow<'a, [F]>; 8], layout: &'a EdgeLayout) -> Edges<'a, F> {
    let [of_sources, of_receivers, of_edges, _, scalars, vectors, directions, envelope] = lent;
    Edges {
        sources: &layout.sources,
        per_receiver: layout.per_receiver,
        directions,
        envelope,
        activations: [of_sources, of_receivers, of_edges],
        scalars,
        vectors: if layout.source_vectors { vectors } else { &[] },
        channels: layout.channels,
    }
}

fn rows<B: Backend, F: Real>(values: Vec<F>, width: usize, device: &Device<B>) -> FloatTensor<B> {
    let count = values.len() / width;
    B::float_from_data(TensorData::new(values, [count, width]), device)
}

fn summed<B: Lend<F>, F: Real>(inputs: &[FloatTensor<B>; 8], layout: &EdgeLayout) -> TensorData {
    let lent = inputs.each_ref().map(B::lend);
    let (edges, matrix, device) = (edges(&lent, layout), &inputs[3], inputs[0].device());
    let shape = [4, edges.receivers(), layout.channels];
    let mut output = vec![F::default(); shape.iter().product()];
    let mut activations = Vec::with_capacity(TILE * layout.channels);
    for tile in layout.tiles() {
        kernel::activations(&edges, tile.clone(), &mut activations);
        let hidden =
            rows::<B, F>(kernel::hidden(&edges, tile.clone(), &activations), layout.channels, &device);
        let paths = B::float_matmul(hidden, matrix.clone());
        kernel::messages(&edges, tile, &B::lend(&paths), &mut output);
    }
    TensorData::new(output, shape)
}

/// Gradients of all inputs but the constants; of the vectors only where they were read.
fn gradients<B: Lend<F>, F: Real>(
    inputs: &[FloatTensor<B>; 8],
    layout: &EdgeLayout,
    grad: &FloatTensor<B>,
) -> [Option<FloatTensor<B>>; 6] {
    let lent = inputs.each_ref().map(B::lend);
    let (edges, matrix, device) = (edges(&lent, layout), &inputs[3], grad.device());
    let grad = B::lend(grad);
    let mut gradients = edges.no_gradients();
    let mut to_matrix = B::float_zeros(matrix.shape(), &device, matrix.dtype().into());
    let back = B::float_transpose(matrix.clone());
    let mut activations = Vec::with_capacity(TILE * layout.channels);
    for tile in layout.tiles() {
        kernel::activations(&edges, tile.clone(), &mut activations);
        let hidden =
            rows::<B, F>(kernel::hidden(&edges, tile.clone(), &activations), layout.channels, &device);
        let paths = B::float_matmul(hidden.clone(), matrix.clone());
        let to_paths =
            kernel::messages_backward(&edges, tile.clone(), &B::lend(&paths), &grad, &mut gradients);
        let to_paths = rows::<B, F>(to_paths, edges.paths() * layout.channels, &device);
        let to_hidden = B::float_matmul(to_paths.clone(), back.clone());
        to_matrix = B::float_add(to_matrix, B::float_matmul(B::float_transpose(hidden), to_paths));
        kernel::hidden_backward(&edges, tile, &activations, &B::lend(&to_hidden), &mut gradients);
    }
    let shaped = |values: Vec<F>, input: usize| {
        B::float_from_data(TensorData::new(values, inputs[input].shape()), &device)
    };
    let [of_sources, of_receivers, of_edges] = gradients.activations;
    [
        Some(shaped(of_sources, 0)),
        Some(shaped(of_receivers, 1)),
        Some(shaped(of_edges, 2)),
        Some(to_matrix),
        Some(shaped(gradients.scalars, 4)),
        layout.source_vectors.then(|| shaped(gradients.vectors, 5)),
    ]
}
