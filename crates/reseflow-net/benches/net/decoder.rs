//! The decoder by itself: one step for one scene, and a training step's forward and backward pass for a batch, at several sizes of the
//! cloud. What the decoder sees is nodes and centres, so its time should not depend on the points.

use divan::Bencher;
use divan::counter::ItemsCount;
use reseflow_net::{DecoderConfig, DriftNetConfig, EncodedScenes, EncoderConfig, Features};

use super::{BATCH, DEVICES, POINTS, Workload, device, finish, product};

/// Operations of the matrix products of the context of one scene, which is made once per observation.
fn context_operations() -> usize {
    let DriftNetConfig { encoder, decoder, .. } = DriftNetConfig::default();
    let EncoderConfig { channels, nodes, .. } = encoder;
    let DecoderConfig { frames, token_scalars, token_vectors, .. } = decoder;
    let vectors = frames * (nodes * (channels + 1) + 4);
    product(1, frames * (nodes * channels + 1) + 16, token_scalars)
        + product(3, vectors, token_vectors + 3 * nodes)
}

/// Operations of the matrix products of one step for one scene.
fn step_operations() -> usize {
    let DriftNetConfig { encoder, decoder, .. } = DriftNetConfig::default();
    let EncoderConfig { channels, nodes, graph, .. } = encoder;
    let DecoderConfig { horizon, frames, layers, token_scalars, token_vectors, pointers, .. } = decoder;
    let hidden = token_scalars + 2 * token_vectors;
    let interaction =
        product(3 * horizon, token_vectors, 3 * token_vectors) + 2 * product(horizon, hidden, hidden);
    // Queries, keys, values of both degrees, products of queries and keys, and the weighted sums.
    let attention = |rows: usize, memory: [usize; 2], key: usize| {
        product(horizon, token_scalars, key)
            + product(rows, memory[0], key + token_scalars)
            + product(3 * rows, memory[1], token_vectors)
            + product(horizon, key, rows)
            + product(horizon, rows, token_scalars + 3 * token_vectors)
    };
    let node = [channels, channels + 1];
    let centres = frames * graph.centres;
    let pointer = attention(centres, node, pointers * 16)
        + product(3 * horizon, token_vectors, pointers)
        + product(horizon, centres, 3 * pointers)
        + product(3 * horizon, pointers, token_vectors);
    let layer = interaction
        + attention(horizon, [token_scalars, token_vectors], 32)
        + attention(frames * nodes, node, 32)
        + pointer;
    product(horizon, 17, token_scalars)
        + product(3 * horizon, 4, token_vectors)
        + layers * layer
        + product(3 * horizon, token_vectors, 3 * nodes)
        + product(horizon, token_scalars, nodes + 1)
}

/// One step of the solver, one scene.
#[divan::bench(args = DEVICES, consts = [100, 128, 256, 1024])]
fn decode<const POINTS: usize>(bencher: Bencher, name: &str) {
    let workload = Workload::new(device(name), 1, POINTS);
    let context = workload.context();
    let bencher = bencher.counter(ItemsCount::new(step_operations()));
    bencher.bench(|| finish(workload.decode(&context).positions_m));
}

/// One step of the solver, a batch.
#[divan::bench(args = DEVICES)]
fn decode_a_batch(bencher: Bencher, name: &str) {
    let workload = Workload::new(device(name), BATCH, POINTS);
    let context = workload.context();
    let bencher = bencher.counter(ItemsCount::new(BATCH * step_operations()));
    bencher.bench(|| finish(workload.decode(&context).positions_m));
}

/// What was encoded, as if it were data.
fn detached(encoded: Vec<EncodedScenes>) -> Vec<EncodedScenes> {
    let constant = |features: Features| Features {
        scalars: features.scalars.detach(),
        vectors: features.vectors.detach(),
    };
    let frame = |frame: EncodedScenes| EncodedScenes {
        positions: frame.positions.detach(),
        nodes: constant(frame.nodes),
        heat: frame.heat.detach(),
        centres: constant(frame.centres),
        ..frame
    };
    encoded.into_iter().map(frame).collect()
}

/// A batch: the context, one step, and back through both; a backward pass has two products for each of the forward pass.
#[divan::bench(args = DEVICES, consts = [100, 128, 256, 1024])]
#[expect(clippy::expect_used, reason = "a bench may end where its own input is wrong")]
fn decode_forward_and_backward<const POINTS: usize>(bencher: Bencher, name: &str) {
    let workload = Workload::new(device(name).autodiff(), BATCH, POINTS);
    let encoded = detached(workload.encode());
    let operations = context_operations() + step_operations();
    let bencher = bencher.counter(ItemsCount::new(3 * BATCH * operations));
    bencher.bench(|| {
        let context = workload.net.context(&encoded, &workload.states).expect("sizes agree");
        let predicted = workload.decode(&context);
        (predicted.positions_m.square().sum() + predicted.rotations.square().sum()).backward()
    });
}
