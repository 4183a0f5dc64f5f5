//! Messages of all degrees on plain slices, one edge after another: gather, turn into the edge's frame, multiply; and the gradients.
//!
//! In the edge's frame order +m and −m of the input, x₊ and x₋, become y₊ = A x₊ − B x₋ and y₋ = B x₊ + A x₋. A and B are the edge's
//! own, rows for what comes in and columns for what goes out.

use crate::host::Real;

/// Where the parts of one order m lie, in an edge's weights, its input and its outputs.
#[derive(Debug, Clone)]
pub(super) struct OrderBlock {
    /// One component (m = 0) or two (±m).
    pub(super) signs: usize,
    /// Degrees times channels in.
    pub(super) inputs: usize,
    /// First of the inputs of +m; those of −m follow.
    pub(super) first_input: usize,
    /// First of the weights: A, and for m > 0 B after it, each `[inputs, columns]`.
    pub(super) first_weight: usize,
    /// Columns of A and of B.
    pub(super) columns: usize,
    /// The outputs that have this order.
    pub(super) outputs: Vec<OutputBlock>,
}

/// The part of one output in the columns of an order.
#[derive(Debug, Clone)]
pub(super) struct OutputBlock {
    /// First of its columns.
    pub(super) first_column: usize,
    /// Its columns.
    pub(super) width: usize,
    /// First of its values of +m in an edge's output row; those of −m follow.
    pub(super) first_value: usize,
}

/// The shape of the messages of one layer.
#[derive(Debug, Clone)]
pub(super) struct Layout {
    /// Channels of the input.
    pub(super) channels: usize,
    /// Components of the input, (l + 1)².
    pub(super) components: usize,
    /// For each component in the edge's frame its row of the Wigner matrix, and the first and last of the columns that are not zero.
    pub(super) rows: Vec<(usize, usize, usize)>,
    /// Rows and columns of the Wigner matrix.
    pub(super) wigner_size: usize,
    /// By order.
    pub(super) orders: Vec<OrderBlock>,
    /// Weights of an edge.
    pub(super) weights: usize,
    /// Values of an edge's output row, all outputs side by side.
    pub(super) values: usize,
}

impl Layout {
    /// Numbers of an edge's input.
    pub(super) fn inputs(&self) -> usize {
        self.components * self.channels
    }
}

/// What an edge sees besides its weights.
pub(super) struct Edge<'a, F> {
    /// The Wigner matrix, row-major.
    pub(super) wigner: &'a [F],
    /// The source's features, `[components, channels]` in the world's frame.
    pub(super) source: &'a [F],
}

/// The source's features in the edge's frame.
pub(super) fn turn<F: Real>(layout: &Layout, edge: &Edge<'_, F>, turned: &mut [F]) {
    let channels = layout.channels;
    for (turned, &(row, first, last)) in turned.chunks_exact_mut(channels).zip(&layout.rows) {
        turned.fill(F::default());
        let entries = &edge.wigner[row * layout.wigner_size + first..][..last - first];
        let sources = edge.source[first * channels..last * channels].chunks_exact(channels);
        for (&entry, source) in entries.iter().zip(sources) {
            add_scaled(turned, entry, source);
        }
    }
}

/// Adds what [`turn`] makes of a gradient in the edge's frame to that of the source.
pub(super) fn turn_back<F: Real>(layout: &Layout, wigner: &[F], grad: &[F], to_source: &mut [F]) {
    let channels = layout.channels;
    for (grad, &(row, first, last)) in grad.chunks_exact(channels).zip(&layout.rows) {
        let entries = &wigner[row * layout.wigner_size + first..][..last - first];
        let targets = to_source[first * channels..last * channels].chunks_exact_mut(channels);
        for (&entry, target) in entries.iter().zip(targets) {
            add_scaled(target, entry, grad);
        }
    }
}

fn add_scaled<F: Real>(sum: &mut [F], scale: F, values: &[F]) {
    for (sum, &value) in sum.iter_mut().zip(values) {
        *sum += scale * value;
    }
}

