//! The turned split on recorded episodes: every array of an episode multiplied by a rigid motion g of its own, paired with the test
//! split. An equivariant sampler answers g times what it answers there.

use std::path::Path;

use reseflow_data::{ActionChunk, Dataset, Episode, EpisodeKey, Observation, Split};
use reseflow_lie::{SE3, geodesic_distance};
use reseflow_train::Solver;
use serde::{Deserialize, Serialize};

use super::run::EvalInputs;
use super::{EvalReport, Loaded, SamplePolicy, StepRow, predict_first};
use crate::error::about_data;
use crate::metrics::quantile;
use crate::rollouts::{motion_of, move_action, move_observation};

/// How far answers to turned scenes are from the turned answers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TurnedScores {
    /// For each row that the test split has as well, in their order: the largest difference of an episode's D̄_geo from that of its twin on the test split.
    pub d_geo_difference_max: Vec<f64>,
    /// The distance of single actions.
    pub equivariance: EquivarianceError,
}

/// D_geo between the answer to g times a scene and g times the answer to the scene, over all actions, seeds and episodes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EquivarianceError {
    /// Integration steps; of the baseline, noise levels visited.
    pub steps: usize,
    /// Actions compared.
    pub actions: usize,
    /// The median.
    pub p50: f64,
    /// The 99th percentile.
    pub p99: f64,
    /// The 99.9th percentile.
    pub p999: f64,
    /// The largest.
    pub max: f64,
}

/// Each episode of `test` moved by its motion.
pub fn turned(test: &Dataset) -> Dataset {
    let moved = test.episodes.iter().zip(motions(test)).map(|(episode, motion)| Episode {
        observations: episode
            .observations
            .iter()
            .map(|seen: &Observation| move_observation(&motion, seen.clone()))
            .collect(),
        actions: episode.actions.iter().map(|action| move_action(&motion, action)).collect(),
        alternative: episode
            .alternative
            .as_ref()
            .map(|poses| poses.iter().map(|pose| motion * *pose).collect()),
        disturbance: episode.disturbance,
    });
    let mut meta = test.meta.clone();
    if let Some(meta) = &mut meta {
        meta.extra.insert("turned".to_owned(), true.into());
    }
    Dataset { episodes: moved.collect(), meta }
}

/// The motion of each episode: that of its key, so that rollouts on the turned split move the same scene alike.
fn motions(test: &Dataset) -> Vec<SE3> {
    let keys = test.meta.as_ref().map(|meta| meta.seeds.as_slice()).unwrap_or_default();
    let unknown = |index| EpisodeKey { task: String::new(), split: Split::Test, seed: 0, index, attempt: 0 };
    let key = |index: usize| keys.get(index).cloned().unwrap_or_else(|| unknown(index as u64));
    (0..test.len()).map(|index| motion_of(&key(index))).collect()
}

/// Compares the policy on turned episodes, which `inputs` name, with the same policy on the test episodes in `test`; `on_turned` and
/// `on_test` are what it scored on each.
///
/// # Errors
/// When the test episodes cannot be read, or do not fit the policy.
pub fn compare_turned(
    inputs: &EvalInputs,
    loaded: &Loaded,
    on_turned: &EvalReport,
    test: &Path,
    on_test: &EvalReport,
) -> anyhow::Result<TurnedScores> {
    let mut dataset = Dataset::read(test)?;
    dataset.episodes.truncate(on_turned.episodes);
    let twin = |turned: &StepRow| on_test.rows.iter().find(|test| test.steps == turned.steps);
    let rows = on_turned.rows.iter().filter_map(|turned| Some((turned, twin(turned)?)));
    let difference = rows.map(|(turned, test)| {
        let twins = turned.scores.per_episode.iter().zip(&test.scores.per_episode);
        twins.map(|(turned, test)| (turned - test).abs()).fold(0.0, f64::max)
    });
    let steps = on_turned.rows.iter().map(|row| row.steps).min().unwrap_or(1);
    let solver = inputs.solver.with_steps(steps);
    let turned = &loaded.held_out().dataset;
    let equivariance = equivariance_error(loaded.sampler(), &dataset, turned, &on_turned.seeds, &solver)
        .map_err(|fault| about_data(test, None, fault))?;
    Ok(TurnedScores { d_geo_difference_max: difference.collect(), equivariance })
}

