//! The frame of every edge, in which the edge is the polar axis: Wigner matrices, computed once per cloud on the host in f64.
//!
//! An edge much shorter than a millimetre points nowhere in particular. What travels along it fades out by its *presence*
//! r/√(r² + ε²), so coincident points neither break equivariance nor make anything infinite.

use burn::tensor::{Device, Int, Tensor, TensorData};

use super::FiberFeatures;
use crate::irreps::{
    WignerMatrices, components, components_up_to, rotation_to_polar, spherical_harmonics_into,
};
use crate::scene_batch::{SHORTEST_DIRECTION_M, floats};
use crate::shape::must_be;
use crate::{EdgeTensors, NetError};

/// The degree and order of every component in an edge's frame, by |m|; within it first all +m, then all −m, by rising degree.
///
/// So the components that an SO(2)-linear map mixes lie side by side, and those of small |m| come first.
pub(crate) fn polar_order(max_degree: usize) -> Vec<(usize, i64)> {
    let mut order: Vec<_> = (0..=max_degree).map(|degree| (degree, 0)).collect();
    for m in 1..=max_degree as i64 {
        for signed in [m, -m] {
            order.extend((m as usize..=max_degree).map(|degree| (degree, signed)));
        }
    }
    order
}

/// Edges with their frames.
#[derive(Debug, Clone)]
pub struct EdgeFrames {
    /// The edges, grouped by receiver.
    pub edges: EdgeTensors,
    /// The highest degree l_max whose matrices are there.
    pub max_degree: usize,
    /// From the world's basis (by degree) to the edge's (by order), `[E, (l_max + 1)², (l_max + 1)²]`.
    pub wigner: Tensor<3>,
    /// How far the edge has a direction, in \[0, 1\], `[E, 1]`.
    pub presence: Tensor<2>,
}

