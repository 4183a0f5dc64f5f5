//! From a policy's samples to a row of figures.

use reseflow_data::{Dataset, ObservationHistory};
use reseflow_lie::GeodesicDistance;
use reseflow_train::{Drawn, Solver};

use super::StepRow;
use super::modes::score_modes;
use crate::error::bad_input;
use crate::metrics::{Calibration, Scores, TrajectoryError, mean};
use crate::rollouts::FIRST_SEED;

/// Something that draws trajectories: a trained policy, or a stand-in whose errors are known.
pub trait SamplePolicy {
    /// Observation frames O that it is shown.
    fn observation_horizon(&self) -> usize;

    /// One sample for each history and, within it, for each noise seed.
    ///
    /// # Errors
    /// When the observations are not ones that this policy can use.
    fn sample(
        &self,
        histories: &[ObservationHistory],
        seeds: &[u64],
        solver: &Solver,
    ) -> anyhow::Result<Drawn>;
}

/// The noise seeds 3407 … 3407 + `count` − 1.
pub fn noise_seeds(count: usize) -> Vec<u64> {
    (0..count as u64).map(|offset| FIRST_SEED + offset).collect()
}

/// Draws from each episode's first observation: samples `[episode][seed]`.
///
/// # Errors
/// As [`SamplePolicy::sample`].
pub fn predict_first(
    policy: &dyn SamplePolicy,
    dataset: &Dataset,
    seeds: &[u64],
    solver: &Solver,
) -> anyhow::Result<Drawn> {
    let horizon = policy.observation_horizon();
    let first =
        |episode: &reseflow_data::Episode| ObservationHistory::at_step(&episode.observations, 0, horizon);
    let histories: Vec<ObservationHistory> = dataset.episodes.iter().map(first).collect();
    policy.sample(&histories, seeds, solver)
}

/// Scores a policy that draws with `solver` against the episodes' actions; samples three times `unimodal_d_geo` from both experts are
/// between the modes, where there are two.
///
/// # Errors
/// As [`SamplePolicy::sample`]; bad input when the data set holds no action to compare with.
pub fn score_steps(
    policy: &dyn SamplePolicy,
    dataset: &Dataset,
    seeds: &[u64],
    solver: &Solver,
    unimodal_d_geo: f64,
) -> anyhow::Result<StepRow> {
    let started = std::time::Instant::now();
    let Drawn { samples, steps, evaluations } = predict_first(policy, dataset, seeds, solver)?;
    let secs = started.elapsed().as_secs_f64();
    let nothing = || bad_input("the data set holds no action to compare with, expected at least one episode");

    let seeds_drawn = samples.iter().map(Vec::len).min().unwrap_or(0);
    let of_seed = |seed: usize| -> Vec<TrajectoryError> {
        let pairs = samples.iter().zip(&dataset.episodes);
        pairs.filter_map(|(of_episode, truth)| error_of(&of_episode[seed].consensus, truth)).collect()
    };
    let errors: Vec<Vec<TrajectoryError>> = (0..seeds_drawn).map(of_seed).collect();
    let scores = Scores::aggregate(&errors).ok_or_else(nothing)?;

    let nodes = samples.iter().flatten().map(|sample| sample.nodes.len()).min().unwrap_or(0);
    let of_node = |node: usize| {
        let pairs = samples.iter().zip(&dataset.episodes);
        let errors = pairs.flat_map(|(of_episode, truth)| {
            of_episode.iter().filter_map(|sample| error_of(&sample.nodes[node], truth))
        });
        mean(&errors.map(|error| error.d_geo()).collect::<Vec<_>>())
    };
    let sure = samples.iter().zip(&dataset.episodes).flat_map(|(of_episode, truth)| {
        of_episode.iter().filter_map(|sample| Some((sample, error_of(&sample.consensus, truth)?)))
    });
    let of_actions = sure.flat_map(|(sample, error)| {
        let errors: Vec<f64> = error.poses.iter().map(GeodesicDistance::d_geo).collect();
        sample.spread.iter().copied().zip(errors)
    });
    let calibration = Calibration::of(&of_actions.collect::<Vec<_>>());
    let spreads: Vec<f64> = samples.iter().flatten().flat_map(|sample| &sample.spread).copied().collect();
    Ok(StepRow {
        steps,
        evaluations,
        solver: solver.name().to_owned(),
        scores,
        per_node: (0..nodes).filter_map(of_node).collect(),
        node_spread: mean(&spreads),
        calibration,
        latency: None,
        modes: score_modes(&samples, dataset, unimodal_d_geo),
        secs,
    })
}

