//! Flow 2: what of a batch comes from Flow 1's pairs and what from demonstrations, and with which noise.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use reseflow_data::{ActionChunk, Dataset, Window, WindowPairs};
use reseflow_flow::{Coupling, ObjectiveConfig, TimeSampling, nearest_image};
use reseflow_net::DecoderConfig;
use serde::{Deserialize, Serialize};

use crate::config::check_warmup;
use crate::half_turn::{close_along_motion, closes_along_motion};
use crate::{PairConfig, TrainConfig, TrainError};

/// How Flow 2 is made of Flow 1. What is not said here is as in the training of Flow 1.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ReflowConfig {
    /// How often: 1 makes Flow 2, 2 makes Flow 3 out of it, and so on.
    pub rounds: usize,
    /// Optimiser updates of each round.
    pub updates: usize,
    /// Peak learning rate.
    pub learning_rate: f64,
    /// Updates of linear warm-up.
    pub warmup: usize,
    /// Flow times.
    pub time: TimeSampling,
    /// What is minimised; without this table what Flow 1 minimised. A flow between two modes has to be learned as a mean, by squared
    /// errors; its pairs have one answer each, so a pseudo-Huber loss costs nothing there and keeps the modes apart.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub objective: Option<ObjectiveConfig>,
    /// The pairs.
    pub pairs: PairConfig,
    /// What the batches are mixed of.
    pub mixture: MixtureConfig,
}

/// What batches are mixed of.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MixtureConfig {
    /// ρ, the share of pairs; the rest are demonstrations.
    pub pair_share: f64,
    /// Which noise a demonstration is joined with.
    pub coupling: Coupling,
}

impl Default for ReflowConfig {
    fn default() -> Self {
        Self {
            rounds: 1,
            updates: 2000,
            learning_rate: 1e-3,
            warmup: 100,
            time: TimeSampling::default(),
            objective: None,
            pairs: PairConfig::default(),
            mixture: MixtureConfig::default(),
        }
    }
}

impl Default for MixtureConfig {
    fn default() -> Self {
        Self { pair_share: 0.5, coupling: Coupling::default() }
    }
}

impl ReflowConfig {
    /// Checks every value; `base` is the training of Flow 1.
    ///
    /// # Errors
    /// [`TrainError::Config`] and [`TrainError::Flow`], naming what is out of range.
    pub fn validate(&self, base: &TrainConfig) -> Result<(), TrainError> {
        for (key, value) in [("rounds", self.rounds), ("updates", self.updates)] {
            if value == 0 {
                return Err(TrainError::Config(format!("reflow.{key} must be at least 1, got 0")));
            }
        }
        if !(0.0..=1.0).contains(&self.learning_rate) {
            let fault = format!("reflow.learning_rate must lie in 0 to 1, got {}", self.learning_rate);
            return Err(TrainError::Config(fault));
        }
        self.mixture.validate()?;
        self.pairs.validate()?;
        check_warmup("reflow", self.warmup, self.updates)?;
        self.training(base, 1).validate()
    }

    /// The optimisation of round `round`, from 1: that of Flow 1 but for what this configuration says, on random streams of its own.
    pub fn training(&self, base: &TrainConfig, round: usize) -> TrainConfig {
        TrainConfig {
            updates: self.updates,
            learning_rate: self.learning_rate,
            warmup: self.warmup,
            time: self.time,
            objective: self.objective.unwrap_or(base.objective),
            seed: base.seed.wrapping_add(round as u64),
            ..base.clone()
        }
    }

    /// The pairs of round `round`, from 1, on random streams of its own.
    pub fn pairs_of(&self, round: usize) -> PairConfig {
        PairConfig { seed: self.pairs.seed.wrapping_add(round as u64 - 1), ..self.pairs.clone() }
    }
}

impl MixtureConfig {
    /// Checks the share.
    ///
    /// # Errors
    /// [`TrainError::Config`] where it is none.
    pub fn validate(&self) -> Result<(), TrainError> {
        if (0.0..=1.0).contains(&self.pair_share) {
            return Ok(());
        }
        let fault = format!("reflow.mixture.pair_share must lie in 0 to 1, got {}", self.pair_share);
        Err(TrainError::Config(fault))
    }
}

