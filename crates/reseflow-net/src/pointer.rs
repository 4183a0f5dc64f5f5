//! Attention that points: every head of a token points at a place, and what is near that place counts most.
//!
//! A token that has to follow a drawn line finds the part of it that it is about. Weights are invariant: products of scalars, less a
//! learned sharpness times the squared distance from the pointer's tip.

use burn::module::{Module, Param};
use burn::nn::Linear;
use burn::tensor::activation::softmax;
use burn::tensor::{Device, Tensor};
use rand::Rng;

use crate::Features;
use crate::init::linear;

/// Logarithm of the sharpness at first, over the offset scale squared: a pointer feels about 4 cm wide.
const FIRST_SHARPNESS: f64 = 1.0;

/// Sizes of a [`PointerAttention`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointerAttentionConfig {
    /// Scalar and vector channels of the queries, and of the output; multiples of the heads.
    pub query: [usize; 2],
    /// Scalar and vector channels of what is attended to; the last vector is its position over the offset scale.
    pub memory: [usize; 2],
    /// Heads H.
    pub heads: usize,
    /// Width of a head's queries and keys.
    pub key: usize,
}

/// Attention of H heads, each with a pointer, from Q tokens to M rows of memory of the same scene.
#[derive(Module, Debug)]
pub struct PointerAttention {
    pointer: Linear,
    log_sharpness: Param<Tensor<1>>,
    query: Linear,
    key: Linear,
    scalar_value: Linear,
    vector_value: Linear,
    /// From the pointer's tip to the mean place of what was found there.
    correction: Linear,
    #[module(skip)]
    heads: usize,
}

impl PointerAttentionConfig {
    /// Draws the weights.
    pub fn init<R: Rng + ?Sized>(&self, device: &Device, rng: &mut R) -> PointerAttention {
        let Self { query: [scalars, vectors], memory, heads, key } = *self;
        PointerAttention {
            pointer: linear([vectors, heads], 1.0, false, device, rng),
            log_sharpness: Param::from_tensor(Tensor::full([heads], FIRST_SHARPNESS, device)),
            query: linear([scalars, heads * key], 1.0, false, device, rng),
            key: linear([memory[0], heads * key], 1.0, false, device, rng),
            scalar_value: linear([memory[0], scalars], 0.5, false, device, rng),
            vector_value: linear([memory[1], vectors], 0.5, false, device, rng),
            correction: linear([heads, vectors], 0.5, false, device, rng),
            heads,
        }
    }
}

impl PointerAttention {
    /// What the tokens of each of `scenes` scenes gather from that scene's memory.
    ///
    /// # Shapes
    /// - `tokens`: scalars `[B·Q, D]`, vectors `[3, B·Q, V]`
    /// - `memory`: scalars `[B·M, D']`, vectors `[3, B·M, V']`
    /// - output: scalars `[B·Q, D]`, vectors `[3, B·Q, V]`
    ///
    /// # Panics
    /// Where a tensor has another shape, or no whole number of rows for each scene.
    pub fn forward(&self, scenes: usize, tokens: &Features, memory: &Features) -> Features {
        let heads = self.heads;
        let ([token_rows, scalars], [_, _, vectors]) = (tokens.scalars.dims(), tokens.vectors.dims());
        let ([memory_rows, _], [_, _, width]) = (memory.scalars.dims(), memory.vectors.dims());
        let (queries, keys) = (token_rows / scenes, memory_rows / scenes);

        let tips = self.pointer.forward(tokens.vectors.clone());
        let places = memory.vectors.clone().narrow(2, width - 1, 1);
        let weights = self.weights(scenes, tokens, memory, tips.clone(), places.clone());

        let found = self.scalar_value.forward(memory.scalars.clone());
        let found = found.reshape([scenes, keys, heads, scalars / heads]).swap_dims(1, 2);
        let of_scalars = weights.clone().matmul(found).swap_dims(1, 2).reshape([token_rows, scalars]);

        // The three components side by side, so that each head is one matrix product: [B, H, M, 3·V/H].
        let share = vectors / heads;
        let found = self.vector_value.forward(memory.vectors.clone());
        let found = found.reshape([3, scenes, keys, heads, share]).permute([1, 3, 2, 0, 4]);
        let gathered = weights.clone().matmul(found.reshape([scenes, heads, keys, 3 * share]));
        let gathered = gathered.reshape([scenes, heads, queries, 3, share]).permute([3, 0, 2, 1, 4]);

        let places = places.reshape([3, scenes, 1, keys]).permute([1, 2, 3, 0]).repeat_dim(1, heads);
        let mean_places = weights.matmul(places).permute([3, 0, 2, 1]).reshape([3, token_rows, heads]);
        let of_vectors =
            gathered.reshape([3, token_rows, vectors]) + self.correction.forward(mean_places - tips);
        Features { scalars: of_scalars, vectors: of_vectors }
    }

    /// Weights `[B, H, Q, M]`, each row a distribution; `tips` are `[3, B·Q, H]`, `places` `[3, B·M, 1]`.
    fn weights(
        &self,
        scenes: usize,
        tokens: &Features,
        memory: &Features,
        tips: Tensor<3>,
        places: Tensor<3>,
    ) -> Tensor<4> {
        let heads = self.heads;
        let ([_, token_rows, _], [_, memory_rows, _]) = (tips.dims(), places.dims());
        let (queries, keys) = (token_rows / scenes, memory_rows / scenes);
        let tips = tips.reshape([3, scenes, queries, heads, 1]).swap_dims(2, 3);
        // By differences: |a|² + |b|² − 2ab leaves the rounding of its terms, which are large in a scene metres wide.
        let apart = tips - places.reshape([3, scenes, 1, 1, keys]);
        let squared = apart.square().sum_dim(0).reshape([scenes, heads, queries, keys]);

        let query = self.query.forward(tokens.scalars.clone());
        let [_, width] = query.dims();
        let key_width = width / heads;
        let query = query.reshape([scenes, queries, heads, key_width]).swap_dims(1, 2);
        let key = self.key.forward(memory.scalars.clone());
        let key = key.reshape([scenes, keys, heads, key_width]).permute([0, 2, 3, 1]);
        let alike = query.matmul(key).mul_scalar((key_width as f64).sqrt().recip());
        let sharpness = self.log_sharpness.val().exp().reshape([1, heads, 1, 1]);
        softmax(alike - squared * sharpness, 3)
    }
}
