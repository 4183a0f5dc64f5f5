//! The tensor product of features with the harmonics of an edge, in the edge's frame (eSCN, arXiv 2302.03655).
//!
//! Along the polar axis only the harmonics with m = 0 are not zero, so the kernel commutes with turns about the axis and mixes
//! component +m with ±m alone: y₊ = A x₊ − B x₋, y₋ = B x₊ + A x₋, with A and B any matrices from the channels of all degrees in to
//! those of all degrees out. These are 2 min(l, l') + 1 numbers for each pair of degrees and channels, as many as there are paths
//! l ⊗ J → l', and O(l³) work instead of O(l⁶).

use burn::tensor::Tensor;

use super::UniformFiber;
use crate::irreps::components_up_to;
use crate::shape::must_be;

/// The shape of a product; the weights come with each call, one set an edge.
#[derive(Debug, Clone, PartialEq)]
pub struct EdgeProduct {
    /// What comes in.
    pub input: UniformFiber,
    /// What goes out; several outputs share one pass.
    pub outputs: Vec<UniformFiber>,
}

/// Which of the two matrices of an order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum KernelPart {
    /// A, from +m to +m and −m to −m.
    Same,
    /// B, from +m to −m and, negated, −m to +m; none for m = 0.
    Across,
}

/// One weight of the kernel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct KernelWeight {
    /// The order |m|, at most both degrees.
    pub order: usize,
    /// The matrix.
    pub part: KernelPart,
    /// Degree and channel in.
    pub input: (usize, usize),
    /// Which of the outputs.
    pub output_index: usize,
    /// Degree and channel out.
    pub output: (usize, usize),
}

impl EdgeProduct {
    /// The highest order m that reaches an output.
    pub(crate) fn max_order(&self) -> usize {
        let highest = self.outputs.iter().map(|output| output.max_degree).max().unwrap_or(0);
        self.input.max_degree.min(highest)
    }

    fn inputs_at(&self, order: usize) -> usize {
        (self.input.max_degree + 1 - order) * self.input.channels
    }

    fn outputs_at(&self, order: usize) -> usize {
        self.outputs.iter().map(|output| width_at(output, order)).sum()
    }

    /// Weights of one order, row-major `[inputs, outputs]`; for m > 0 `[2·inputs, outputs]`, A above B.
    fn block(&self, order: usize) -> (usize, usize) {
        let parts = if order == 0 { 1 } else { 2 };
        (parts * self.inputs_at(order), self.outputs_at(order))
    }

    /// Weights W of one edge.
    pub fn weight_count(&self) -> usize {
        self.block_start(self.max_order() + 1)
    }

    /// Weights of each order, in turn.
    pub(crate) fn block_sizes(&self) -> Vec<usize> {
        (0..=self.max_order()).map(|order| self.block_start(order + 1) - self.block_start(order)).collect()
    }

    /// Weights of all orders, `[E, W]`, as [`Self::forward`] takes them.
    pub fn split(&self, weights: &Tensor<2>) -> Vec<Tensor<2>> {
        let mut first = 0;
        let block = |size: usize| {
            first += size;
            weights.clone().narrow(1, first - size, size)
        };
        self.block_sizes().into_iter().map(block).collect()
    }

    fn block_start(&self, order: usize) -> usize {
        (0..order)
            .map(|order| {
                let (rows, columns) = self.block(order);
                rows * columns
            })
            .sum()
    }

    /// Multiplications and additions of [`Self::forward`] for one edge: one of each where A or B meets a component.
    pub fn operations(&self) -> usize {
        let at = |order: usize| {
            let (rows, columns) = self.block(order);
            if order == 0 { 2 * rows * columns } else { 4 * rows * columns }
        };
        (0..=self.max_order()).map(at).sum()
    }

    /// The same of [`Self::forward_by_paths`], its dense coefficients and the sum that makes path weights not counted.
    pub fn operations_by_paths(&self) -> usize {
        let components = |degree: usize| 2 * degree + 1;
        let mut sum = 0;
        for output in &self.outputs {
            for degree_out in 0..=output.max_degree {
                for degree_in in 0..=self.input.max_degree {
                    for degree_edge in degree_in.abs_diff(degree_out)..=degree_in + degree_out {
                        let (ins, outs) = (components(degree_in), components(degree_out));
                        let basis = components(degree_edge) * ins * outs;
                        let channels = self.input.channels * (ins + output.channels);
                        sum += 2 * (basis + outs * channels);
                    }
                }
            }
        }
        sum
    }

    /// Where `weight` lies among the weights of an edge.
    pub fn position(&self, weight: &KernelWeight) -> usize {
        let KernelWeight { order, part, input, output_index, output } = *weight;
        let row = (input.0 - order) * self.input.channels + input.1;
        let row = row + if part == KernelPart::Across { self.inputs_at(order) } else { 0 };
        let before: usize = self.outputs[..output_index].iter().map(|other| width_at(other, order)).sum();
        let column = before + (output.0 - order) * self.outputs[output_index].channels + output.1;
        self.block_start(order) + row * self.outputs_at(order) + column
    }

    /// All weights, in order of position.
    pub fn weights(&self) -> Vec<KernelWeight> {
        let mut weights = Vec::with_capacity(self.weight_count());
        for order in 0..=self.max_order() {
            let parts =
                if order == 0 { &[KernelPart::Same][..] } else { &[KernelPart::Same, KernelPart::Across] };
            for &part in parts {
                for input in pairs(order, &self.input) {
                    for (output_index, output) in self.outputs.iter().enumerate() {
                        let outputs = pairs(order, output);
                        weights.extend(outputs.map(|output| KernelWeight {
                            order,
                            part,
                            input,
                            output_index,
                            output,
                        }));
                    }
                }
            }
        }
        weights
    }

