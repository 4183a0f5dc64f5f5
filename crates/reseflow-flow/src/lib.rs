//! Rectified flow on SE(3) trajectories (the ReSeFlow paper, "SE(3)-equivariant Flow 1 and Flow 2"): where noise comes from, along
//! which path it travels, what the network is asked to say, and how the learned flow is integrated.
//!
//! The flow's state is an action chunk on the host in f64. The network is seen only as a [`DriftField`], which predicts the clean
//! endpoint, the paper's drift then being ξ = log((H^t)⁻¹ Ĥ¹) / (1 − t), or as a [`TwistField`], which predicts ξ itself; a body
//! twist either way.

mod coupling;
mod diffusion;
mod error;
mod field;
mod objective;
mod path;
mod prior;
mod solver;
mod straightness;
mod time;
mod velocity;

pub use coupling::{Coupling, nearest_image};
pub use diffusion::{
    Anchor, AnchoredAction, AnchoredChunk, CosineSchedule, Denoiser, Diffusion, DiffusionConfig,
    DiffusionFrame, LeftFactor, PosteriorWeights, denoise, respaced,
};
pub use error::FlowError;
pub use field::{DriftField, Flow, TwistField};
pub use objective::{
    EndpointTargets, LossContext, LossParts, NodeTargets, ObjectiveConfig, PoseError, TwistTargets,
    endpoint_loss, twist_loss,
};
pub use path::Path;
pub use prior::{GripperPrior, HaarPrior, Prior, PriorFrame};
pub use solver::{AdaptiveConfig, Integrated, Solver, integrate, trace};
pub use straightness::{Straightness, straightness};
pub use time::{TimeSampling, TimeShape};
pub use velocity::{ActionVelocity, ChunkVelocity};

/// The length scale ℓ that makes metres comparable with radians.
pub const LENGTH_SCALE_M: f64 = 0.15;
