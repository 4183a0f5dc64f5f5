//! Attention whose weights see only scalars, so that they are invariant, and whose values are scalars and vectors alike.

use burn::module::Module;
use burn::nn::Linear;
use burn::tensor::Device;
use burn::tensor::activation::softmax;
use rand::Rng;

use crate::Features;
use crate::init::linear;

/// Sizes of an [`InvariantAttention`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InvariantAttentionConfig {
    /// Scalar and vector channels of the queries, and of the output.
    pub query: [usize; 2],
    /// Scalar and vector channels of what is attended to.
    pub memory: [usize; 2],
    /// Width of queries and keys.
    pub key: usize,
}

/// Single-head attention from Q tokens to M memory rows of the same scene.
#[derive(Module, Debug)]
pub struct InvariantAttention {
    query: Linear,
    key: Linear,
    scalar_value: Linear,
    vector_value: Linear,
}

impl InvariantAttentionConfig {
    /// Draws the weights.
    pub fn init<R: Rng + ?Sized>(&self, device: &Device, rng: &mut R) -> InvariantAttention {
        InvariantAttention {
            query: linear([self.query[0], self.key], 1.0, false, device, rng),
            key: linear([self.memory[0], self.key], 1.0, false, device, rng),
            scalar_value: linear([self.memory[0], self.query[0]], 0.5, false, device, rng),
            vector_value: linear([self.memory[1], self.query[1]], 0.5, false, device, rng),
        }
    }
}

impl InvariantAttention {
    /// What the tokens of each of `scenes` scenes gather from that scene's memory.
    ///
    /// # Shapes
    /// - `tokens`: scalars `[B·Q, D]`
    /// - `memory`: scalars `[B·M, D']`, vectors `[3, B·M, V']`
    /// - output: scalars `[B·Q, D]`, vectors `[3, B·Q, V]`
    ///
    /// # Panics
    /// Where a tensor has another shape, or no whole number of rows for each scene.
    pub fn forward(&self, scenes: usize, tokens: &Features, memory: &Features) -> Features {
        let [token_rows, _] = tokens.scalars.dims();
        let [memory_rows, _] = memory.scalars.dims();
        let (queries, keys) = (token_rows / scenes, memory_rows / scenes);
        let query = self.query.forward(tokens.scalars.clone());
        let [_, width] = query.dims();
        let query = query.reshape([scenes, queries, width]);
        let key = self.key.forward(memory.scalars.clone()).reshape([scenes, keys, width]);
        let logits = query.matmul(key.swap_dims(1, 2)).mul_scalar((width as f64).sqrt().recip());
        let weights = softmax(logits, 2);
        let scalars = self.scalar_value.forward(memory.scalars.clone());
        let vectors = self.vector_value.forward(memory.vectors.clone());
        let ([_, scalar_width], [_, _, vector_width]) = (scalars.dims(), vectors.dims());
        Features {
            scalars: weights
                .clone()
                .matmul(scalars.reshape([scenes, keys, scalar_width]))
                .reshape([token_rows, scalar_width]),
            vectors: weights
                .reshape([1, scenes, queries, keys])
                .matmul(vectors.reshape([3, scenes, keys, vector_width]))
                .reshape([3, token_rows, vector_width]),
        }
    }
}
