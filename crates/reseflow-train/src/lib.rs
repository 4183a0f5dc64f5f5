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
mod gradients;
mod pairs;
mod partial;
mod policy;
mod reflow;
mod request;
mod state;
mod trainer;
mod validation;

pub use config::{Keep, ModelConfig, TrainConfig};
pub use device::DeviceKind;
pub use error::TrainError;
pub use etseed::{EtSeedConfig, EtSeedPolicy, EtSeedRequest, train_et_seed};
pub use pairs::{PairConfig, count_pair_windows, make_pairs};
pub use policy::{FlowPolicy, PolicySample};
pub use reflow::{Mixture, MixtureConfig, ReflowConfig};
pub use request::{Resume, TrainRequest};
pub use reseflow_flow::Straightness;
pub use trainer::{TrainObserver, TrainSummary, UpdateMetrics, train};
pub use validation::ValidationMetrics;
