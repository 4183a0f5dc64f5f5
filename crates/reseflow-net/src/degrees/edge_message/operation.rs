//! The kernel as an operation of burn's back ends, and its place in the autodiff graph.
#![expect(deprecated, reason = "burn 0.22 still ships ndarray, and users ask to compare with it")]

use std::ops::Range;
use std::sync::Arc;

use burn::backend::autodiff::checkpoint::base::Checkpointer;
use burn::backend::autodiff::checkpoint::strategy::CheckpointStrategy;
use burn::backend::autodiff::grads::Gradients;
use burn::backend::autodiff::ops::{Backward, Ops, OpsKind};
use burn::backend::tensor::FloatTensor;
use burn::backend::{Autodiff, Backend, Flex, NdArray, TensorMetadata, backend_extension};
use burn::tensor::{DType, Slice, TensorData};

use super::kernel::{Edge, Layout, message, message_backward, turn, turn_back};
use crate::degrees::{EdgeFrames, EdgeProduct};
use crate::host::{HostTensors, Lend, Real};

/// Weights that are made at a time: as many as lie well in a core's cache.
const WEIGHTS_AT_A_TIME: usize = 1 << 17;

/// What the operation knows besides tensors.
#[derive(Debug, Clone)]
pub(super) struct Messages {
    layout: Arc<Layout>,
    /// Source row of each edge.
    sources: Arc<[u32]>,
}

impl Messages {
    pub(super) fn new(product: &EdgeProduct, edges: &EdgeFrames) -> Messages {
        Messages {
            layout: Arc::new(product.layout(edges.max_degree)),
            sources: edges.edges.source_rows.clone(),
        }
    }

    /// The edges, some at a time.
    fn tiles(&self) -> impl Iterator<Item = Range<usize>> + use<> {
        let (count, size) = (self.sources.len(), (WEIGHTS_AT_A_TIME / self.layout.weights.max(1)).max(8));
        (0..count).step_by(size).map(move |first| first..(first + size).min(count))
    }

    /// An edge of the whole batch.
    fn edge<'a, F>(&self, edge: usize, wigner: &'a [F], stacked: &'a [F]) -> Edge<'a, F> {
        let (matrix, inputs) = (self.layout.wigner_size.pow(2), self.layout.inputs());
        Edge {
            wigner: &wigner[edge * matrix..][..matrix],
            source: &stacked[self.sources[edge] as usize * inputs..][..inputs],
        }
    }
}

/// The operation; the Wigner matrices are constants.
#[backend_extension(Flex, NdArray, Autodiff)]
pub(super) trait EdgeMessageOps: Backend {
    /// `[E, all outputs]` from `[S, components, C]`, `[E, H]`, `[H, W]` and `[E, size, size]`.
    fn edge_messages(
        stacked: FloatTensor<Self>,
        radial: FloatTensor<Self>,
        weight: FloatTensor<Self>,
        wigner: FloatTensor<Self>,
        messages: Messages,
    ) -> FloatTensor<Self>;
}

impl EdgeMessageOps for Flex {
    fn edge_messages(
        stacked: FloatTensor<Flex>,
        radial: FloatTensor<Flex>,
        weight: FloatTensor<Flex>,
        wigner: FloatTensor<Flex>,
        messages: Messages,
    ) -> FloatTensor<Flex> {
        forward::<Flex>(&[stacked, radial, weight, wigner], &messages)
    }
}

impl EdgeMessageOps for NdArray {
    fn edge_messages(
        stacked: FloatTensor<NdArray>,
        radial: FloatTensor<NdArray>,
        weight: FloatTensor<NdArray>,
        wigner: FloatTensor<NdArray>,
        messages: Messages,
    ) -> FloatTensor<NdArray> {
        forward::<NdArray>(&[stacked, radial, weight, wigner], &messages)
    }
}

#[derive(Debug)]
struct EdgeMessages;

impl<B: EdgeMessageOps + HostTensors> Backward<B, 3> for EdgeMessages {
    type State = ([FloatTensor<B>; 4], Messages);

    fn backward(self, ops: Ops<Self::State, 3>, grads: &mut Gradients, _checkpointer: &mut Checkpointer) {
        let grad = grads.consume::<B>(&ops.node);
        let (inputs, messages) = ops.state;
        let gradients = match grad.dtype() {
            DType::F64 => gradients::<B, f64>(&inputs, &messages, &grad),
            _ => gradients::<B, f32>(&inputs, &messages, &grad),
        };
        for (parent, gradient) in ops.parents.into_iter().zip(gradients) {
            if let Some(node) = parent {
                grads.register::<B>(node.id, gradient);
            }
        }
    }
}