/// Pairs and demonstrations of the same windows, to draw batches from.
#[derive(Debug)]
pub struct Mixture<'a> {
    config: MixtureConfig,
    pairs: &'a [WindowPairs],
    /// For every episode that has any, its places in `pairs`, in the order of the steps.
    episodes: Vec<Vec<usize>>,
    horizon: usize,
}

/// One example whose noise is given: a window, the noise, and where it is to go.
#[derive(Debug)]
pub(crate) struct Example {
    pub(crate) window: Window,
    pub(crate) noise: ActionChunk,
    pub(crate) clean: ActionChunk,
}

impl<'a> Mixture<'a> {
    /// Pairs of windows of `demonstrations`, whose targets are `horizon` actions long.
    ///
    /// # Errors
    /// [`TrainError::Pairs`] where pairs do not fit the demonstrations, [`TrainError::Config`].
    pub fn new(
        config: MixtureConfig,
        pairs: &'a [WindowPairs],
        demonstrations: &Dataset,
        horizon: usize,
    ) -> Result<Self, TrainError> {
        config.validate()?;
        let mut episodes = vec![Vec::new(); demonstrations.episodes.len()];
        for (index, WindowPairs { window, pairs }) in pairs.iter().enumerate() {
            let Window { episode, step } = *window;
            let recorded = demonstrations.episodes.get(episode);
            let steps = recorded.map_or(0..0, |recorded| recorded.first_step()..recorded.actions.len());
            if !steps.contains(&step) {
                return Err(TrainError::Pairs(format!(
                    "window {index} is step {step} of episode {episode}, which the demonstrations do not have, or do not begin a window at"
                )));
            }
            let lengths = pairs.iter().flat_map(|pair| [pair.noise.len(), pair.image.len()]);
            if let Some(got) = lengths.into_iter().find(|length| *length != horizon) {
                return Err(TrainError::Pairs(format!(
                    "window {index} has trajectories of {got} actions, expected the network's horizon of {horizon}"
                )));
            }
            if pairs.is_empty() {
                return Err(TrainError::Pairs(format!("window {index} has no pair, expected at least one")));
            }
            episodes[episode].push(index);
        }
        episodes.retain(|places| !places.is_empty());
        episodes.iter_mut().for_each(|places| places.sort_by_key(|&place| pairs[place].window.step));
        if episodes.is_empty() {
            return Err(TrainError::Pairs(
                "there is none, expected at least one window with pairs".to_owned(),
            ));
        }
        Ok(Self { config, pairs, episodes, horizon })
    }

    /// Everything that the draws depend on beside the demonstrations.
    pub(crate) fn parts(&self) -> (&MixtureConfig, &[WindowPairs]) {
        (&self.config, self.pairs)
    }

