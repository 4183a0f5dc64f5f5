//! Pairs for Flow 2: noise drawn for training windows, carried along a trained flow.

use std::sync::atomic::{AtomicUsize, Ordering};

use rand::seq::index;
use rand_chacha::ChaCha8Rng;
use reseflow_data::{ActionChunk, Dataset, Episode, FlowPair, Window, WindowPairs};
use reseflow_flow::{AdaptiveConfig, PriorFrame, Solver, integrate};
use serde::{Deserialize, Serialize};

use crate::field::{NetField, Seen};
use crate::trainable::random_stream;
use crate::{FlowPolicy, TrainError};

/// Windows that are encoded together and share an adaptive solver's steps: part of the arithmetic, so not guessed from the machine.
const TOGETHER: usize = 16;

/// Which pairs are made, and how.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PairConfig {
    /// Windows of each episode: its first one, and others at random; all where it has no more.
    pub windows: usize,
    /// Noises drawn for each window, M.
    pub noises: usize,
    /// How the flow is integrated.
    pub solver: Solver,
    /// Names the random streams of windows and noise.
    pub seed: u64,
}

impl Default for PairConfig {
    fn default() -> Self {
        let tolerances = AdaptiveConfig { rtol: 1e-3, atol: 1e-4, max_steps: 200 };
        Self { windows: 4, noises: 8, solver: Solver::DormandPrince(tolerances), seed: 1 }
    }
}

impl PairConfig {
    /// Checks every value.
    ///
    /// # Errors
    /// [`TrainError::Config`] and [`TrainError::Flow`], naming what is out of range.
    pub fn validate(&self) -> Result<(), TrainError> {
        for (key, value) in [("windows", self.windows), ("noises", self.noises)] {
            if value == 0 {
                return Err(TrainError::Config(format!("reflow.pairs.{key} must be at least 1, got 0")));
            }
        }
        Ok(self.solver.validate()?)
    }
}

/// Carries noise along the flow of `policy`, from windows of `demonstrations`; `progress` hears of finished windows.
///
/// The same pairs come out whatever the number of threads.
///
/// # Errors
/// What the configuration's check, the network or the solver reports.
pub fn make_pairs(
    policy: &FlowPolicy,
    demonstrations: &Dataset,
    config: &PairConfig,
    progress: &(dyn Fn(usize) + Sync),
) -> Result<Vec<WindowPairs>, TrainError> {
    config.validate()?;
    if policy.model.regression {
        return Err(TrainError::Pairs("a regressor has no noise to make pairs of".to_owned()));
    }
    let windows = pair_windows(demonstrations, config);
    let groups: Vec<&[Window]> = windows.chunks(TOGETHER).collect();
    let next = AtomicUsize::new(0);
    let work = |policy: FlowPolicy| {
        let mut made = Vec::new();
        loop {
            let group = next.fetch_add(1, Ordering::Relaxed);
            let Some(windows) = groups.get(group) else { return Ok(made) };
            made.push((group, carry(&policy, demonstrations, config, group * TOGETHER, windows)?));
            progress(windows.len());
        }
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from).min(groups.len().max(1));
    let results: Vec<Result<Vec<_>, TrainError>> = std::thread::scope(|scope| {
        let handles: Vec<_> = (0..threads)
            .map(|_| {
                let own = policy.fork();
                scope.spawn(|| work(own))
            })
            .collect();
        handles.into_iter().map(|handle| handle.join().unwrap_or(Err(TrainError::Worker))).collect()
    });
    let mut made = Vec::with_capacity(groups.len());
    for result in results {
        made.extend(result?);
    }
    made.sort_by_key(|(group, _)| *group);
    Ok(made.into_iter().flat_map(|(_, pairs)| pairs).collect())
}

/// How many windows [`make_pairs`] makes pairs for.
pub fn count_pair_windows(demonstrations: &Dataset, config: &PairConfig) -> usize {
    let windows = |episode: &Episode| episode.actions.len().saturating_sub(episode.first_step());
    demonstrations.episodes.iter().map(|episode| windows(episode).min(config.windows)).sum()
}

