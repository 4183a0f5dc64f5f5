//! The messages of a [`Convolution`](crate::Convolution) as one operation with its own backward pass.
//!
//! Written with burn's own operations, the same takes a score of passes over tensors of one row an edge, and they are what training
//! waits for on a processor. [`composed`] is that form; it says what the kernel must compute, and the tests hold the one
//! against the other.

mod kernel;
mod operation;

use burn::backend::Dispatch;
use burn::tensor::Tensor;

use self::operation::{EdgeLayout, MessageOps};
use crate::{EdgeTensors, Features, cross, dot};

/// The sums of the messages at every receiver, in one pass.
///
/// # Shapes
/// - `sources`: S nodes, scalars `[S, C]`, and vectors `[3, S, C]` where there are five paths
/// - `paths`: weights of the paths, `[E, 5 C]`, or `[E, 2 C]` without source vectors
/// - output: scalars `[R, C]`, vectors `[3, R, C]`
pub fn fused(sources: &Features, paths: Tensor<2>, edges: &EdgeTensors) -> Features {
    let [_, channels] = sources.scalars.dims();
    let [edge_count, width] = paths.dims();
    let receivers = edge_count / edges.per_receiver;
    let layout = EdgeLayout {
        sources: edges.source_rows.clone(),
        per_receiver: edges.per_receiver,
        channels,
        source_vectors: width == 5 * channels,
    };
    let output = <Dispatch as MessageOps>::messages(
        paths.into_dispatch(),
        sources.scalars.clone().into_dispatch(),
        sources.vectors.clone().into_dispatch(),
        edges.directions.clone().into_dispatch(),
        layout,
    );
    let output = Tensor::<3>::from_dispatch(output);
    Features {
        scalars: output.clone().narrow(0, 0, 1).reshape([receivers, channels]),
        vectors: output.narrow(0, 1, 3),
    }
}

/// The same by burn's own operations: slow, and plain to read.
pub fn composed(sources: &Features, paths: Tensor<2>, edges: &EdgeTensors) -> Features {
    let [_, channels] = sources.scalars.dims();
    let [count, width] = paths.dims();
    let (per_receiver, receivers) = (edges.per_receiver, count / edges.per_receiver);
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
