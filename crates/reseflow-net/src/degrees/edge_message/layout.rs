//! Where everything of a product lies in the slices that its kernel sees.

use super::kernel::{Layout, OrderBlock, OutputBlock};
use crate::degrees::frames::polar_order;
use crate::degrees::{EdgeProduct, UniformFiber};
use crate::irreps::{components, components_up_to};

impl EdgeProduct {
    /// Components of an output that are not zero: those of orders that the input has too.
    pub(crate) fn rows_of(&self, output: &UniformFiber) -> usize {
        let orders = 0..=self.input.max_degree.min(output.max_degree);
        orders.map(|order| (output.max_degree + 1 - order) * if order == 0 { 1 } else { 2 }).sum()
    }

    /// The layout of the messages along edges with Wigner matrices up to `frame_degree`.
    pub(super) fn layout(&self, frame_degree: usize) -> Layout {
        let input = self.input;
        let of_input = polar_order(frame_degree).into_iter().enumerate();
        let of_input = of_input.filter(|&(_, (degree, _))| degree <= input.max_degree);
        let rows = of_input.map(|(row, (degree, _))| {
            let first = degree * degree;
            (row, first, first + components(degree))
        });
        let mut starts = Vec::with_capacity(self.outputs.len());
        let mut values = 0;
        for output in &self.outputs {
            starts.push(values);
            values += self.rows_of(output) * output.channels;
        }
        let (mut first_input, mut first_weight) = (0, 0);
        let mut orders = Vec::new();
        for (order, size) in self.block_sizes().into_iter().enumerate() {
            let signs = if order == 0 { 1 } else { 2 };
            let inputs = (input.max_degree + 1 - order) * input.channels;
            let mut columns = 0;
            let mut outputs = Vec::new();
            for (output, start) in self.outputs.iter().zip(&mut starts) {
                let width = (output.max_degree + 1).saturating_sub(order) * output.channels;
                if width > 0 {
                    outputs.push(OutputBlock { first_column: columns, width, first_value: *start });
                }
                columns += width;
                *start += signs * width;
            }
            orders.push(OrderBlock { signs, inputs, first_input, first_weight, columns, outputs });
            first_input += signs * inputs;
            first_weight += size;
        }
        Layout {
            channels: input.channels,
            components: components_up_to(input.max_degree),
            rows: rows.collect(),
            wigner_size: components_up_to(frame_degree),
            orders,
            weights: first_weight,
            values,
        }
    }
}
