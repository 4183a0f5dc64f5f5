//! Plain values that every other crate passes around (point clouds, observations, actions, episodes), the [`Task`],
//! [`Scene`] and [`Policy`] traits, the loop that lets a policy act in a scene, data-set files and MCAP logs.
//!
//! Conventions: metre, radian, second; z up; transforms are `target_from_source`; time stamps are `i64` nanoseconds.

mod action;
mod atomic_file;
mod cloud;
mod dataset;
mod episode;
mod episode_key;
mod error;
mod mcap_log;
mod npz;
mod observation;
mod pairs;
mod policy;
mod predictions;
mod rollout;
mod scene;
mod task;
mod window;

pub use action::{Action, ActionChunk, gripper_half_turn};
pub use atomic_file::write_atomically;
pub use cloud::PointCloud;
pub use dataset::{DATASET_VERSION, Dataset, DatasetFile, DatasetMeta, DatasetSummary, HashCheck, PoseRange};
pub use episode::{Disturbance, Episode};
pub use episode_key::{EpisodeKey, Split};
pub use error::DataError;
pub use mcap_log::{McapLog, McapSummary, TopicSummary, TrainingNotes, write_training_log};
pub use observation::{Observation, ObservationHistory};
pub use pairs::{FlowPair, PairMeta, PairSet, WindowPairs};
pub use policy::{Plan, Policy, PolicyError};
pub use predictions::Predictions;
pub use rollout::{EpisodeObserver, IgnoreEvents, RolloutConfig, RolloutRecord, rollout};
pub use scene::{Contact, Halt, Outcome, Scene, SceneBody, Shape, Tick};
pub use task::{Task, TaskError, TaskSpec};
pub use window::{PADDING_WEIGHT, Target, Window};
