//! What a policy is made of and how it is trained.

use reseflow_flow::{ObjectiveConfig, Path, PoseError, Prior, TimeSampling};
use reseflow_net::{DriftNetConfig, Parameterisation};
use serde::{Deserialize, Serialize};

use crate::{AugmentConfig, Optimizer, TrainError};

/// Everything needed to rebuild a policy around its weights.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ModelConfig {
    /// The drift network; its `decoder.parameterisation` says whether it predicts clean trajectories or velocities.
    pub network: DriftNetConfig,
    /// The noise.
    pub prior: Prior,
    /// The geodesic from noise to data.
    pub path: Path,
    /// Whether this is a deterministic regressor instead of a flow: every trajectory starts at the gripper's pose instead of at noise,
    /// the flow time is always 0, and the answer is the endpoint that the network says. The prior and flow times play no part then.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub regression: bool,
}

impl ModelConfig {
    /// Checks every value.
    ///
    /// # Errors
    /// What the network or the prior refuses, sizes beyond any use, for which there would be no memory, and a regressor of velocities.
    pub fn validate(&self) -> Result<(), TrainError> {
        self.network.validate()?;
        let (encoder, decoder) = (&self.network.encoder, &self.network.decoder);
        for (key, value, most) in [
            ("encoder.graph.centres", encoder.graph.centres, 16_384),
            ("encoder.graph.point_neighbors", encoder.graph.point_neighbors, 1024),
            ("encoder.graph.centre_neighbors", encoder.graph.centre_neighbors, 1024),
            ("encoder.channels", encoder.channels, 1024),
            ("encoder.layers", encoder.layers, 64),
            ("encoder.nodes", encoder.nodes, 64),
            ("encoder.point_radial.count", encoder.point_radial.count, 1024),
            ("encoder.centre_radial.count", encoder.centre_radial.count, 1024),
            ("decoder.horizon", decoder.horizon, 1024),
            ("decoder.frames", decoder.frames, 64),
            ("decoder.layers", decoder.layers, 64),
            ("decoder.token_scalars", decoder.token_scalars, 1024),
            ("decoder.token_vectors", decoder.token_vectors, 1024),
        ] {
            if value > most {
                let fault = format!("model.network.{key} must be at most {most}, got {value}");
                return Err(TrainError::Config(fault));
            }
        }
        if self.regression && self.network.decoder.parameterisation == Parameterisation::Twist {
            return Err(TrainError::Config(
                "model.regression = true asks for the clean trajectory itself, and \
                 model.network.decoder.parameterisation = \"twist\" predicts velocities only; use \"endpoint\""
                    .to_owned(),
            ));
        }
        Ok(self.prior.validate()?)
    }

    /// Whether noise is drawn about the gripper, not about the cloud.
    pub fn starts_about_the_gripper(&self) -> bool {
        matches!(self.prior, Prior::Gripper(_))
    }

    /// Checks every value of `train`, and that its objective judges what this model predicts.
    ///
    /// # Errors
    /// As [`TrainConfig::validate`], and [`TrainError::Config`] naming what excludes what and why.
    pub fn validate_training(&self, train: &TrainConfig) -> Result<(), TrainError> {
        train.validate()?;
        let twists = self.network.decoder.parameterisation == Parameterisation::Twist;
        if twists && train.objective.error == PoseError::Chordal {
            return Err(TrainError::Config(
                "train.objective.error = \"chordal\" compares clean poses, and \
                 model.network.decoder.parameterisation = \"twist\" predicts none; use train.objective.error = \"twist\""
                    .to_owned(),
            ));
        }
        self.validate_redraw(train.augment.redraw_share)
    }

    /// Checks that nothing stays behind when a line is redrawn.
    fn validate_redraw(&self, share: f64) -> Result<(), TrainError> {
        let decoder = &self.network.decoder;
        let needs = [
            (
                decoder.frames == 1,
                "model.network.decoder.frames = 1: earlier grippers do not follow the new line",
            ),
            (
                !decoder.grasp_memory,
                "model.network.decoder.grasp_memory = false: the grasp does not follow the new line",
            ),
            (
                self.regression || self.starts_about_the_gripper(),
                "model.prior.kind = \"gripper\": the noise of pairs about the cloud does not follow the new line",
            ),
        ];
        match needs.iter().find(|(holds, _)| share > 0.0 && !holds) {
            Some((_, need)) => {
                Err(TrainError::Config(format!("train.augment.redraw_share is {share}, expected {need}")))
            }
            None => Ok(()),
        }
    }
}

/// Which averaged weights become the policy. The others, where there are validations and they differ, lie beside them in the checkpoint as
/// `best.safetensors` or `last.safetensors`; renamed to `model.safetensors` they take their place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Keep {
    /// Those of the validation with the smallest D_geo.
    Best,
    /// Those after the last update.
    #[default]
    Last,
}

