//! The messages of a convolution on plain slices, some edges at a time: gather, weigh and sum in one pass, and the gradients of that.
//!
//! An edge e from j to i with direction d, path weights p₀…p₄ and features s, v of j adds to i, channel by channel,
//!
//! - scalar: p₀ s + p₂ ⟨v, d⟩
//! - vector: p₁ d + p₃ v + p₄ v × d
//!
//! and without vectors at the sources only p₀ s and p₁ d. The path weights are linear in w silu(a), where a is what both ends and
//! the length say and w the envelope's weight.

use std::ops::Range;

use crate::host::Real;

/// What the kernels read; C channels, E edges of which `per_receiver` end at each receiver, S sources, R receivers.
#[derive(Clone, Copy)]
pub(super) struct Edges<'a, F> {
    /// Source row of each edge, `[E]`.
    pub(super) sources: &'a [u32],
    /// Edges per receiver.
    pub(super) per_receiver: usize,
    /// `[3, E]`.
    pub(super) directions: &'a [F],
    /// The envelope's weights, `[E]`.
    pub(super) envelope: &'a [F],
    /// The parts of a, of the sources `[S, C]`, the receivers `[R, C]` and the edges `[E, C]`.
    pub(super) activations: [&'a [F]; 3],
    /// `[S, C]`.
    pub(super) scalars: &'a [F],
    /// `[3, S, C]`, or empty without source vectors.
    pub(super) vectors: &'a [F],
    /// C.
    pub(super) channels: usize,
}

/// The gradients of the inputs, each laid out as the input.
pub(super) struct Gradients<F> {
    pub(super) activations: [Vec<F>; 3],
    pub(super) scalars: Vec<F>,
    pub(super) vectors: Vec<F>,
}

impl<F: Real> Edges<'_, F> {
    pub(super) fn receivers(&self) -> usize {
        self.sources.len() / self.per_receiver
    }

    /// Path weights of an edge for each channel.
    pub(super) fn paths(&self) -> usize {
        if self.vectors.is_empty() { 2 } else { 5 }
    }

    pub(super) fn no_gradients(&self) -> Gradients<F> {
        let none = |values: &[F]| vec![F::default(); values.len()];
        Gradients {
            activations: self.activations.map(none),
            scalars: none(self.scalars),
            vectors: none(self.vectors),
        }
    }

    fn direction(&self, edge: usize) -> [F; 3] {
        let edges = self.sources.len();
        [0, 1, 2].map(|axis| self.directions[axis * edges + edge])
    }

    /// Row `row` of component `axis` of `[3, rows, C]`.
    fn row<'b>(&self, values: &'b [F], axis: usize, row: usize) -> &'b [F] {
        let start = (axis * (values.len() / (3 * self.channels)) + row) * self.channels;
        &values[start..start + self.channels]
    }

    /// The rows of the activations' three parts.
    fn parts(&self, edge: usize) -> [Range<usize>; 3] {
        let rows = [self.sources[edge] as usize, edge / self.per_receiver, edge];
        rows.map(|row| row * self.channels..(row + 1) * self.channels)
    }
}

/// a of the edges of a tile, `[tile, C]`.
pub(super) fn activations<F: Real>(edges: &Edges<'_, F>, tile: Range<usize>, output: &mut Vec<F>) {
    output.clear();
    for edge in tile {
        let [source, receiver, along] = edges.parts(edge);
        let [of_source, of_receiver, of_edge] = edges.activations;
        let ends = of_source[source].iter().zip(&of_receiver[receiver]);
        output.extend(ends.zip(&of_edge[along]).map(|((&a, &b), &c)| a + b + c));
    }
}

/// w silu(a) of the edges of a tile, `[tile, C]`.
pub(super) fn hidden<F: Real>(edges: &Edges<'_, F>, tile: Range<usize>, activations: &[F]) -> Vec<F> {
    let mut hidden = Vec::with_capacity(activations.len());
    for (&weight, row) in edges.envelope[tile].iter().zip(activations.chunks_exact(edges.channels)) {
        hidden.extend(row.iter().map(|&a| weight * a * a.sigmoid()));
    }
    hidden
}

/// Hands the gradient of [`hidden`] of a tile on to the parts of a.
pub(super) fn hidden_backward<F: Real>(
    edges: &Edges<'_, F>,
    tile: Range<usize>,
    activations: &[F],
    grad: &[F],
    gradients: &mut Gradients<F>,
) {
    let channels = edges.channels;
    let rows = activations.chunks_exact(channels).zip(grad.chunks_exact(channels));
    for (edge, (row, grad)) in tile.zip(rows) {
        let weight = edges.envelope[edge];
        let [source, receiver, along] = edges.parts(edge);
        let [to_source, to_receiver, to_edge] = &mut gradients.activations;
        let to_edge = &mut to_edge[along];
        for (to_edge, (&a, &grad)) in to_edge.iter_mut().zip(row.iter().zip(grad)) {
            let sigmoid = a.sigmoid();
            *to_edge = weight * grad * sigmoid * (F::ONE + a * (F::ONE - sigmoid));
        }
        let targets = to_source[source].iter_mut().zip(&mut to_receiver[receiver]);
        for ((to_source, to_receiver), &to_edge) in targets.zip(&*to_edge) {
            *to_source += to_edge;
            *to_receiver += to_edge;
        }
    }
}

