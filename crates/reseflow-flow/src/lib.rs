//! Rectified flow on SE(3) trajectories (the ReSeFlow paper, "SE(3)-equivariant Flow 1 and Flow 2"): where noise comes from, along
//! which path it travels, what the network is asked to say, and how the learned flow is integrated.
//!
//! The flow's state is an action chunk on the host in f64. The network is seen only as a [`DriftField`], which predicts the clean
//! endpoint; the paper's drift is then ξ = log((H^t)⁻¹ Ĥ¹) / (1 − t), a body twist.

mod error;
mod objective;
mod path;
mod prior;
mod solver;
mod time;

pub use error::FlowError;
pub use objective::{EndpointTargets, LossParts, NodeTargets, ObjectiveConfig, endpoint_loss};
pub use path::ScrewPath;
pub use prior::GripperPrior;
pub use solver::{DriftField, Integrated, integrate_euler};
pub use time::TimeSampling;

/// The length scale ℓ that makes metres comparable with radians.
pub const LENGTH_SCALE_M: f64 = 0.15;