/// The windows, in order.
fn pair_windows(demonstrations: &Dataset, config: &PairConfig) -> Vec<Window> {
    let mut windows = Vec::new();
    for (episode, recorded) in demonstrations.episodes.iter().enumerate() {
        let first = recorded.first_step();
        let later = recorded.actions.len().saturating_sub(first + 1);
        let mut rng = random_stream(config.seed, 2 * episode as u64);
        let mut steps = index::sample(&mut rng, later, later.min(config.windows - 1)).into_vec();
        steps.sort_unstable();
        if recorded.actions.len() > first {
            windows.push(Window { episode, step: first });
        }
        windows.extend(steps.into_iter().map(|step| Window { episode, step: first + step + 1 }));
    }
    windows
}

/// The pairs of some windows, the first of which is number `first` of all.
fn carry(
    policy: &FlowPolicy,
    demonstrations: &Dataset,
    config: &PairConfig,
    first: usize,
    windows: &[Window],
) -> Result<Vec<WindowPairs>, TrainError> {
    let FlowPolicy { net, model, device, .. } = policy;
    let decoder = &model.network.decoder;
    let seen = |window: &Window| {
        let recorded = &demonstrations.episodes[window.episode].observations;
        Seen {
            frames: window.frames(&demonstrations.episodes, decoder.frames).collect(),
            world_from_grasp: recorded[window.grasp_step(&demonstrations.episodes)].world_from_gripper,
            elapsed: window.step,
        }
    };
    let scenes: Vec<Seen<'_>> = windows.iter().map(seen).collect();
    let mut streams: Vec<ChaCha8Rng> = (first..first + windows.len())
        .map(|number| random_stream(config.seed, 2 * number as u64 + 1))
        .collect();
    let mut field = NetField::new(net, &scenes, device)?;
    let mut made: Vec<WindowPairs> =
        windows.iter().map(|&window| WindowPairs { window, pairs: Vec::new() }).collect();
    for _ in 0..config.noises {
        let noise: Vec<ActionChunk> = scenes
            .iter()
            .zip(&mut streams)
            .map(|(Seen { frames, .. }, rng)| {
                model.prior.sample(&PriorFrame::of(frames[frames.len() - 1]), decoder.horizon, rng)
            })
            .collect();
        let images = integrate(&mut field.flow(), model.path, noise.clone(), &config.solver)?.states;
        for (of, (noise, image)) in made.iter_mut().zip(noise.into_iter().zip(images)) {
            of.pairs.push(FlowPair { noise, image });
        }
    }
    Ok(made)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::TrainConfig;
    use crate::batch::draw_window;
    use reseflow_data::{Action, Disturbance};
    use reseflow_lie::SE3;

    /// Two episodes of six steps; the second one's disturbance was answered from step 4.
    fn demonstrations() -> Dataset {
        let action = Action { world_from_gripper: SE3::identity(), opening: 0.0 };
        let episode = |disturbance| Episode {
            observations: Vec::new(),
            actions: vec![action; 6],
            alternative: None,
            disturbance,
        };
        let disturbance = Disturbance { before: 2, answered_from: 4 };
        Dataset { episodes: vec![episode(None), episode(Some(disturbance))], meta: None }
    }

    #[test]
    fn no_window_begins_before_a_disturbance_was_answered() {
        let data = demonstrations();
        for (windows, expected) in [(1, vec![0, 4]), (9, vec![0, 1, 2, 3, 4, 5, 4, 5])] {
            let config = PairConfig { windows, ..PairConfig::default() };
            let drawn = pair_windows(&data, &config);
            assert_eq!(drawn.iter().map(|window| window.step).collect::<Vec<_>>(), expected);
            assert_eq!(count_pair_windows(&data, &config), expected.len());
        }
        let mut rng = random_stream(3, 0);
        for first_window_share in [0.0, 1.0] {
            let train = TrainConfig { first_window_share, ..TrainConfig::default() };
            let drawn: Vec<Window> = (0..200).map(|_| draw_window(&data, &train, &mut rng)).collect();
            let steps = |episode: usize| {
                let of = drawn.iter().filter(move |window| window.episode == episode);
                of.map(|window| window.step).collect::<std::collections::BTreeSet<_>>()
            };
            let of_first = if first_window_share > 0.0 { vec![0] } else { (0..6).collect() };
            let of_second = if first_window_share > 0.0 { vec![4] } else { vec![4, 5] };
            assert_eq!(
                (steps(0), steps(1)),
                (of_first.into_iter().collect(), of_second.into_iter().collect())
            );
        }
    }
}