impl<B: EdgeMessageOps + HostTensors, C: CheckpointStrategy> EdgeMessageOps for Autodiff<B, C> {
    fn edge_messages(
        stacked: FloatTensor<Self>,
        radial: FloatTensor<Self>,
        weight: FloatTensor<Self>,
        wigner: FloatTensor<Self>,
        messages: Messages,
    ) -> FloatTensor<Self> {
        let nodes = [stacked.node(), radial.node(), weight.node()];
        let inputs = [stacked, radial, weight, wigner].map(|tensor| tensor.into_primitive());
        let forward = |[stacked, radial, weight, wigner]: [FloatTensor<B>; 4], messages| {
            B::edge_messages(stacked, radial, weight, wigner, messages)
        };
        match EdgeMessages.prepare::<C>(nodes).compute_bound().stateful() {
            OpsKind::Tracked(prep) => {
                prep.finish((inputs.clone(), messages.clone()), forward(inputs, messages))
            }
            OpsKind::UnTracked(prep) => prep.finish(forward(inputs, messages)),
        }
    }
}

fn forward<B: HostTensors>(inputs: &[FloatTensor<B>; 4], messages: &Messages) -> FloatTensor<B> {
    let data = match inputs[0].dtype() {
        DType::F64 => all_messages::<B, f64>(inputs, messages),
        _ => all_messages::<B, f32>(inputs, messages),
    };
    B::float_from_data(data, &inputs[0].device())
}

/// The rows `tile` of a matrix.
fn rows<B: Backend>(matrix: &FloatTensor<B>, tile: &Range<usize>) -> FloatTensor<B> {
    B::float_slice(matrix.clone(), &[Slice::from(tile.clone()), Slice::from(..)])
}

fn all_messages<B: Lend<F>, F: Real>(inputs: &[FloatTensor<B>; 4], messages: &Messages) -> TensorData {
    let [stacked, radial, weight, wigner] = inputs;
    let (layout, stacked, wigner) = (&messages.layout, B::lend(stacked), B::lend(wigner));
    let mut output = vec![F::default(); messages.sources.len() * layout.values];
    let mut turned = vec![F::default(); layout.inputs()];
    for tile in messages.tiles() {
        let weights = B::float_matmul(rows::<B>(radial, &tile), weight.clone());
        let weights = B::lend(&weights);
        for (edge, weights) in tile.zip(weights.chunks_exact(layout.weights)) {
            turn(layout, &messages.edge(edge, &wigner, &stacked), &mut turned);
            message(layout, &turned, weights, &mut output[edge * layout.values..][..layout.values]);
        }
    }
    TensorData::new(output, [messages.sources.len(), layout.values])
}

/// The gradients of the features, the radial features and the matrix that makes weights of these.
fn gradients<B: Lend<F>, F: Real>(
    inputs: &[FloatTensor<B>; 4],
    messages: &Messages,
    grad: &FloatTensor<B>,
) -> [FloatTensor<B>; 3] {
    let [stacked, radial, weight, wigner] = inputs;
    let (layout, device) = (&messages.layout, grad.device());
    let [stacked_shape, radial_shape] = [stacked.shape(), radial.shape()];
    let (stacked, wigner, grad) = (B::lend(stacked), B::lend(wigner), B::lend(grad));
    let inputs = layout.inputs();
    let mut to_stacked = vec![F::default(); stacked.len()];
    let mut to_radial = Vec::with_capacity(radial_shape.num_elements());
    let mut to_weight = B::float_zeros(weight.shape(), &device, weight.dtype().into());
    let (mut turned, mut to_turned) = (vec![F::default(); inputs], vec![F::default(); inputs]);
    let back = B::float_transpose(weight.clone());
    for tile in messages.tiles() {
        let of_tile = rows::<B>(radial, &tile);
        let made = B::float_matmul(of_tile.clone(), weight.clone());
        let made = B::lend(&made);
        let mut to_made = vec![F::default(); tile.len() * layout.weights];
        let weights = made.chunks_exact(layout.weights).zip(to_made.chunks_exact_mut(layout.weights));
        for (edge, (weights, to_weights)) in tile.clone().zip(weights) {
            let own = messages.edge(edge, &wigner, &stacked);
            turn(layout, &own, &mut turned);
            let grad = &grad[edge * layout.values..][..layout.values];
            message_backward(layout, &turned, weights, grad, &mut to_turned, to_weights);
            let source = messages.sources[edge] as usize * inputs;
            turn_back(layout, own.wigner, &to_turned, &mut to_stacked[source..source + inputs]);
        }
        let to_made = B::float_from_data(TensorData::new(to_made, [tile.len(), layout.weights]), &device);
        to_radial.extend_from_slice(&B::lend(&B::float_matmul(to_made.clone(), back.clone())));
        let part = B::float_matmul(B::float_transpose(of_tile), to_made);
        to_weight = B::float_add(to_weight, part);
    }
    [
        B::float_from_data(TensorData::new(to_stacked, stacked_shape), &device),
        B::float_from_data(TensorData::new(to_radial, radial_shape), &device),
        to_weight,
    ]
}
