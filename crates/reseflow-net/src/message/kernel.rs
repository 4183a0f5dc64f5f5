//! The messages of a convolution on plain slices: gather, weigh and sum in one pass, and the gradients of that.
//!
//! An edge e from j to i with direction d, path weights p₀…p₄ and features s, v of j adds to i, channel by channel,
//!
//! - scalar: p₀ s + p₂ ⟨v, d⟩
//! - vector: p₁ d + p₃ v + p₄ v × d
//!
//! and without vectors at the sources only p₀ s and p₁ d.

use crate::host::Real;

/// What the kernels read; C channels, E edges of which `per_receiver` end at each receiver, S sources.
#[derive(Clone, Copy)]
pub(super) struct Edges<'a, F> {
    /// Source row of each edge, `[E]`.
    pub(super) sources: &'a [u32],
    /// Edges per receiver.
    pub(super) per_receiver: usize,
    /// `[3, E]`.
    pub(super) directions: &'a [F],
    /// `[E, paths · C]`, 5 paths with source vectors and 2 without.
    pub(super) paths: &'a [F],
    /// `[S, C]`.
    pub(super) scalars: &'a [F],
    /// `[3, S, C]`, or empty without source vectors.
    pub(super) vectors: &'a [F],
    /// C.
    pub(super) channels: usize,
}

/// The gradients of [`messages`]' inputs, each laid out as the input.
pub(super) struct Gradients<F> {
    pub(super) paths: Vec<F>,
    pub(super) scalars: Vec<F>,
    pub(super) vectors: Vec<F>,
}

impl<F: Real> Edges<'_, F> {
    fn direction(&self, edge: usize) -> [F; 3] {
        let edges = self.sources.len();
        [0, 1, 2].map(|axis| self.directions[axis * edges + edge])
    }

    /// Row `row` of component `axis` of `[3, rows, C]`.
    fn row<'b>(&self, values: &'b [F], axis: usize, row: usize) -> &'b [F] {
        let start = (axis * (values.len() / (3 * self.channels)) + row) * self.channels;
        &values[start..start + self.channels]
    }

    fn receivers(&self) -> usize {
        self.sources.len() / self.per_receiver
    }
}

/// The sum of the messages at every receiver, `[4, R, C]`: the scalar, then the vector's three components.
pub(super) fn messages<F: Real>(edges: &Edges<'_, F>) -> Vec<F> {
    let (channels, receivers) = (edges.channels, edges.receivers());
    let mut output = vec![F::default(); 4 * receivers * channels];
    let (to_scalar, rest) = output.split_at_mut(receivers * channels);
    let (to_x, rest) = rest.split_at_mut(receivers * channels);
    let (to_y, to_z) = rest.split_at_mut(receivers * channels);
    for (edge, &source) in edges.sources.iter().enumerate() {
        let (source, receiver) = (source as usize, edge / edges.per_receiver);
        let at = receiver * channels..(receiver + 1) * channels;
        let (sum, x, y, z) =
            (&mut to_scalar[at.clone()], &mut to_x[at.clone()], &mut to_y[at.clone()], &mut to_z[at.clone()]);
        let [dx, dy, dz] = edges.direction(edge);
        let scalar = &edges.scalars[source * channels..(source + 1) * channels];
        if edges.vectors.is_empty() {
            let paths = &edges.paths[2 * edge * channels..2 * (edge + 1) * channels];
            let (p0, p1) = paths.split_at(channels);
            for c in 0..channels {
                sum[c] += p0[c] * scalar[c];
                x[c] += p1[c] * dx;
                y[c] += p1[c] * dy;
                z[c] += p1[c] * dz;
            }
            continue;
        }
        let paths = &edges.paths[5 * edge * channels..5 * (edge + 1) * channels];
        let [p0, p1, p2, p3, p4] = [0, 1, 2, 3, 4].map(|path| &paths[path * channels..(path + 1) * channels]);
        let [vx, vy, vz] = [0, 1, 2].map(|axis| edges.row(edges.vectors, axis, source));
        for c in 0..channels {
            sum[c] += p0[c] * scalar[c] + p2[c] * (vx[c] * dx + vy[c] * dy + vz[c] * dz);
            x[c] += p1[c] * dx + p3[c] * vx[c] + p4[c] * (vy[c] * dz - vz[c] * dy);
            y[c] += p1[c] * dy + p3[c] * vy[c] + p4[c] * (vz[c] * dx - vx[c] * dz);
            z[c] += p1[c] * dz + p3[c] * vz[c] + p4[c] * (vx[c] * dy - vy[c] * dx);
        }
    }
    output
}

/// The gradients of [`messages`] where those of its output are `grad`, `[4, R, C]`.
pub(super) fn messages_backward<F: Real>(edges: &Edges<'_, F>, grad: &[F]) -> Gradients<F> {
    let (channels, receivers) = (edges.channels, edges.receivers());
    let mut gradients = Gradients {
        paths: vec![F::default(); edges.paths.len()],
        scalars: vec![F::default(); edges.scalars.len()],
        vectors: vec![F::default(); edges.vectors.len()],
    };
    let (from_x, rest) = gradients.vectors.split_at_mut(edges.vectors.len() / 3);
    let (from_y, from_z) = rest.split_at_mut(edges.vectors.len() / 3);
    for (edge, &source) in edges.sources.iter().enumerate() {
        let (source, receiver) = (source as usize, edge / edges.per_receiver);
        let [g0, gx, gy, gz] = [0, 1, 2, 3].map(|part| {
            let start = (part * receivers + receiver) * channels;
            &grad[start..start + channels]
        });
        let [dx, dy, dz] = edges.direction(edge);
        let own = source * channels..(source + 1) * channels;
        let scalar = &edges.scalars[own.clone()];
        let to_scalar = &mut gradients.scalars[own.clone()];
        if edges.vectors.is_empty() {
            let at = 2 * edge * channels..2 * (edge + 1) * channels;
            let p0 = &edges.paths[at.start..at.start + channels];
            let (to_p0, to_p1) = gradients.paths[at].split_at_mut(channels);
            for c in 0..channels {
                to_p0[c] = g0[c] * scalar[c];
                to_p1[c] = gx[c] * dx + gy[c] * dy + gz[c] * dz;
                to_scalar[c] += p0[c] * g0[c];
            }
            continue;
        }
        let at = 5 * edge * channels..5 * (edge + 1) * channels;
        let paths = &edges.paths[at.clone()];
        let [p0, _, p2, p3, p4] = [0, 1, 2, 3, 4].map(|path| &paths[path * channels..(path + 1) * channels]);
        let (to_p0, rest) = gradients.paths[at].split_at_mut(channels);
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
    gradients
}