/// An edge's message from its turned input and its weights; `message` is overwritten.
pub(super) fn message<F: Real>(layout: &Layout, turned: &[F], weights: &[F], message: &mut [F]) {
    message.fill(F::default());
    for order in &layout.orders {
        let (ins, columns) = (order.inputs, order.columns);
        let values = &turned[order.first_input..][..order.signs * ins];
        let size = ins * columns;
        let same = &weights[order.first_weight..][..size];
        for output in &order.outputs {
            let (first, width) = (output.first_column, output.width);
            let sums = &mut message[output.first_value..][..order.signs * width];
            if order.signs == 1 {
                for (&value, row) in values.iter().zip(same.chunks_exact(columns)) {
                    add_scaled(sums, value, &row[first..first + width]);
                }
                continue;
            }
            let across = &weights[order.first_weight + size..][..size];
            let (plus, minus) = values.split_at(ins);
            let (to_plus, to_minus) = sums.split_at_mut(width);
            let rows = same.chunks_exact(columns).zip(across.chunks_exact(columns));
            for ((&p, &m), (a, b)) in plus.iter().zip(minus).zip(rows) {
                let entries = a[first..first + width].iter().zip(&b[first..first + width]);
                for ((to_plus, to_minus), (&a, &b)) in to_plus.iter_mut().zip(&mut *to_minus).zip(entries) {
                    *to_plus += p * a - m * b;
                    *to_minus += m * a + p * b;
                }
            }
        }
    }
}

/// The gradients of [`message`] where that of the message is `grad`; both targets are overwritten.
pub(super) fn message_backward<F: Real>(
    layout: &Layout,
    turned: &[F],
    weights: &[F],
    grad: &[F],
    to_turned: &mut [F],
    to_weights: &mut [F],
) {
    to_turned.fill(F::default());
    for order in &layout.orders {
        let (ins, columns) = (order.inputs, order.columns);
        let size = ins * columns;
        let values = &turned[order.first_input..][..order.signs * ins];
        let to_values = &mut to_turned[order.first_input..][..order.signs * ins];
        for output in &order.outputs {
            let (first, width) = (output.first_column, output.width);
            let grads = &grad[output.first_value..][..order.signs * width];
            let same = &weights[order.first_weight..][..order.signs * size];
            let to_same = &mut to_weights[order.first_weight..][..order.signs * size];
            if order.signs == 1 {
                let rows = same.chunks_exact(columns).zip(to_same.chunks_exact_mut(columns));
                for ((&value, to_value), (row, to_row)) in values.iter().zip(to_values.iter_mut()).zip(rows) {
                    let entries = row[first..first + width].iter().zip(&mut to_row[first..first + width]);
                    for ((&entry, to_entry), &grad) in entries.zip(grads) {
                        *to_entry = value * grad;
                        *to_value += entry * grad;
                    }
                }
                continue;
            }
            let (same, across) = same.split_at(size);
            let (to_same, to_across) = to_same.split_at_mut(size);
            let (of_plus, of_minus) = grads.split_at(width);
            for input in 0..ins {
                let at = input * columns + first..input * columns + first + width;
                let (p, m) = (values[input], values[ins + input]);
                let (mut to_p, mut to_m) = (F::default(), F::default());
                let entries = same[at.clone()].iter().zip(&across[at.clone()]);
                let targets = to_same[at.clone()].iter_mut().zip(&mut to_across[at]);
                let grads = of_plus.iter().zip(of_minus);
                for (((&a, &b), (to_a, to_b)), (&plus, &minus)) in entries.zip(targets).zip(grads) {
                    *to_a = p * plus + m * minus;
                    *to_b = p * minus - m * plus;
                    to_p += a * plus + b * minus;
                    to_m += a * minus - b * plus;
                }
                to_values[input] += to_p;
                to_values[ins + input] += to_m;
            }
        }
    }
}
