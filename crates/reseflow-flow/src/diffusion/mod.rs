//! Diffusion on SE(3) trajectories: the baseline (ET-SEED, arXiv 2411.03990), in a frame where it is coherent.
//!
//! What is diffused is X = anchor⁻¹ H, the anchor being the gripper's latest pose, so that neither noise nor targets know how the
//! scene lies in the world. Noise gathers about the identity; the network predicts the left factor Ĥ^{k→0} with Ĥ^{k→0} X^k ≈ X⁰
//! for k > 1, an invariant one, and for the last step k = 1 an equivariant one, which acts on the pose in the world.

mod config;
mod forward;
mod respacing;
mod sampler;
mod schedule;
mod state;

pub use config::{DiffusionConfig, DiffusionFrame};
pub use forward::Diffusion;
pub use respacing::respaced;
pub use sampler::{Denoiser, denoise};
pub use schedule::{CosineSchedule, PosteriorWeights};
pub use state::{Anchor, AnchoredAction, AnchoredChunk, LeftFactor};
