//! Messages along the edges for features of all degrees, as one operation with its own backward pass.
//!
//! Every edge has hundreds to thousands of kernel weights, a linear function of its few radial features. Written with burn's own
//! operations they are made for all edges, kept for the backward pass and gathered as gradients of the same size: memory traffic that
//! training waits for. The operation makes them for a few edges at a time, uses them while they lie in the cache, and makes them again
//! on the way back. [`composed`] is the form by burn's own operations; it says what the operation must compute, and the tests hold the
//! one against the other.
//!
//! # Devices
//! The operation runs on flex and ndarray, with autodiff and without. Tensors on any other device of burn's are taken by [`composed`]
//! instead, which needs nothing but burn's own operations; no such device is among those that the tests run on.
//!
//! # Gradients
//! The Wigner matrices are constants: the operation's backward pass hands on gradients of the features, the radial features and the
//! matrix, and none of how the edges lie. [`composed`] would hand them on.

mod kernel;
mod layout;
mod operation;

use burn::backend::Dispatch;
use burn::tensor::Tensor;

use self::operation::{EdgeMessageOps, Messages};
use super::{EdgeFrames, EdgeProduct, FiberFeatures};
use crate::host::on_host;
use crate::shape::must_be;

/// The messages of `product` at every edge, in one pass on flex and ndarray and by [`composed`] elsewhere; the Wigner matrices are
/// constants for the backward pass.
///
/// # Shapes
/// - `sources`: S points, the input's fiber
/// - `radial`: the radial features of every edge, `[E, H]`
/// - `weight`: from these to the kernel's weights, `[H, W]`
/// - output: for each output the components that are not zero, in the edges' frames, `[E, R, C']`
///
/// # Panics
/// Where a tensor has another shape, or the frames are of lower degrees than the input.
pub fn fused(
    product: &EdgeProduct,
    sources: &FiberFeatures,
    radial: Tensor<2>,
    weight: Tensor<2>,
    edges: &EdgeFrames,
) -> Vec<Tensor<3>> {
    check(product, sources, &radial, &weight, edges);
    if !on_host(&radial.device()) {
        return composed(product, sources, radial, weight, edges);
    }
    let messages = Messages::new(product, edges);
    let stacked = sources.stacked(product.input.max_degree);
    let output = <Dispatch as EdgeMessageOps>::edge_messages(
        stacked.into_dispatch(),
        radial.into_dispatch(),
        weight.into_dispatch(),
        edges.wigner.clone().into_dispatch(),
        messages,
    );
    let output = Tensor::<2>::from_dispatch(output);
    let [count, _] = output.dims();
    let mut first = 0;
    let outputs = product.outputs.iter().map(|fiber| {
        let rows = product.rows_of(fiber);
        first += rows * fiber.channels;
        let part = output.clone().narrow(1, first - rows * fiber.channels, rows * fiber.channels);
        part.reshape([count, rows, fiber.channels])
    });
    outputs.collect()
}

/// The same by burn's own operations, on every device: slow, and plain to read. The Wigner matrices get gradients here where they ask
/// for them.
///
/// # Shapes
/// As [`fused`].
///
/// # Panics
/// As [`fused`].
pub fn composed(
    product: &EdgeProduct,
    sources: &FiberFeatures,
    radial: Tensor<2>,
    weight: Tensor<2>,
    edges: &EdgeFrames,
) -> Vec<Tensor<3>> {
    check(product, sources, &radial, &weight, edges);
    let weights = product.split(&radial.matmul(weight));
    product.forward(edges.at_sources(sources, product.input.max_degree), weights)
}

/// The kernel reads slices, in which a wrong shape would be wrong numbers.
#[track_caller]
fn check(
    product: &EdgeProduct,
    sources: &FiberFeatures,
    radial: &Tensor<2>,
    weight: &Tensor<2>,
    edges: &EdgeFrames,
) {
    sources.must_have("edge messages", product.input.by_degree());
    edges.must_reach(product.input.max_degree);
    let ([rows, width], [edge_count, _]) = (radial.dims(), edges.presence.dims());
    must_be("edge messages: rows of radial features", edge_count, rows);
    must_be("edge messages: the matrix of kernel weights", [width, product.weight_count()], weight.dims());
}