/// The optimisation of Flow 1: Muon or AdamW, warm-up and cosine, global clipping, averaged weights.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TrainConfig {
    /// Optimiser updates.
    pub updates: usize,
    /// Windows per batch; an update is one batch, unless `accumulate` says more.
    pub batch_size: usize,
    /// Threads that share a batch; part of the arithmetic, so not guessed from the machine.
    pub shards: usize,
    /// What turns gradients into steps.
    pub optimizer: Optimizer,
    /// Peak learning rate.
    pub learning_rate: f64,
    /// Updates of linear warm-up.
    pub warmup: usize,
    /// Decoupled weight decay.
    pub weight_decay: f64,
    /// Largest global gradient norm.
    pub clip_norm: f64,
    /// Decay of the averaged weights.
    pub ema_decay: f64,
    /// Share of windows that start with the episode; the rest is uniform over all steps.
    pub first_window_share: f64,
    /// How windows are changed each time they are drawn.
    pub augment: AugmentConfig,
    /// Batches whose gradients are summed up for one update.
    pub accumulate: usize,
    /// Updates between validations.
    pub validate_every: usize,
    /// Which averaged weights become the checkpoint.
    pub keep: Keep,
    /// Validations without improvement after which training stops; 0 never stops early.
    pub patience: usize,
    /// Updates between two saved states, from which an interrupted training goes on; 0 saves none.
    pub save_every: usize,
    /// Names the random streams of weights, batches and noise.
    pub seed: u64,
    /// Flow times.
    pub time: TimeSampling,
    /// The objective's weights.
    pub objective: ObjectiveConfig,
}

impl Default for TrainConfig {
    fn default() -> Self {
        Self {
            updates: 3000,
            batch_size: 16,
            shards: 2,
            optimizer: Optimizer::default(),
            learning_rate: 4e-3,
            warmup: DEFAULT_WARMUP,
            weight_decay: 1e-4,
            clip_norm: 1.0,
            ema_decay: 0.995,
            first_window_share: 0.3,
            augment: AugmentConfig::default(),
            accumulate: 1,
            validate_every: 500,
            keep: Keep::Last,
            patience: 0,
            save_every: 500,
            seed: 1,
            time: TimeSampling::default(),
            objective: ObjectiveConfig::default(),
        }
    }
}

/// The largest batch; a larger one is a slip of the keyboard.
const LARGEST_BATCH: usize = 65_536;

/// Updates of linear warm-up where nothing is said. Fewer updates than this are a trial, which may end before its warm-up does.
const DEFAULT_WARMUP: usize = 100;

/// Refuses a warm-up that lasts as long as the training of the table `table`, unless that is a trial.
pub(crate) fn check_warmup(table: &str, warmup: usize, updates: usize) -> Result<(), TrainError> {
    if warmup < updates || warmup <= DEFAULT_WARMUP {
        return Ok(());
    }
    Err(TrainError::Config(format!(
        "{table}.warmup must be less than {table}.updates, got {warmup} and {updates}: the peak learning rate would never be reached"
    )))
}

impl TrainConfig {
    /// Checks every value.
    ///
    /// # Errors
    /// [`TrainError::Config`] naming the first that is out of range.
    pub fn validate(&self) -> Result<(), TrainError> {
        for (key, value) in [
            ("updates", self.updates),
            ("batch_size", self.batch_size),
            ("shards", self.shards),
            ("accumulate", self.accumulate),
            ("validate_every", self.validate_every),
        ] {
            if value == 0 {
                return Err(TrainError::Config(format!("train.{key} must be at least 1, got 0")));
            }
        }
        if self.batch_size > LARGEST_BATCH {
            return Err(TrainError::Config(format!(
                "train.batch_size must be at most {LARGEST_BATCH}, got {}",
                self.batch_size
            )));
        }
        if !self.batch_size.is_multiple_of(self.shards) {
            return Err(TrainError::Config(format!(
                "train.batch_size must be a multiple of train.shards, got {} and {}",
                self.batch_size, self.shards
            )));
        }
        for (key, value, low, high) in [
            ("learning_rate", self.learning_rate, 0.0, 1.0),
            ("weight_decay", self.weight_decay, 0.0, 1.0),
            ("clip_norm", self.clip_norm, f64::MIN_POSITIVE, 1e6),
            ("ema_decay", self.ema_decay, 0.0, 1.0),
            ("first_window_share", self.first_window_share, 0.0, 1.0),
        ] {
            if !(low..=high).contains(&value) {
                return Err(TrainError::Config(format!(
                    "train.{key} must lie in {low} to {high}, got {value}"
                )));
            }
        }
        check_warmup("train", self.warmup, self.updates)?;
        self.augment.validate()?;
        self.time.validate()?;
        Ok(self.objective.validate()?)
    }

    /// The learning rate of `update`, from 0: linear warm-up, then a cosine to zero.
    pub(crate) fn rate(&self, update: usize) -> f64 {
        let warm = ((update + 1) as f64 / self.warmup.max(1) as f64).min(1.0);
        let progress = update as f64 / self.updates as f64;
        self.learning_rate * warm * 0.5 * (1.0 + (std::f64::consts::PI * progress).cos())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_learning_rate_warms_up_peaks_and_falls_to_nothing_as_a_cosine() {
        let config =
            TrainConfig { updates: 1000, warmup: 100, learning_rate: 2e-3, ..TrainConfig::default() };
        let rates: Vec<f64> = (0..1000).map(|update| config.rate(update)).collect();
        assert!((rates[0] - 2e-5).abs() < 1e-9, "a hundredth of the peak at first");
        assert!(rates[..99].windows(2).all(|pair| pair[0] < pair[1]), "rising while warming up");
        assert!(rates[99..].windows(2).all(|pair| pair[0] > pair[1]), "falling from then on");
        // cos²(π/20) of the peak is left when the warm-up ends after a tenth of the updates.
        let peak = 2e-3 * (0.05 * std::f64::consts::PI).cos().powi(2);
        assert!((rates[100] - peak).abs() < 1e-12 && rates[99] < 2e-3);
        assert!((rates[500] - 1e-3).abs() < 1e-15, "half the peak half-way");
        assert!(rates[999] < 1e-5 * 2e-3, "nothing at the end");
        let cold = TrainConfig { warmup: 0, ..config };
        assert_eq!(cold.rate(0), 2e-3, "without warm-up it starts at the peak");
    }
}