/// The equivariance error of a sampler between `test` and `turned`, what [`turned`] makes of it.
///
/// # Errors
/// When the episodes or the solver do not fit the policy.
pub fn equivariance_error(
    policy: &dyn SamplePolicy,
    test: &Dataset,
    turned: &Dataset,
    seeds: &[u64],
    solver: &Solver,
) -> anyhow::Result<EquivarianceError> {
    let here = predict_first(policy, test, seeds, solver)?;
    let there = predict_first(policy, turned, seeds, solver)?;
    let mut errors = Vec::new();
    for ((here, there), motion) in here.samples.iter().zip(&there.samples).zip(motions(test)) {
        for (here, there) in here.iter().zip(there) {
            let (ActionChunk(here), ActionChunk(there)) = (&here.consensus, &there.consensus);
            errors.extend(here.iter().zip(there).map(|(here, there)| {
                geodesic_distance(&(motion * here.world_from_gripper), &there.world_from_gripper).d_geo()
            }));
        }
    }
    let at = |q| quantile(&errors, q).unwrap_or_default();
    Ok(EquivarianceError {
        steps: here.steps,
        actions: errors.len(),
        p50: at(0.5),
        p99: at(0.99),
        p999: at(0.999),
        max: at(1.0),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use reseflow_data::{Action, ObservationHistory, PointCloud};
    use reseflow_lie::{BodyTwist, Vector3};
    use reseflow_train::{Drawn, PolicySample};

    fn pose(angular: [f64; 3], linear: [f64; 3]) -> SE3 {
        SE3::exp(&BodyTwist::new(Vector3::from(angular), Vector3::from(linear)))
    }

    fn dataset() -> Dataset {
        let episode = |x: f64| {
            let world_from_gripper = pose([0.1, x, 0.3], [x, 0.2, 0.0]);
            let cloud = PointCloud { points: vec![[x as f32, 0.5, 0.1]], colors: vec![[9; 3]] };
            Episode {
                observations: vec![Observation { cloud, world_from_gripper, gripper_opening: 1.0 }],
                actions: vec![Action { world_from_gripper, opening: 0.5 }],
                alternative: Some(vec![world_from_gripper]),
                disturbance: None,
            }
        };
        Dataset { episodes: vec![episode(0.3), episode(-0.4)], meta: None }
    }

    /// Answers with a step from the gripper, along its own axes or along the world's.
    struct StepAhead {
        along_the_world: bool,
    }

    impl SamplePolicy for StepAhead {
        fn observation_horizon(&self) -> usize {
            1
        }

        fn sample(
            &self,
            histories: &[ObservationHistory],
            seeds: &[u64],
            _: &Solver,
        ) -> anyhow::Result<Drawn> {
            let step = SE3::new(reseflow_lie::SO3::identity(), Vector3::new(0.1, 0.0, 0.0));
            let sample = |history: &ObservationHistory| {
                let gripper = history.latest().world_from_gripper;
                let there = if self.along_the_world { step * gripper } else { gripper * step };
                let consensus = ActionChunk(vec![Action { world_from_gripper: there, opening: 0.0 }]);
                PolicySample { consensus, nodes: Vec::new(), spread: Vec::new() }
            };
            let samples = histories.iter().map(|history| vec![sample(history); seeds.len()]).collect();
            Ok(Drawn { samples, steps: 1, evaluations: 1 })
        }
    }

    #[test]
    fn every_array_of_an_episode_moves_with_it() {
        let test = dataset();
        let turned = turned(&test);
        let motions = motions(&test);
        assert!(motions[0].rotation.angle() > 0.1 && motions[0] != motions[1]);
        for ((here, there), motion) in test.episodes.iter().zip(&turned.episodes).zip(&motions) {
            let near = |a: &SE3, b: &SE3| geodesic_distance(&(*motion * *a), b).d_geo() < 1e-9;
            assert!(near(&here.actions[0].world_from_gripper, &there.actions[0].world_from_gripper));
            let (seen, moved) = (&here.observations[0], &there.observations[0]);
            assert!(near(&seen.world_from_gripper, &moved.world_from_gripper));
            let point = motion.act(&Vector3::from(seen.cloud.points[0].map(f64::from)));
            let got = Vector3::from(moved.cloud.points[0].map(f64::from));
            assert!((point - got).norm() < 1e-6);
            let (Some(a), Some(b)) = (&here.alternative, &there.alternative) else { panic!("it was lost") };
            assert!(near(&a[0], &b[0]));
        }
    }

    #[test]
    fn the_error_is_nothing_for_an_equivariant_sampler_and_large_for_one_that_knows_the_world() {
        let test = dataset();
        let turned = turned(&test);
        let error = |along_the_world| {
            let policy = StepAhead { along_the_world };
            equivariance_error(&policy, &test, &turned, &[1, 2], &Solver::Euler { steps: 1 }).unwrap()
        };
        let exact = error(false);
        assert!(exact.max < 1e-9 && exact.actions == 4, "{exact:?}");
        let worldly = error(true);
        assert!(worldly.p50 > 0.01 && worldly.max <= 0.2 + 1e-9, "a step of 0.1 m, twice: {worldly:?}");
    }
}