fn error_of(
    predicted: &reseflow_data::ActionChunk,
    truth: &reseflow_data::Episode,
) -> Option<TrajectoryError> {
    TrajectoryError::between(predicted, &truth.actions)
}

#[cfg(test)]
mod tests {
    use super::*;
    use reseflow_data::{Action, ActionChunk, Episode, Observation, PointCloud};
    use reseflow_lie::{SE3, SO3, Vector3};
    use reseflow_train::PolicySample;

    /// Answers the truth moved along x by 1 cm per step of integration fewer than 11, times the seed's place; node 1 twice that.
    struct Biased;

    fn at(x_m: f64) -> Action {
        Action { world_from_gripper: SE3::new(SO3::identity(), Vector3::new(x_m, 0.0, 0.0)), opening: 1.0 }
    }

    fn episode(x_m: f64) -> Episode {
        let frame = Observation {
            cloud: PointCloud { points: vec![[x_m as f32, 0.0, 0.0]], colors: vec![[0; 3]] },
            world_from_gripper: at(x_m).world_from_gripper,
            gripper_opening: 1.0,
        };
        Episode {
            observations: vec![frame; 2],
            actions: vec![at(x_m); 2],
            alternative: None,
            disturbance: None,
        }
    }

    impl SamplePolicy for Biased {
        fn observation_horizon(&self) -> usize {
            2
        }

        fn sample(
            &self,
            histories: &[ObservationHistory],
            seeds: &[u64],
            solver: &Solver,
        ) -> anyhow::Result<Drawn> {
            let Solver::Euler { steps } = *solver else { anyhow::bail!("expected Euler's solver") };
            let sample = |history: &ObservationHistory, seed: u64| {
                let x = history.latest().world_from_gripper.translation.x;
                let off = 0.01 * (11 - steps) as f64 * (seed - FIRST_SEED + 1) as f64;
                let chunk = |off: f64| ActionChunk(vec![at(x + off); 2]);
                PolicySample {
                    consensus: chunk(off),
                    nodes: vec![chunk(off), chunk(2.0 * off)],
                    spread: vec![off; 2],
                }
            };
            let of = |history| seeds.iter().map(|&seed| sample(history, seed)).collect();
            Ok(Drawn { samples: histories.iter().map(of).collect(), steps, evaluations: steps })
        }
    }

    fn score(dataset: &Dataset, seeds: usize, steps: usize) -> anyhow::Result<StepRow> {
        score_steps(&Biased, dataset, &noise_seeds(seeds), &Solver::Euler { steps }, 0.035)
    }

    #[test]
    fn a_known_bias_comes_out_as_itself() {
        let dataset = Dataset { episodes: vec![episode(0.0), episode(1.0), episode(-3.0)], meta: None };
        let row = score(&dataset, 3, 1).unwrap();
        assert!((row.scores.d_geo_mean - 0.2).abs() < 1e-12, "mean of 0.1, 0.2, 0.3");
        assert!((row.scores.d_geo_std.unwrap() - 0.1).abs() < 1e-12);
        assert!(row.scores.d_geo_episode_std.unwrap() < 1e-12);
        assert_eq!(row.per_node.len(), 2);
        assert!((row.per_node[1] - 0.4).abs() < 1e-12);
        assert!((row.node_spread.unwrap() - 0.2).abs() < 1e-12);
        let calibration = row.calibration.unwrap();
        assert!(calibration.spearman > 0.9, "the spread is the error, up to ties: {calibration:?}");
        assert_eq!(calibration.bins.iter().map(|bin| bin.actions).sum::<usize>(), 3 * 3 * 2);
        let more = score(&dataset, 3, 10).unwrap();
        assert!((more.scores.d_geo_mean - 0.02).abs() < 1e-12);
        assert_eq!((more.steps, more.evaluations), (10, 10));
    }

    #[test]
    fn nothing_to_score_is_bad_input() {
        let error = score(&Dataset::default(), 2, 1).unwrap_err();
        assert_eq!(crate::error::exit_code(&error), crate::error::EXIT_BAD_INPUT);
    }
}
