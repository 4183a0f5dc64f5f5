//! The message kernel against the same messages by burn's own operations, values and gradients alike.

use burn::tensor::{Device, Tensor};
use reseflow_net::message::{EdgeActivations, composed, fused};
use reseflow_net::{EdgeTensors, Features};

use super::layers::{CHANNELS, GRAPH, batch, clouds};
use super::world::World;
use super::{assert_small, devices, normals, rng, tensor, values, worse, worst_difference};

/// Points of both clouds of [`clouds`].
const POINTS: usize = 65;

/// What a form of the messages gives: both outputs, and the gradients of a random linear function of them by all inputs, the vectors
/// last.
fn outcome(
    form: fn(&Features, EdgeActivations, &EdgeTensors) -> Features,
    source_vectors: bool,
    device: &Device,
) -> Vec<Vec<f64>> {
    let device = device.clone().autodiff();
    let mut rng = rng(41);
    let batch = batch(&clouds(&mut rng), &World::identity(), &device);
    let (edges, nodes, paths) = if source_vectors {
        (&batch.centre_edges, 2 * GRAPH.centres, 5)
    } else {
        (&batch.point_edges, POINTS, 2)
    };
    let mut draw = |count: usize| normals(count, &mut rng);
    let edge_count = 2 * GRAPH.centres * edges.per_receiver;
    let receivers = 2 * GRAPH.centres;
    let mut input =
        |rows: usize, width: usize| tensor::<2>(draw(rows * width), [rows, width], &device).require_grad();
    let activations = EdgeActivations {
        sources: input(nodes, CHANNELS),
        receivers: input(receivers, CHANNELS),
        edges: input(edge_count, CHANNELS),
        matrix: input(CHANNELS, paths * CHANNELS),
    };
    let scalars = tensor(draw(nodes * CHANNELS), [nodes, CHANNELS], &device).require_grad();
    let vectors = tensor(draw(3 * nodes * CHANNELS), [3, nodes, CHANNELS], &device).require_grad();
    let output =
        form(&Features { scalars: scalars.clone(), vectors: vectors.clone() }, activations.clone(), edges);
    let weights = [0, 1, 2, 3]
        .map(|_| tensor::<2>(draw(2 * GRAPH.centres * CHANNELS), [2 * GRAPH.centres, CHANNELS], &device));
    let [first, rest @ ..] = weights;
    let loss = (output.scalars.clone() * first).sum()
        + (output.vectors.clone() * Tensor::stack(rest.to_vec(), 0)).sum();
    let gradients = loss.backward();
    let of_vectors = vectors.grad(&gradients).map_or_else(Vec::new, |gradient| values(&gradient));
    let mut all = vec![values(&output.scalars), values(&output.vectors)];
    let EdgeActivations { sources, receivers, edges, matrix } = activations;
    for input in [sources, receivers, edges, matrix, scalars] {
        all.push(values(&input.grad(&gradients).expect("every input has a gradient")));
    }
    all.push(of_vectors);
    all
}

/// Values and gradients agree to `tolerance` with entries of order one.
pub(crate) fn the_message_kernel_equals_its_composed_form(tolerance: f64) {
    for (name, device) in devices() {
        for source_vectors in [false, true] {
            let fast = outcome(fused, source_vectors, &device);
            let plain = outcome(composed, source_vectors, &device);
            let worst = fast.iter().zip(&plain).map(|(fast, plain)| worst_difference(fast, plain));
            assert_eq!(
                plain[7].is_empty(),
                !source_vectors,
                "without their paths the vectors have no gradient"
            );
            assert_small(
                &format!("messages on {name}, source vectors: {source_vectors}"),
                worst.fold(0.0, worse),
                tolerance,
            );
        }
    }
}
