//! The messages of a [`Convolution`](crate::Convolution) as one operation with its own backward pass.
//!
//! Written with burn's own operations, the same takes a score of passes over tensors of one row an edge, and they are what training
//! waits for on a processor. The operation takes some edges at a time and keeps nothing of them: what it needs on the way back it
//! makes again while it lies in the cache. [`composed`] is the form by burn's own operations; it says what the kernel must compute, and
//! the tests hold the one against the other.
//!
//! # Devices
//! The operation runs on flex and ndarray, with autodiff and without. Tensors on any other device of burn's are taken by [`composed`]
//! instead, which needs nothing but burn's own operations; no such device is among those that the tests run on.
//!
//! # Gradients
//! Directions and envelope weights are constants: the operation's backward pass hands on gradients of the features, of the three parts
//! of a and of the matrix, and none of where the points are. [`composed`] would hand them on.

mod kernel;
mod operation;

use burn::backend::Dispatch;
use burn::tensor::Tensor;

use self::operation::{EdgeLayout, MessageOps};
use crate::host::on_host;
use crate::shape::must_be;
use crate::silu::silu;
use crate::{EdgeTensors, Features, cross, dot};

/// What the path weights of an edge are made of: with a the sum of the three parts and w the envelope's weight they are
/// w silu(a) times the matrix.
#[derive(Debug, Clone)]
pub struct EdgeActivations {
    /// `[S, C]`.
    pub sources: Tensor<2>,
    /// `[R, C]`.
    pub receivers: Tensor<2>,
    /// `[E, C]`.
    pub edges: Tensor<2>,
    /// `[C, 5 C]`, or `[C, 2 C]` without source vectors.
    pub matrix: Tensor<2>,
}

/// The sums of the messages at every receiver, in one pass on flex and ndarray and by [`composed`] elsewhere; directions and envelope
/// are constants for the backward pass.
///
/// # Shapes
/// - `sources`: S nodes, scalars `[S, C]`, and vectors `[3, S, C]` where there are five paths
/// - output: scalars `[R, C]`, vectors `[3, R, C]`
///
/// # Panics
/// Where a tensor has another shape.
pub fn fused(sources: &Features, activations: EdgeActivations, edges: &EdgeTensors) -> Features {
    check(sources, &activations, edges);
    if !on_host(&sources.scalars.device()) {
        return composed(sources, activations, edges);
    }
    let [receivers, channels] = activations.receivers.dims();
    let [_, width] = activations.matrix.dims();
    let layout = EdgeLayout {
        sources: edges.source_rows.clone(),
        per_receiver: edges.per_receiver,
        channels,
        source_vectors: width == 5 * channels,
    };
    // Vectors that no path reads get no gradient, which burn allows leaves alone.
    let vectors = sources.vectors.clone();
    let vectors = if layout.source_vectors { vectors } else { vectors.detach() };
    let output = <Dispatch as MessageOps>::messages(
        activations.sources.into_dispatch(),
        activations.receivers.into_dispatch(),
        activations.edges.into_dispatch(),
        activations.matrix.into_dispatch(),
        sources.scalars.clone().into_dispatch(),
        vectors.into_dispatch(),
        edges.directions.clone().into_dispatch(),
        edges.weights.clone().into_dispatch(),
        layout,
    );
    let output = Tensor::<3>::from_dispatch(output);
    Features {
        scalars: output.clone().narrow(0, 0, 1).reshape([receivers, channels]),
        vectors: output.narrow(0, 1, 3),
    }
}

/// The same by burn's own operations, on every device: slow, and plain to read. Directions and envelope get gradients here where they
/// ask for them.
///
/// # Shapes
/// As [`fused`].
///
/// # Panics
/// As [`fused`].
pub fn composed(sources: &Features, activations: EdgeActivations, edges: &EdgeTensors) -> Features {
    check(sources, &activations, edges);
    let EdgeActivations { sources: of_sources, receivers: of_receivers, edges: of_edges, matrix } =
        activations;
    let [receivers, channels] = of_receivers.dims();
    let [_, width] = matrix.dims();
    let per_receiver = edges.per_receiver;
    let count = receivers * per_receiver;
    let both =
        (of_sources.select(0, edges.sources.clone()) + of_edges).reshape([receivers, per_receiver, channels]);
    let all = (both + of_receivers.reshape([receivers, 1, channels])).reshape([count, channels]);
    let paths = (silu(all) * edges.weights.clone()).matmul(matrix);

    let path = |index: usize| paths.clone().narrow(1, index * channels, channels);
    let gate = |index: usize| path(index).reshape([1, count, channels]);
    let scalars = sources.scalars.clone().select(0, edges.sources.clone());
    let directions = edges.directions.clone();
    let (scalar_message, vector_message) = if width == 5 * channels {
        let vectors = sources.vectors.clone().select(1, edges.sources.clone());
        let along = dot(vectors.clone(), directions.clone());
        let across = cross(vectors.clone(), directions.clone());
        (path(0) * scalars + path(2) * along, gate(1) * directions + gate(3) * vectors + gate(4) * across)
    } else {
        (path(0) * scalars, gate(1) * directions)
    };
    Features {
        scalars: scalar_message
            .reshape([receivers, per_receiver, channels])
            .sum_dim(1)
            .reshape([receivers, channels]),
        vectors: vector_message
            .reshape([3, receivers, per_receiver, channels])
            .sum_dim(2)
            .reshape([3, receivers, channels]),
    }
}

/// The kernel reads slices, in which a wrong shape would be wrong numbers.
#[track_caller]
fn check(sources: &Features, activations: &EdgeActivations, edges: &EdgeTensors) {
    let ([nodes, channels], [count, _]) = (sources.scalars.dims(), edges.weights.dims());
    let receivers = count / edges.per_receiver.max(1);
    let EdgeActivations { sources: of_sources, receivers: of_receivers, edges: of_edges, matrix } =
        activations;
    must_be("messages: activations of sources", [nodes, channels], of_sources.dims());
    must_be("messages: activations of receivers", [receivers, channels], of_receivers.dims());
    must_be("messages: activations of edges", [count, channels], of_edges.dims());
    let [_, width] = matrix.dims();
    if width == 5 * channels {
        must_be("messages: vectors of sources", [3, nodes, channels], sources.vectors.dims());
    }
    let paths = if width == 5 * channels { 5 } else { 2 };
    must_be("messages: the matrix of path weights", [channels, paths * channels], matrix.dims());
}
