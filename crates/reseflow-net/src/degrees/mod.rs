//! Layers on features of degrees 0 … l_max, in the basis of [`crate::irreps`].

mod attention;
mod convolution;
pub mod edge_message;
mod edge_product;
mod fiber;
mod frames;
mod gated;
mod layer_norm;
mod linear;
mod norm;
mod paths;
mod pooling;
mod radial_mlp;

pub use attention::{NeighborAttention, NeighborAttentionConfig};
pub use convolution::{TensorProductConvolution, TensorProductConvolutionConfig};
pub use edge_product::{EdgeProduct, KernelPart, KernelWeight};
pub use fiber::{Fiber, FiberFeatures, UniformFiber};
pub use frames::{EdgeFrames, EdgeHarmonics};
pub use gated::{GatedNonlinearity, GatedNonlinearityConfig};
pub use layer_norm::{FiberLayerNorm, FiberLayerNormConfig};
pub use linear::{FiberLinear, FiberLinearConfig};
pub use norm::{NormNonlinearity, NormNonlinearityConfig};
pub use paths::{Path, PathWeight};
pub use pooling::{FiberHeatMap, FiberHeatMapConfig};
pub use radial_mlp::{RadialMlp, RadialMlpConfig};