    /// Standard deviations of the weights under which standard normal inputs give outputs of mean square one per component, and
    /// every path l ⊗ J → l' weighs the same.
    pub(crate) fn standard_deviations(&self) -> Vec<f64> {
        let fan_in = |degree: usize| {
            let terms = (0..=self.input.max_degree).map(|other| 2 * degree.min(other) + 1).sum::<usize>();
            (self.input.channels * terms) as f64 / (2 * degree + 1) as f64
        };
        let deviation = |weight: KernelWeight| {
            let halves = if weight.order == 0 { 1.0 } else { 2.0 };
            (halves * fan_in(weight.output.0)).sqrt().recip()
        };
        self.weights().into_iter().map(deviation).collect()
    }

    /// The product at every edge.
    ///
    /// # Shapes
    /// - `sources`: in the edges' frames, components by order, `[E, (l_in + 1)², C]`
    /// - `weights`: for each order in turn, `[E, Wₘ]`
    /// - output: for each output the components that are not zero, those of order ≤ `min(l_in, l_out)`, `[E, R, C']`
    ///
    /// # Panics
    /// Where a tensor has another shape.
    pub fn forward(&self, sources: Tensor<3>, weights: Vec<Tensor<2>>) -> Vec<Tensor<3>> {
        let [edges, _, _] = sources.dims();
        let expected = [edges, components_up_to(self.input.max_degree), self.input.channels];
        must_be("edge product: sources", expected, sources.dims());
        must_be("edge product: orders of weights", self.max_order() + 1, weights.len());
        let mut parts: Vec<Vec<Tensor<3>>> = vec![Vec::new(); self.outputs.len()];
        let mut component = 0;
        for (order, kernel) in weights.into_iter().enumerate() {
            let (signs, degrees) = (if order == 0 { 1 } else { 2 }, self.input.max_degree + 1 - order);
            let (rows, columns) = self.block(order);
            let kernel = kernel.reshape([edges, rows, columns]);
            let values = sources.clone().narrow(1, component, signs * degrees);
            component += signs * degrees;
            let values = values.reshape([edges, signs, self.inputs_at(order)]);
            let values = if order == 0 {
                values
            } else {
                let across =
                    Tensor::cat(vec![-values.clone().narrow(1, 1, 1), values.clone().narrow(1, 0, 1)], 1);
                Tensor::cat(vec![values, across], 2)
            };
            let product = values.matmul(kernel);
            let mut column = 0;
            for (output, parts) in self.outputs.iter().zip(&mut parts) {
                let width = width_at(output, order);
                if width > 0 {
                    let part = product.clone().narrow(2, column, width);
                    parts.push(part.reshape([edges, signs * width / output.channels, output.channels]));
                }
                column += width;
            }
        }
        let joined = |mut parts: Vec<Tensor<3>>| {
            if parts.len() == 1 { parts.remove(0) } else { Tensor::cat(parts, 1) }
        };
        parts.into_iter().map(joined).collect()
    }
}

/// Degree and channel of everything that has components of this order.
fn pairs(order: usize, fiber: &UniformFiber) -> impl Iterator<Item = (usize, usize)> + use<> {
    let channels = fiber.channels;
    (order..=fiber.max_degree).flat_map(move |degree| (0..channels).map(move |channel| (degree, channel)))
}

/// Channels of all degrees that have components of this order.
fn width_at(fiber: &UniformFiber, order: usize) -> usize {
    (fiber.max_degree + 1).saturating_sub(order) * fiber.channels
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_weight_has_its_own_place_and_there_are_as_many_as_paths() {
        let input = UniformFiber { max_degree: 3, channels: 2 };
        let outputs =
            vec![UniformFiber { max_degree: 1, channels: 3 }, UniformFiber { max_degree: 4, channels: 1 }];
        let product = EdgeProduct { input, outputs };
        let weights = product.weights();
        for (place, weight) in weights.iter().enumerate() {
            assert_eq!(product.position(weight), place);
        }
        let paths = |highest: usize| -> usize {
            (0..=3).flat_map(|a| (0..=highest).map(move |b: usize| 2 * b.min(a) + 1)).sum()
        };
        assert_eq!(weights.len(), 2 * (3 * paths(1) + paths(4)));
        assert_eq!(product.weight_count(), weights.len());
    }

    /// One scalar to one scalar is one product; from a vector to a vector by hand: m = 0 is one, m = 1 mixes two numbers with two
    /// matrices.
    #[test]
    fn operations_are_those_counted_by_hand() {
        let uniform = |max_degree, channels| UniformFiber { max_degree, channels };
        let product = |degree, channels| EdgeProduct {
            input: uniform(degree, channels),
            outputs: vec![uniform(degree, channels)],
        };
        assert_eq!(product(0, 3).operations(), 2 * 9);
        assert_eq!(product(1, 1).operations(), 2 * 4 + 2 * 4);
        assert_eq!(product(0, 3).operations_by_paths(), 2 * (1 + 3 * (1 + 3)));
        for degree in 1..4 {
            assert!(product(degree, 8).operations() < product(degree, 8).operations_by_paths());
        }
    }
}