    /// Draws one example for a network of these settings; an episode's first window comes up with the share `first_share`, else any of
    /// its windows with pairs. None stands for a demonstration of any window with noise of its own, as Flow 1 had it.
    pub(crate) fn draw(
        &self,
        demonstrations: &Dataset,
        decoder: &DecoderConfig,
        first_share: f64,
        rng: &mut ChaCha8Rng,
    ) -> Result<Option<Example>, TrainError> {
        let places = &self.episodes[rng.random_range(0..self.episodes.len())];
        let first: f64 = rng.random();
        let any = rng.random_range(0..places.len());
        let WindowPairs { window, pairs } = &self.pairs[places[if first < first_share { 0 } else { any }]];
        let kind: f64 = rng.random();
        if kind < self.config.pair_share {
            let pair = &pairs[rng.random_range(0..pairs.len())];
            let (noise, clean) = (pair.noise.clone(), pair.image.clone());
            return Ok(Some(Example { window: *window, noise, clean }));
        }
        if self.config.coupling == Coupling::Independent {
            return Ok(None);
        }
        let targets: Vec<_> = window.targets(&demonstrations.episodes, self.horizon).collect();
        let weights: Vec<f64> = targets.iter().map(|target| target.weight()).collect();
        let mut clean = ActionChunk(targets.iter().map(|target| *target.action).collect());
        if closes_along_motion(decoder) {
            // As the images do; half a turn away, the nearest image would be nearly the farthest.
            close_along_motion(&mut clean);
        }
        let noise = pairs[nearest_image(pairs, &clean, &weights)?].noise.clone();
        Ok(Some(Example { window: *window, noise, clean }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::rand_core::SeedableRng;
    use reseflow_data::{Action, Episode, FlowPair};
    use reseflow_lie::{SE3, SO3, Vector3};
    use reseflow_net::Parameterisation;
    use std::f64::consts::PI;

    const HORIZON: usize = 3;
    const DRAWS: usize = 4000;

    fn chunk(x_m: f64) -> ActionChunk {
        let world_from_gripper = SE3::new(SO3::identity(), Vector3::new(x_m, 0.0, 0.0));
        ActionChunk(vec![Action { world_from_gripper, opening: 0.0 }; HORIZON])
    }

    fn x_m(chunk: &ActionChunk) -> f64 {
        chunk.0[0].world_from_gripper.translation.x
    }

    /// Episode e demonstrates x = e; there are pairs from windows 0 and 2, whose noise lies at x = 100 … 103 and whose images lie at
    /// e − 0.3, e − 0.1, e + 0.2, e + 0.4.
    fn world() -> (Dataset, Vec<WindowPairs>) {
        let episode = |e: usize| Episode {
            observations: Vec::new(),
            actions: [chunk(e as f64).0, chunk(e as f64).0].concat(),
            alternative: None,
            disturbance: None,
        };
        let of = |episode: usize, step: usize| {
            let images = [-0.3, -0.1, 0.2, 0.4].map(|off| chunk(episode as f64 + off));
            let pairs = (0..).zip(images);
            WindowPairs {
                window: Window { episode, step },
                pairs: pairs
                    .map(|(m, image)| FlowPair { noise: chunk(100.0 + f64::from(m)), image })
                    .collect(),
            }
        };
        let dataset = Dataset { episodes: (0..3).map(episode).collect(), meta: None };
        (dataset, (0..3).flat_map(|e| [of(e, 0), of(e, 2)]).collect())
    }

    fn draws(config: MixtureConfig, first_share: f64) -> Vec<Option<Example>> {
        let (dataset, pairs) = world();
        let mixture = Mixture::new(config, &pairs, &dataset, HORIZON).unwrap();
        let (mut rng, decoder) = (ChaCha8Rng::seed_from_u64(8), DecoderConfig::default());
        (0..DRAWS).map(|_| mixture.draw(&dataset, &decoder, first_share, &mut rng).unwrap()).collect()
    }

    /// Whether the example's endpoint is the demonstration, and not an image of Flow 1's.
    fn is_demonstration(example: &Example) -> bool {
        (x_m(&example.clean) - example.window.episode as f64).abs() < 1e-9
    }

    #[test]
    fn the_share_of_pairs_is_rho() {
        for pair_share in [0.0, 0.25, 0.5, 1.0] {
            let (expected, count) = (pair_share * DRAWS as f64, DRAWS as f64);
            let deviation = (count * pair_share * (1.0 - pair_share)).sqrt();
            for coupling in [Coupling::Anchored, Coupling::Independent] {
                let drawn = draws(MixtureConfig { pair_share, coupling }, 0.3);
                let is_pair = |example: &&Example| !is_demonstration(example);
                let pairs = drawn.iter().flatten().filter(is_pair).count() as f64;
                assert!(
                    (pairs - expected).abs() <= 4.0 * deviation,
                    "{pairs} of {count}, expected {expected}"
                );
            }
        }
    }

    #[test]
    fn anchored_demonstrations_have_the_nearest_images_noise_and_independent_ones_none_of_a_pairs() {
        let drawn = |coupling: Coupling| draws(MixtureConfig { pair_share: 0.0, coupling }, 0.3);
        let anchored: Vec<Example> = drawn(Coupling::Anchored).into_iter().flatten().collect();
        assert_eq!(anchored.len(), DRAWS);
        for example in &anchored {
            assert!(is_demonstration(example));
            assert_eq!(x_m(&example.noise), 101.0, "the one 0.1 m off is nearest");
        }
        assert!(drawn(Coupling::Independent).iter().all(Option::is_none));
    }

    /// A path along +y whose fingers close across it by the angle: less than a quarter turn is along it.
    fn path(yaw_rad: f64) -> ActionChunk {
        let rotation = SO3::exp(&(Vector3::z() * yaw_rad));
        let action = |step: usize| Action {
            world_from_gripper: SE3::new(rotation, Vector3::y() * (0.05 * step as f64)),
            opening: 0.0,
        };
        ActionChunk((0..HORIZON).map(action).collect())
    }

    #[test]
    fn anchored_demonstrations_are_compared_as_they_are_taught() {
        let demonstrated = Episode {
            observations: Vec::new(),
            // Against its motion, and 0.1 rad off.
            actions: path(PI + 0.1).0,
            alternative: None,
            disturbance: None,
        };
        let dataset = Dataset { episodes: vec![demonstrated], meta: None };
        let images = [0.9, 0.12, -0.5].map(path);
        let pairs = (0..).zip(images).map(|(m, image)| FlowPair { noise: chunk(f64::from(m)), image });
        let pairs = [WindowPairs { window: Window { episode: 0, step: 0 }, pairs: pairs.collect() }];
        let config = MixtureConfig { pair_share: 0.0, coupling: Coupling::Anchored };
        let mixture = Mixture::new(config, &pairs, &dataset, HORIZON).unwrap();
        let chosen = |nearest_half_turn: bool, parameterisation: Parameterisation| {
            let decoder = DecoderConfig { nearest_half_turn, parameterisation, ..DecoderConfig::default() };
            let drawn = mixture.draw(&dataset, &decoder, 0.3, &mut ChaCha8Rng::seed_from_u64(1));
            let example = drawn.unwrap().unwrap();
            (x_m(&example.noise), example.clean == path(PI + 0.1))
        };
        assert_eq!(chosen(true, Parameterisation::Endpoint), (1.0, false), "0.02 rad off, once taught");
        // 3.14 − 0.8 rad off as recorded.
        assert_eq!(chosen(false, Parameterisation::Endpoint), (0.0, true));
        assert_eq!(chosen(true, Parameterisation::Twist), (0.0, true), "velocities are taught as recorded");
    }

    #[test]
    fn a_pair_keeps_its_own_image_and_first_windows_have_their_share() {
        let config = MixtureConfig { pair_share: 1.0, coupling: Coupling::Anchored };
        let drawn: Vec<Example> = draws(config, 0.6).into_iter().flatten().collect();
        for example in &drawn {
            let off = x_m(&example.clean) - example.window.episode as f64;
            let expected = [-0.3, -0.1, 0.2, 0.4][(x_m(&example.noise) - 100.0).round() as usize];
            assert!((off - expected).abs() < 1e-9, "the ends of a pair were swapped or mixed");
        }
        let first = drawn.iter().filter(|example| example.window.step == 0).count();
        // 0.6 at the first window, and half of the rest.
        assert!(first.abs_diff(DRAWS * 8 / 10) < 105, "{first}");
    }

    #[test]
    fn pairs_that_do_not_fit_are_refused() {
        let (dataset, pairs) = world();
        let refused = |pairs: &[WindowPairs], horizon: usize, part: &str| {
            let config = MixtureConfig::default();
            let fault = Mixture::new(config, pairs, &dataset, horizon).unwrap_err().to_string();
            assert!(fault.contains(part), "{fault}");
        };
        refused(&[], HORIZON, "there is none");
        refused(&pairs, HORIZON + 1, "trajectories of 3 actions");
        let mut elsewhere = pairs.clone();
        elsewhere[3].window.step = 6;
        refused(&elsewhere, HORIZON, "window 3 is step 6 of episode 1");
        elsewhere[3] = WindowPairs { pairs: Vec::new(), ..pairs[3].clone() };
        refused(&elsewhere, HORIZON, "window 3 has no pair");
    }

    #[test]
    fn flow_2_minimises_what_flow_1_did_unless_it_is_told_otherwise() {
        let base = TrainConfig {
            objective: ObjectiveConfig { nodes: 0.25, ..ObjectiveConfig::default() },
            ..TrainConfig::default()
        };
        let plain = ReflowConfig::default();
        assert_eq!(plain.training(&base, 1).objective, base.objective);
        let robust = ObjectiveConfig { pseudo_huber: Some(0.1), ..ObjectiveConfig::default() };
        let told = ReflowConfig { objective: Some(robust), ..plain };
        assert_eq!(told.training(&base, 1).objective, robust);
        let slow = ReflowConfig { warmup: 2000, ..told.clone() }.validate(&base).unwrap_err();
        assert!(slow.to_string().contains("reflow.warmup"), "{slow}");
        let broken = ObjectiveConfig { pseudo_huber: Some(-1.0), ..robust };
        let fault = ReflowConfig { objective: Some(broken), ..told }.validate(&base).unwrap_err();
        assert!(fault.to_string().contains("pseudo_huber"), "{fault}");
    }
}