/// Adds a tile's messages to `output`, `[4, R, C]`: the scalar, then the vector's three components. `paths` are the tile's path
/// weights, `[tile, paths · C]`.
pub(super) fn messages<F: Real>(edges: &Edges<'_, F>, tile: Range<usize>, paths: &[F], output: &mut [F]) {
    let (channels, receivers) = (edges.channels, edges.receivers());
    let width = edges.paths() * channels;
    let (to_scalar, rest) = output.split_at_mut(receivers * channels);
    let (to_x, rest) = rest.split_at_mut(receivers * channels);
    let (to_y, to_z) = rest.split_at_mut(receivers * channels);
    for (edge, paths) in tile.zip(paths.chunks_exact(width)) {
        let (source, receiver) = (edges.sources[edge] as usize, edge / edges.per_receiver);
        let at = receiver * channels..(receiver + 1) * channels;
        let (sum, x, y, z) =
            (&mut to_scalar[at.clone()], &mut to_x[at.clone()], &mut to_y[at.clone()], &mut to_z[at.clone()]);
        let [dx, dy, dz] = edges.direction(edge);
        let scalar = &edges.scalars[source * channels..(source + 1) * channels];
        if edges.vectors.is_empty() {
            let (p0, p1) = paths.split_at(channels);
            for c in 0..channels {
                sum[c] += p0[c] * scalar[c];
                x[c] += p1[c] * dx;
                y[c] += p1[c] * dy;
                z[c] += p1[c] * dz;
            }
            continue;
        }
        let [p0, p1, p2, p3, p4] = [0, 1, 2, 3, 4].map(|path| &paths[path * channels..(path + 1) * channels]);
        let [vx, vy, vz] = [0, 1, 2].map(|axis| edges.row(edges.vectors, axis, source));
        for c in 0..channels {
            sum[c] += p0[c] * scalar[c] + p2[c] * (vx[c] * dx + vy[c] * dy + vz[c] * dz);
            x[c] += p1[c] * dx + p3[c] * vx[c] + p4[c] * (vy[c] * dz - vz[c] * dy);
            y[c] += p1[c] * dy + p3[c] * vy[c] + p4[c] * (vz[c] * dx - vx[c] * dz);
            z[c] += p1[c] * dz + p3[c] * vz[c] + p4[c] * (vx[c] * dy - vy[c] * dx);
        }
    }
}

/// The gradients of [`messages`] where those of its output are `grad`, `[4, R, C]`; that of the path weights is returned.
pub(super) fn messages_backward<F: Real>(
    edges: &Edges<'_, F>,
    tile: Range<usize>,
    paths: &[F],
    grad: &[F],
    gradients: &mut Gradients<F>,
) -> Vec<F> {
    let (channels, receivers) = (edges.channels, edges.receivers());
    let width = edges.paths() * channels;
    let mut to_paths = vec![F::default(); paths.len()];
    let (from_x, rest) = gradients.vectors.split_at_mut(edges.vectors.len() / 3);
    let (from_y, from_z) = rest.split_at_mut(edges.vectors.len() / 3);
    let rows = paths.chunks_exact(width).zip(to_paths.chunks_exact_mut(width));
    for (edge, (paths, to_paths)) in tile.zip(rows) {
        let (source, receiver) = (edges.sources[edge] as usize, edge / edges.per_receiver);
        let [g0, gx, gy, gz] = [0, 1, 2, 3].map(|part| {
            let start = (part * receivers + receiver) * channels;
            &grad[start..start + channels]
        });
        let [dx, dy, dz] = edges.direction(edge);
        let own = source * channels..(source + 1) * channels;
        let scalar = &edges.scalars[own.clone()];
        let to_scalar = &mut gradients.scalars[own.clone()];
        if edges.vectors.is_empty() {
            let p0 = &paths[..channels];
            let (to_p0, to_p1) = to_paths.split_at_mut(channels);
            for c in 0..channels {
                to_p0[c] = g0[c] * scalar[c];
                to_p1[c] = gx[c] * dx + gy[c] * dy + gz[c] * dz;
                to_scalar[c] += p0[c] * g0[c];
            }
            continue;
        }
        let [p0, _, p2, p3, p4] = [0, 1, 2, 3, 4].map(|path| &paths[path * channels..(path + 1) * channels]);
        let (to_p0, rest) = to_paths.split_at_mut(channels);
        let (to_p1, rest) = rest.split_at_mut(channels);
        let (to_p2, rest) = rest.split_at_mut(channels);
        let (to_p3, to_p4) = rest.split_at_mut(channels);
        let [vx, vy, vz] = [0, 1, 2].map(|axis| edges.row(edges.vectors, axis, source));
        let (to_vx, to_vy, to_vz) =
            (&mut from_x[own.clone()], &mut from_y[own.clone()], &mut from_z[own.clone()]);
        for c in 0..channels {
            to_p0[c] = g0[c] * scalar[c];
            to_p1[c] = gx[c] * dx + gy[c] * dy + gz[c] * dz;
            to_p2[c] = g0[c] * (vx[c] * dx + vy[c] * dy + vz[c] * dz);
            to_p3[c] = gx[c] * vx[c] + gy[c] * vy[c] + gz[c] * vz[c];
            // ⟨g, v × d⟩ = ⟨v, d × g⟩
            let (wx, wy, wz) = (dy * gz[c] - dz * gy[c], dz * gx[c] - dx * gz[c], dx * gy[c] - dy * gx[c]);
            to_p4[c] = vx[c] * wx + vy[c] * wy + vz[c] * wz;
            to_scalar[c] += p0[c] * g0[c];
            let along = p2[c] * g0[c];
            to_vx[c] += along * dx + p3[c] * gx[c] + p4[c] * wx;
            to_vy[c] += along * dy + p3[c] * gy[c] + p4[c] * wy;
            to_vz[c] += along * dz + p3[c] * gz[c] + p4[c] * wz;
        }
    }
    to_paths
}
