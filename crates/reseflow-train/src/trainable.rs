//! What the training loop asks of that which it trains, and what becomes of it as a policy.

use std::fmt::Debug;

use burn::module::Module;
use burn::tensor::{Device, Tensor};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use reseflow_data::{ObservationHistory, Window};
use reseflow_flow::Solver;
use reseflow_net::DriftNetConfig;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::{Drawn, TrainConfig, TrainError, TrainRequest};

/// The kinds of trained policies, as a checkpoint's `config.toml` names them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PolicyKind {
    /// A rectified flow.
    Flow,
    /// The baseline's diffusion.
    EtSeed,
}

impl PolicyKind {
    /// The name in configurations and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Flow => "flow",
            Self::EtSeed => "et_seed",
        }
    }
}

/// A configuration of something that can be trained and then plans: one for the flows, one for the baseline.
pub trait Trainable: Clone + Debug + PartialEq + Serialize + DeserializeOwned + Send + Sync {
    /// The networks.
    type Net: Module;

    /// What a checkpoint calls it.
    const KIND: PolicyKind;

    /// The sizes of the networks.
    fn network(&self) -> &DriftNetConfig;

    /// Checks every value.
    ///
    /// # Errors
    /// What is out of range, by its key.
    fn check(&self) -> Result<(), TrainError>;

    /// Checks every value of a training, and that it can teach this.
    ///
    /// # Errors
    /// What is out of range, or what excludes what and why, by the keys.
    fn check_training(&self, train: &TrainConfig) -> Result<(), TrainError> {
        train.validate()
    }

    /// Draws the weights.
    ///
    /// # Errors
    /// What is out of range, by its key.
    fn init(&self, device: &Device, rng: &mut ChaCha8Rng) -> Result<Self::Net, TrainError>;

    /// Draws the windows and the noise of one shard and gives the loss of `net`, `[1]`; `drawn` gets the windows.
    ///
    /// # Errors
    /// What the network or the flow refuses.
    fn shard_loss(
        net: &Self::Net,
        request: &TrainRequest<'_, Self>,
        device: &Device,
        rng: &mut ChaCha8Rng,
        drawn: &mut Vec<Window>,
    ) -> Result<Tensor<1>, TrainError>;

    /// How trajectories are drawn in validations, and by a policy until it is told otherwise.
    fn solver(&self) -> Solver;

    /// Draws a trajectory for each history and seed; the noise of history i is stream `first` + i of the seed.
    ///
    /// # Errors
    /// Where an observation cannot be used, or the solver is none for this kind.
    fn draw(
        &self,
        net: &Self::Net,
        histories: &[ObservationHistory],
        seeds: &[u64],
        first: usize,
        solver: &Solver,
        device: &Device,
    ) -> Result<Drawn, TrainError>;
}

/// Stream `stream` of the seed.
pub(crate) fn random_stream(seed: u64, stream: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(stream);
    rng
}