impl EdgeFrames {
    /// The frames of `edges`, whose displacements (source minus receiver, metres) are given in the same order.
    ///
    /// # Errors
    /// [`NetError::Mismatch`] where there is not one displacement for each edge.
    pub fn new<'a>(
        edges: EdgeTensors,
        displacement_m: impl Iterator<Item = &'a [f64; 3]>,
        max_degree: usize,
        device: &Device,
    ) -> Result<Self, NetError> {
        let size = components_up_to(max_degree);
        let order = polar_order(max_degree);
        let (mut wigner, mut presence) = (Vec::new(), Vec::new());
        for displacement in displacement_m {
            let squared: f64 = displacement.iter().map(|value| value * value).sum();
            presence.push((squared / (squared + SHORTEST_DIRECTION_M * SHORTEST_DIRECTION_M)).sqrt());
            let matrices = WignerMatrices::new(max_degree, &rotation_to_polar(displacement));
            for &(degree, m) in &order {
                let first = wigner.len() + degree * degree;
                wigner.resize(wigner.len() + size, 0.0);
                let row = (m + degree as i64) as usize * components(degree);
                wigner[first..first + components(degree)]
                    .copy_from_slice(&matrices.blocks[degree][row..row + components(degree)]);
            }
        }
        let count = presence.len();
        let [expected, _] = edges.weights.dims();
        if count != expected {
            return Err(NetError::Mismatch { what: "displacements of edges", expected, got: count });
        }
        Ok(Self {
            edges,
            max_degree,
            wigner: floats(wigner, [count, size, size], device),
            presence: floats(presence, [count, 1], device),
        })
    }

    /// Panics where there are no matrices up to `max_degree`.
    #[track_caller]
    pub(crate) fn must_reach(&self, max_degree: usize) {
        let reached = self.max_degree;
        assert!(
            max_degree <= reached,
            "frames of edges: expected degrees up to {max_degree}, got up to {reached}"
        );
    }

    /// The matrices of degrees 0 … `max_degree` alone, `[E, (l + 1)², (l + 1)²]`.
    fn wigner_up_to(&self, max_degree: usize) -> Tensor<3> {
        self.must_reach(max_degree);
        if max_degree == self.max_degree {
            return self.wigner.clone();
        }
        let rows: Vec<i64> = (polar_order(self.max_degree).iter().zip(0..))
            .filter_map(|(&(degree, _), row)| (degree <= max_degree).then_some(row))
            .collect();
        let rows: Tensor<1, Int> =
            Tensor::from_data(TensorData::new(rows, [components_up_to(max_degree)]), &self.wigner.device());
        self.wigner.clone().narrow(2, 0, components_up_to(max_degree)).select(1, rows)
    }

    /// The sources' features at every edge, in its frame.
    ///
    /// # Shapes
    /// - `sources`: S points with C channels in degrees 0 … `max_degree` at least
    /// - output: `[E, (max_degree + 1)², C]`
    ///
    /// # Panics
    /// Where features or frames are of lower degrees, or degrees differ in their channels.
    pub fn at_sources(&self, sources: &FiberFeatures, max_degree: usize) -> Tensor<3> {
        let stacked = sources.stacked(max_degree);
        let [points, size, channels] = stacked.dims();
        let [edges, _] = self.presence.dims();
        // Whole rows are gathered, which is one contiguous copy an edge.
        let gathered = stacked.reshape([points, size * channels]).select(0, self.edges.sources.clone());
        let gathered = gathered.reshape([edges, size, channels]);
        if max_degree == 0 { gathered } else { self.wigner_up_to(max_degree).matmul(gathered) }
    }

    /// The receivers' features at every edge, in its frame.
    ///
    /// # Shapes
    /// - `receivers`: P points with C channels in degrees 0 … `max_degree` at least
    /// - output: `[E, (max_degree + 1)², C]`
    ///
    /// # Panics
    /// As [`Self::at_sources`], and where there are not as many points as receivers.
    pub fn at_receivers(&self, receivers: &FiberFeatures, max_degree: usize) -> Tensor<3> {
        let stacked = receivers.stacked(max_degree);
        let [points, size, channels] = stacked.dims();
        let per_receiver = self.edges.per_receiver;
        let edges = points * per_receiver;
        must_be("frames of edges: edges of all receivers", self.presence.dims()[0], edges);
        if max_degree == 0 {
            return stacked.expand([points, per_receiver, channels]).reshape([edges, 1, channels]);
        }
        let frames = self.wigner_up_to(max_degree).reshape([points, per_receiver * size, size]);
        frames.matmul(stacked).reshape([edges, size, channels])
    }

    /// The sum over every receiver's edges of messages that are in the edges' frames: turned back and added up in one product.
    ///
    /// # Shapes
    /// - `messages`: `[E, R, C]`, the first R components of the frame; the others are zero
    /// - output: degrees 0 … `max_degree` of P points, C channels
    ///
    /// # Panics
    /// Where there is not one message for each edge, or frames are of lower degrees.
    pub fn sum_at_receivers(&self, messages: Tensor<3>, max_degree: usize) -> FiberFeatures {
        let [edges, rows, channels] = messages.dims();
        must_be("frames of edges: messages", self.presence.dims()[0], edges);
        let per_receiver = self.edges.per_receiver;
        let receivers = edges / per_receiver;
        let size = components_up_to(max_degree);
        let summed = if max_degree == 0 {
            messages.reshape([receivers, per_receiver, channels]).sum_dim(1)
        } else {
            let frames = self.wigner_up_to(max_degree).narrow(1, 0, rows);
            let frames = frames.reshape([receivers, per_receiver * rows, size]).swap_dims(1, 2);
            frames.matmul(messages.reshape([receivers, per_receiver * rows, channels]))
        };
        FiberFeatures::unstacked(max_degree, summed)
    }
}

/// The harmonics of every edge's direction, which only the plain Clebsch–Gordan form of a product needs.
#[derive(Debug, Clone)]
pub struct EdgeHarmonics {
    /// By degree J, `[E, 2J + 1]`.
    pub degrees: Vec<Tensor<2>>,
}

impl EdgeHarmonics {
    /// Harmonics up to `max_degree`, which is l_in + l_out for a product.
    pub fn new<'a>(
        displacement_m: impl Iterator<Item = &'a [f64; 3]>,
        max_degree: usize,
        device: &Device,
    ) -> Self {
        let mut values = Vec::new();
        for displacement in displacement_m {
            let length = displacement.iter().map(|value| value * value).sum::<f64>().sqrt();
            let unit = if length > 0.0 { displacement.map(|value| value / length) } else { [0.0; 3] };
            spherical_harmonics_into(max_degree, &unit, &mut values);
        }
        let size = components_up_to(max_degree);
        let all: Tensor<2> = floats(values.clone(), [values.len() / size, size], device);
        let degree = |l: usize| all.clone().narrow(1, l * l, components(l));
        Self { degrees: (0..=max_degree).map(degree).collect() }
    }
}
