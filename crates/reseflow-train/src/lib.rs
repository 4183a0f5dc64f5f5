//! Network and flow become a policy: the training loop, its data, the averaged weights, checkpoints, and the policy that they make.

mod augment;
mod batch;
mod checkpoint;
mod config;
mod convert;
mod device;
mod ema;
mod error;
mod field;
mod fingerprint;
mod gradients;
mod partial;
mod policy;
mod request;
mod state;
mod trainer;
mod validation;

pub use config::{Keep, ModelConfig, TrainConfig};
pub use device::DeviceKind;
pub use error::TrainError;
pub use policy::{FlowPolicy, PolicySample};
pub use request::{Resume, TrainRequest};
pub use trainer::{TrainObserver, TrainSummary, UpdateMetrics, train};
pub use validation::ValidationMetrics;
