//! The baseline (ET-SEED, arXiv 2411.03990) on the backbone of the flows: diffusion with invariant kernels and one equivariant kernel.
//!
//! Two networks of the same sizes and separate weights. The *invariant* one answers at all noise levels above the first, with degree 0
//! alone and in the gripper's frame; the *equivariant* one makes the last step, with vectors in the world. The mathematics is
//! [`reseflow_flow::Diffusion`]'s.

mod batch;
mod config;
mod denoiser;
mod input;
mod net;
mod objective;
mod policy;
mod section;
mod trunk;

#[cfg(test)]
mod laws;

pub use config::EtSeedConfig;
pub use policy::EtSeedPolicy;
pub use section::BaselineConfig;
