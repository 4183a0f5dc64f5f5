//! Network and flow become a policy: the training loop, its data, the averaged weights, checkpoints, and the policy that they make.

mod batch;
mod checkpoint;
mod config;
mod convert;
mod device;
mod ema;
mod error;
mod field;
mod gradients;
mod policy;
mod request;
mod trainer;

pub use config::{ModelConfig, TrainConfig};
pub use device::DeviceKind;
pub use error::TrainError;
pub use policy::{FlowPolicy, PolicySample};
pub use request::TrainRequest;
pub use trainer::{TrainObserver, TrainSummary, UpdateMetrics, ValidationMetrics, train};
