//! The SE(3)-Transformer: blocks of attention over neighbours, and a last convolution with self-interaction that makes the outputs.

use burn::module::Module;
use burn::tensor::Device;
use rand::Rng;
use serde::{Deserialize, Serialize};

use super::Nonlinearity;
use super::block::Block;
use crate::NetError;
use crate::degrees::{
    EdgeFrames, FiberFeatures, FiberLinear, FiberLinearConfig, NeighborAttentionConfig, RadialMlpConfig,
    TensorProductConvolution, TensorProductConvolutionConfig, UniformFiber,
};

/// Sizes of an [`SE3Transformer`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SE3TransformerConfig {
    /// Features of the points; [`FiberLinear`] makes others uniform.
    pub input: UniformFiber,
    /// The highest degree between the blocks.
    pub max_degree: usize,
    /// Channels of each degree between the blocks.
    pub channels: usize,
    /// Features that come out, of degrees that are there between the blocks.
    pub output: UniformFiber,
    /// Blocks.
    pub layers: usize,
    /// Heads of each attention.
    pub heads: usize,
    /// Keys and values have the block's channels over this.
    pub channels_div: usize,
    /// What ends a block.
    pub nonlinearity: Nonlinearity,
    /// Functions of the radial basis, as the edges have them.
    pub radial: usize,
    /// Hidden width of the radial networks.
    pub radial_hidden: usize,
}

impl Default for SE3TransformerConfig {
    /// Degrees 0–3 with 8 channels, four blocks.
    fn default() -> Self {
        Self {
            input: UniformFiber { max_degree: 0, channels: 3 },
            max_degree: 3,
            channels: 8,
            output: UniformFiber { max_degree: 1, channels: 8 },
            layers: 4,
            heads: 1,
            channels_div: 2,
            nonlinearity: Nonlinearity::Norm,
            radial: 8,
            radial_hidden: 32,
        }
    }
}

impl SE3TransformerConfig {
    /// ET-SEED's network of positions (arXiv 2411.03990): degrees 0–2, in 13 scalars a point (colour, nine numbers of a pose, the
    /// diffusion step), out four scalars (the heat map and an offset).
    pub fn et_seed_position() -> Self {
        Self {
            input: UniformFiber { max_degree: 0, channels: 13 },
            max_degree: 2,
            output: UniformFiber { max_degree: 0, channels: 4 },
            ..Self::default()
        }
    }

    /// ET-SEED's network of orientations: degrees 0–3, out two vectors, and two scalars that come with them here.
    pub fn et_seed_orientation() -> Self {
        Self {
            input: UniformFiber { max_degree: 0, channels: 13 },
            output: UniformFiber { max_degree: 1, channels: 2 },
            ..Self::default()
        }
    }

    /// Checks that every size makes sense.
    ///
    /// # Errors
    /// [`NetError::Config`] naming the first key that does not.
    pub fn validate(&self) -> Result<(), NetError> {
        for (key, value) in [
            ("channels", self.channels),
            ("input.channels", self.input.channels),
            ("output.channels", self.output.channels),
            ("channels_div", self.channels_div),
            ("radial", self.radial),
            ("radial_hidden", self.radial_hidden),
        ] {
            if value == 0 {
                return Err(NetError::Config(format!("transformer.{key} must be at least 1, got 0")));
            }
        }
        let reached = if self.layers == 0 { self.input.max_degree } else { self.max_degree };
        if self.output.max_degree > reached {
            return Err(NetError::Config(format!(
                "transformer.output.max_degree must be at most {reached}, got {}",
                self.output.max_degree
            )));
        }
        self.attention(self.hidden()).validate()
    }

    fn hidden(&self) -> UniformFiber {
        UniformFiber { max_degree: self.max_degree, channels: self.channels }
    }

    fn radial_mlp(&self) -> RadialMlpConfig {
        RadialMlpConfig { radial: self.radial, hidden: self.radial_hidden }
    }

    fn attention(&self, input: UniformFiber) -> NeighborAttentionConfig {
        let output =
            UniformFiber { max_degree: self.max_degree, channels: self.channels / self.channels_div.max(1) };
        NeighborAttentionConfig { input, output, heads: self.heads, radial: self.radial_mlp() }
    }

    /// Draws the weights.
    ///
    /// # Errors
    /// As [`Self::validate`].
    pub fn init<R: Rng + ?Sized>(&self, device: &Device, rng: &mut R) -> Result<SE3Transformer, NetError> {
        self.validate()?;
        let hidden = self.hidden();
        let mut input = self.input;
        let mut blocks = Vec::with_capacity(self.layers);
        for _ in 0..self.layers {
            let attention = self.attention(input);
            blocks.push(Block::new(&attention, &hidden.fiber(), self.nonlinearity, device, rng)?);
            input = hidden;
        }
        let convolution =
            TensorProductConvolutionConfig { input, output: self.output, radial: self.radial_mlp() };
        let own = FiberLinearConfig { input: input.fiber(), output: self.output.fiber(), bias: false };
        Ok(SE3Transformer {
            blocks,
            convolution: convolution.init(device, rng),
            self_interaction: own.init(device, rng),
        })
    }
}

/// From features on points to features on the same points; see the module's description.
#[derive(Module, Debug)]
pub struct SE3Transformer {
    blocks: Vec<Block>,
    convolution: TensorProductConvolution,
    self_interaction: FiberLinear,
}

impl SE3Transformer {
    /// # Shapes
    /// - `features`: P points, the input's fiber
    /// - `edges`: among these points, with matrices up to the highest degree
    /// - output: P points, the output's fiber
    ///
    /// # Panics
    /// Where the features are of another fiber, there are not as many points as receivers, the edges have another radial basis, or their
    /// frames are of lower degrees than the network.
    pub fn forward(&self, mut features: FiberFeatures, edges: &EdgeFrames) -> FiberFeatures {
        for block in &self.blocks {
            features = block.forward(features, edges);
        }
        self.convolution.forward(&features, edges) + self.self_interaction.forward(&features)
    }
}
