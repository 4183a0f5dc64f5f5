//! Network and flow become a policy: the training loop, its data, the averaged weights, checkpoints, and the policy that they make.

mod augment;
mod batch;
mod checkpoint;
mod config;
mod convert;
mod device;
mod ema;
mod error;
mod etseed;
mod field;
mod fingerprint;
mod flow;
mod gradients;
mod pairs;
mod partial;
mod policy;
mod reflow;
mod request;
mod state;
mod trainable;
mod trainer;
mod validation;

pub use checkpoint::{CheckpointConfig, read_kind};
pub use config::{Keep, ModelConfig, TrainConfig};
pub use device::DeviceKind;
pub use error::TrainError;
pub use etseed::{BaselineConfig, EtSeedConfig, EtSeedPolicy};
pub use flow::FlowPolicy;
pub use pairs::{PairConfig, count_pair_windows, make_pairs};
pub use policy::{Drawn, PolicySample, TrainedPolicy};
pub use reflow::{Mixture, MixtureConfig, ReflowConfig};
pub use request::{Resume, TrainRequest};
pub use reseflow_flow::{AdaptiveConfig, DiffusionConfig, Solver, Straightness};
pub use trainable::{PolicyKind, Trainable};
pub use trainer::{TrainObserver, TrainSummary, UpdateMetrics, train};
pub use validation::ValidationMetrics;
