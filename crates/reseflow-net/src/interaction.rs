//! Point-wise mixing of scalars and vectors: invariants of the vectors update the scalars, and the scalars gate the vectors, with a
//! cross product between channels (after PaiNN, arXiv 2102.03150, and GVP, arXiv 2009.01411).

use burn::module::Module;
use burn::nn::Linear;
use burn::tensor::Device;
use rand::Rng;

use crate::init::linear;
use crate::silu::silu;
use crate::{Features, cross, dot};

/// Softens ‖v‖ at zero.
const NORM_EPSILON: f64 = 1e-6;

/// Sizes of an [`Interaction`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InteractionConfig {
    /// Scalar channels D.
    pub scalars: usize,
    /// Vector channels V.
    pub vectors: usize,
    /// Hidden width.
    pub hidden: usize,
}

/// One interaction, residual and soft-normalised.
#[derive(Module, Debug)]
pub struct Interaction {
    mix: Linear,
    hidden: Linear,
    output: Linear,
    #[module(skip)]
    config: [usize; 2],
}

impl InteractionConfig {
    /// Draws the weights.
    pub fn init<R: Rng + ?Sized>(&self, device: &Device, rng: &mut R) -> Interaction {
        let Self { scalars, vectors, hidden } = *self;
        Interaction {
            mix: linear([vectors, 3 * vectors], 1.0, false, device, rng),
            hidden: linear([scalars + 2 * vectors, hidden], 1.0, true, device, rng),
            output: linear([hidden, scalars + 2 * vectors], 0.5, true, device, rng),
            config: [scalars, vectors],
        }
    }
}

impl Interaction {
    /// # Shapes
    /// - input and output: scalars `[P, D]`, vectors `[3, P, V]`
    ///
    /// # Panics
    /// Where a tensor has another shape.
    pub fn forward(&self, input: Features) -> Features {
        let [scalar_width, vector_width] = self.config;
        let [_, points, _] = input.vectors.dims();
        let mixed = self.mix.forward(input.vectors.clone());
        let part = |index: usize| mixed.clone().narrow(2, index * vector_width, vector_width);
        let (a, b, c) = (part(0), part(1), part(2));
        let norm = dot(b.clone(), b.clone()).add_scalar(NORM_EPSILON).sqrt();
        let inner = dot(a.clone(), b);
        let invariants = burn::tensor::Tensor::cat(vec![input.scalars.clone(), norm, inner], 1);
        let update = self.output.forward(silu(self.hidden.forward(invariants)));
        let gate = |index: usize| {
            update.clone().narrow(1, scalar_width + index * vector_width, vector_width).reshape([
                1,
                points,
                vector_width,
            ])
        };
        Features {
            scalars: input.scalars + update.clone().narrow(1, 0, scalar_width),
            vectors: input.vectors + gate(0) * a.clone() + gate(1) * cross(a, c),
        }
        .soft_normalize()
    }
}
