//! An SE(3)-equivariant network from coloured point clouds to gripper trajectories, on burn.
//!
//! The *encoder* runs once per observation: a neighbour graph ([`CloudGraph`]), messages of degrees 0 and 1 from all points to
//! sub-sampled centres and among the centres, and K heat maps that turn the cloud into K *nodes* (after SE3ManiNet, arXiv
//! 2403.19460). The *decoder* runs once per solver step: L trajectory tokens attend to the nodes and to each other, and every
//! node predicts every pose; the consensus of the nodes is the flow's endpoint (or, with [`Parameterisation::Twist`], its velocity).
//!
//! Everything is exactly equivariant under SE(3) and not under reflections: vectors mix only through sums, invariant gates and
//! cross products, and positions enter relative to the cloud's centroid. The exceptions are asked for by name: [`Symmetry`].
//!
//! Beside it stands an SE(3)-Transformer for features of any degree: [`irreps`] has the mathematics, [`degrees`] the layers, and
//! [`SE3Transformer`] and [`SE3ManiNet`] are built of them. So is what the encoder has beside degrees 0 and 1 where
//! [`EncoderConfig::max_degree`] asks for more.
//!
//! # Errors and panics
//! What comes from data or a configuration is refused with a [`NetError`]: clouds, grippers, sizes, lists that do not go together. A
//! tensor of another shape than a layer's weights were drawn for is a mistake of the program, and forward passes panic on it, as burn's
//! modules do.
//!
//! # Devices and gradients
//! What takes longest is computed by operations of this crate's own ([`message`], [`degrees`], [`silu`]) that run on burn's flex and
//! ndarray, with autodiff and without. On any other device the same is composed of burn's operations, which is slower and which no test
//! of this crate runs. Directions of edges, envelope weights and Wigner matrices are constants for the backward pass: gradients arrive
//! at weights and features, not at the coordinates of the points.

mod attention;
mod consensus;
mod context;
mod convolution;
mod decoder;
pub mod degrees;
mod drift;
mod encoder;
mod error;
mod features;
mod graph;
mod heat_map;
mod higher_degrees;
mod host;
pub mod init;
mod interaction;
pub mod irreps;
pub mod message;
mod neighbors;
mod pointer;
mod radial;
mod scene_batch;
mod shape;
pub mod silu;
mod symmetry;
mod tokens;
mod transformer;
mod twist;

pub use attention::{InvariantAttention, InvariantAttentionConfig};
pub use context::{SceneContext, SceneState};
pub use convolution::{Convolution, ConvolutionConfig};
pub use decoder::{Decoder, DecoderConfig, EndpointPrediction, Parameterisation};
pub use drift::{DriftNet, DriftNetConfig};
pub use encoder::{EncodedScenes, Encoder, EncoderConfig};
pub use error::NetError;
pub use features::{Features, cross, dot};
pub use graph::{CloudGraph, GraphConfig};
pub use heat_map::{HeatMap, HeatMapConfig};
pub use interaction::{Interaction, InteractionConfig};
pub use neighbors::{EdgeList, NeighborConfig};
pub use pointer::{PointerAttention, PointerAttentionConfig};
pub use radial::RadialBasis;
pub use scene_batch::{EdgeTensors, SceneBatch};
pub use symmetry::Symmetry;
pub use tokens::{GripperState, TokenBatch};
pub use transformer::{
    ManiLossConfig, ManiNodes, Nonlinearity, SE3ManiNet, SE3ManiNetConfig, SE3Transformer,
    SE3TransformerConfig, SceneFrames,
};
pub use twist::TwistPrediction;
