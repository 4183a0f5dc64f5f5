//! The same product path by path: l ⊗ J → l' with Clebsch–Gordan coefficients (Tensor Field Networks, arXiv 1802.08219), O(l⁶) work.
//!
//! It is the oracle of the form in the edge's frame, and how weights of other libraries are read. Path weights and kernel weights
//! say the same: the kernel of path J along the polar axis is T_J = √(2J + 1) C\[·, 0, ·\], and the T_J are orthonormal.

use burn::tensor::{Int, Tensor, TensorData};

use super::{EdgeFrames, EdgeHarmonics, EdgeProduct, FiberFeatures, KernelPart, KernelWeight, UniformFiber};
use crate::irreps::{clebsch_gordan, components};
use crate::scene_batch::floats;

/// l ⊗ J → l', for one of the outputs of a product.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Path {
    /// The degree l of the features.
    pub degree_in: usize,
    /// The degree J of the edge's harmonic.
    pub degree_edge: usize,
    /// Which of the outputs.
    pub output_index: usize,
    /// Its degree l'.
    pub degree_out: usize,
}

/// A path's weight from one channel to another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PathWeight {
    /// The path.
    pub path: Path,
    /// The channel in.
    pub channel_in: usize,
    /// The channel out.
    pub channel_out: usize,
}

/// T_J at one place of the kernel.
fn kernel_of_path(path: &Path, order: usize, part: KernelPart) -> f64 {
    let m = order as i64;
    let out = if part == KernelPart::Same { m } else { -m };
    let coefficients = clebsch_gordan(path.degree_in, path.degree_edge, path.degree_out);
    ((2 * path.degree_edge + 1) as f64).sqrt() * coefficients.entry(m, 0, out)
}

/// The parts of the kernel between two degrees.
fn kernel_parts(degree_in: usize, degree_out: usize) -> Vec<(usize, KernelPart)> {
    let orders = 1..=degree_in.min(degree_out);
    let pairs = orders.flat_map(|order| [(order, KernelPart::Same), (order, KernelPart::Across)]);
    std::iter::once((0, KernelPart::Same)).chain(pairs).collect()
}

impl EdgeProduct {
    /// The kernel weights of one edge that are the same product as these path weights.
    pub fn kernel_weights(&self, path_weight: impl Fn(&PathWeight) -> f64) -> Vec<f64> {
        let kernel_weight = |weight: KernelWeight| -> f64 {
            let KernelWeight { order, part, input, output_index, output } = weight;
            (input.0.abs_diff(output.0)..=input.0 + output.0)
                .map(|degree_edge| {
                    let path = Path { degree_in: input.0, degree_edge, output_index, degree_out: output.0 };
                    let weight = PathWeight { path, channel_in: input.1, channel_out: output.1 };
                    kernel_of_path(&path, order, part) * path_weight(&weight)
                })
                .sum()
        };
        self.weights().into_iter().map(kernel_weight).collect()
    }

    /// The weights of one path at every edge, `[E, C', C]`, from kernel weights `[E, W]`.
    fn path_weights(&self, path: &Path, weights: &Tensor<2>) -> Tensor<3> {
        let (inputs, outputs) = (self.input.channels, self.outputs[path.output_index].channels);
        let [edges, _] = weights.dims();
        let terms = kernel_parts(path.degree_in, path.degree_out).into_iter().map(|(order, part)| {
            let place = |channel_out: usize, channel_in: usize| {
                let weight = KernelWeight {
                    order,
                    part,
                    input: (path.degree_in, channel_in),
                    output_index: path.output_index,
                    output: (path.degree_out, channel_out),
                };
                self.position(&weight) as i64
            };
            let places: Vec<i64> =
                (0..outputs).flat_map(|out| (0..inputs).map(move |input| place(out, input))).collect();
            let places: Tensor<1, Int> =
                Tensor::from_data(TensorData::new(places, [inputs * outputs]), &weights.device());
            // Both +m and −m hold the same number.
            let multiplicity = if order == 0 { 1.0 } else { 2.0 };
            weights.clone().select(1, places).mul_scalar(multiplicity * kernel_of_path(path, order, part))
        });
        sum(terms).reshape([edges, outputs, inputs])
    }

    /// The product path by path, with the same weights as [`EdgeProduct::forward`] and the same result, in the world's frame.
    ///
    /// # Shapes
    /// - `sources`: S points, the input's fiber
    /// - `weights`: `[E, W]`
    /// - output: for each output, by degree, `[E, 2l' + 1, C']`
    ///
    /// # Panics
    /// Where the sources are of another fiber, or `harmonics` not of degrees up to l_in + l_out.
    pub fn forward_by_paths(
        &self,
        sources: &FiberFeatures,
        weights: &Tensor<2>,
        edges: &EdgeFrames,
        harmonics: &EdgeHarmonics,
    ) -> Vec<Vec<Tensor<3>>> {
        sources.must_be_of("product by paths", self.input.by_degree());
        let gathered: Vec<Tensor<3>> = (sources.degrees.iter())
            .map(|degree| degree.clone().swap_dims(0, 1).select(0, edges.edges.sources.clone()))
            .collect();
        let output = |(output_index, output): (usize, &UniformFiber)| {
            let degree = |degree_out: usize| {
                let pairs = (0..=self.input.max_degree).flat_map(|degree_in| {
                    let edge_degrees = degree_in.abs_diff(degree_out)..=degree_in + degree_out;
                    edge_degrees.map(move |degree_edge| Path {
                        degree_in,
                        degree_edge,
                        output_index,
                        degree_out,
                    })
                });
                let messages = pairs.map(|path| {
                    let turned = path_basis(&path, &harmonics.degrees[path.degree_edge])
                        .matmul(gathered[path.degree_in].clone());
                    turned.matmul(self.path_weights(&path, weights).swap_dims(1, 2))
                });
                sum(messages)
            };
            (0..=output.max_degree).map(degree).collect()
        };
        self.outputs.iter().enumerate().map(output).collect()
    }
}

/// Adds up; there is always at least one term, because two degrees always have a path.
fn sum<const D: usize>(terms: impl Iterator<Item = Tensor<D>>) -> Tensor<D> {
    let Some(sum) = terms.reduce(|a, b| a + b) else { unreachable!("no path between two degrees") };
    sum
}

/// Σ_M C\[m, M, m'\] Y_M at every edge, `[E, 2l' + 1, 2l + 1]`.
fn path_basis(path: &Path, harmonics: &Tensor<2>) -> Tensor<3> {
    let coefficients = clebsch_gordan(path.degree_in, path.degree_edge, path.degree_out);
    let [edges, _] = harmonics.dims();
    let [ins, middles, outs] = coefficients.degrees.map(components);
    let entry = |middle: usize, out: usize, input: usize| {
        coefficients.values[(input * middles + middle) * outs + out]
    };
    let values = (0..middles)
        .flat_map(|middle| (0..outs).flat_map(move |out| (0..ins).map(move |input| (middle, out, input))))
        .map(|(middle, out, input)| entry(middle, out, input))
        .collect();
    let matrix: Tensor<2> = floats(values, [middles, outs * ins], &harmonics.device());
    harmonics.clone().matmul(matrix).reshape([edges, outs, ins])
}
