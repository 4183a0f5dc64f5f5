//! The SE(3)-Transformer (arXiv 2006.10503) and SE3ManiNet (arXiv 2403.19460), built of the layers of [`crate::degrees`].

mod block;
mod mani_loss;
mod mani_net;
mod scene_frames;
mod se3_transformer;

pub use block::Nonlinearity;
pub use mani_loss::ManiLossConfig;
pub use mani_net::{ManiNodes, SE3ManiNet, SE3ManiNetConfig};
pub use scene_frames::SceneFrames;
pub(crate) use scene_frames::centre_frames;
pub use se3_transformer::{SE3Transformer, SE3TransformerConfig};
