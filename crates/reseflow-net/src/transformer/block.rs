//! One block of the SE(3)-Transformer: attention over neighbours, its result beside the features that went in, a linear map of both,
//! a non-linearity.

use burn::module::Module;
use burn::tensor::Device;
use rand::Rng;
use serde::{Deserialize, Serialize};

use crate::NetError;
use crate::degrees::{
    EdgeFrames, Fiber, FiberFeatures, FiberLayerNorm, FiberLayerNormConfig, FiberLinear, FiberLinearConfig,
    GatedNonlinearity, GatedNonlinearityConfig, NeighborAttention, NeighborAttentionConfig, NormNonlinearity,
    NormNonlinearityConfig,
};

/// What ends a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Nonlinearity {
    /// A function of the norms, as in NVIDIA's implementation.
    Norm,
    /// Layer normalisation, then gates made of scalars.
    Gated,
}

/// One block; see the module's description.
#[derive(Module, Debug)]
pub(crate) struct Block {
    attention: NeighborAttention,
    project: FiberLinear,
    norm: Option<NormNonlinearity>,
    gated: Option<(FiberLayerNorm, GatedNonlinearity)>,
}

impl Block {
    /// Draws the weights of a block that makes `output` of what its attention sees.
    ///
    /// # Errors
    /// As [`NeighborAttentionConfig::validate`].
    pub(crate) fn new<R: Rng + ?Sized>(
        attention: &NeighborAttentionConfig,
        output: &Fiber,
        nonlinearity: Nonlinearity,
        device: &Device,
        rng: &mut R,
    ) -> Result<Block, NetError> {
        let input = attention.output.fiber().concat(&attention.input.fiber());
        let project = FiberLinearConfig { input, output: output.clone(), bias: false };
        let fiber = output.clone();
        Ok(Block {
            attention: attention.init(device, rng)?,
            project: project.init(device, rng),
            norm: (nonlinearity == Nonlinearity::Norm)
                .then(|| NormNonlinearityConfig { fiber: fiber.clone() }.init(device)),
            gated: (nonlinearity == Nonlinearity::Gated).then(|| {
                let norm = FiberLayerNormConfig { fiber: fiber.clone() }.init(device);
                (norm, GatedNonlinearityConfig { fiber }.init(device, rng))
            }),
        })
    }

    /// # Shapes
    /// - `features`: P points, the attention's input
    /// - output: P points, the block's output
    pub(crate) fn forward(&self, features: FiberFeatures, edges: &EdgeFrames) -> FiberFeatures {
        let gathered = self.attention.forward(&features, edges);
        let projected = self.project.forward(&gathered.concat(features));
        match (&self.norm, &self.gated) {
            (Some(norm), _) => norm.forward(projected),
            (None, Some((norm, gated))) => gated.forward(norm.forward(projected)),
            (None, None) => projected,
        }
    }
}
