//! What the two trivial predictors score on the same episodes.

use reseflow_data::{ActionChunk, Dataset, Observation};
use serde::{Deserialize, Serialize};

use crate::error::bad_input;
use crate::metrics::{MeanTrajectory, NEAREST_BY, NearestDemonstration, Scores, TrajectoryError};

/// The scores of the predictors that any policy must beat.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrivialScores {
    /// The mean training trajectory relative to the gripper.
    pub mean_trajectory: Scores,
    /// The nearest training demonstration, aligned by the gripper.
    pub nearest_demonstration: Scores,
    /// What "nearest" means.
    pub nearest_by: String,
    /// Training episodes that both were made from: those that were not disturbed.
    pub training_episodes: usize,
}

impl TrivialScores {
    /// The name and D̄_geo of the better one.
    pub fn better(&self) -> (&'static str, f64) {
        let (mean, nearest) = (self.mean_trajectory.d_geo_mean, self.nearest_demonstration.d_geo_mean);
        if mean < nearest { ("mean trajectory", mean) } else { ("nearest demonstration", nearest) }
    }
}

/// Fits both predictors to `training` and scores them on `held_out`; `None` where every training episode was disturbed.
///
/// # Errors
/// Bad input when either set is empty, or when the training poses have no mean.
pub fn trivial_scores(training: &Dataset, held_out: &Dataset) -> anyhow::Result<Option<TrivialScores>> {
    let calm = training.episodes.iter().filter(|episode| episode.disturbance.is_none()).count();
    if calm == 0 && !training.episodes.is_empty() {
        return Ok(None);
    }
    let no_mean = |fault| bad_input(format!("the training data has no mean trajectory: {fault}"));
    let mean = MeanTrajectory::fit(&training.episodes).map_err(no_mean)?;
    let nearest = NearestDemonstration::fit(&training.episodes);
    Ok(Some(TrivialScores {
        mean_trajectory: score(held_out, &|first| Some(mean.predict(first)))?,
        nearest_demonstration: score(held_out, &|first| nearest.predict(first))?,
        nearest_by: NEAREST_BY.to_owned(),
        training_episodes: calm,
    }))
}

fn score(
    held_out: &Dataset,
    predict: &dyn Fn(&Observation) -> Option<ActionChunk>,
) -> anyhow::Result<Scores> {
    let error = |episode: &reseflow_data::Episode| {
        TrajectoryError::between(&predict(episode.observations.first()?)?, &episode.actions)
    };
    let errors: Vec<TrajectoryError> = held_out.episodes.iter().filter_map(error).collect();
    Scores::aggregate(&[errors])
        .ok_or_else(|| bad_input("there is no episode to score the trivial predictors on"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use reseflow_data::{Action, Disturbance, Episode, PointCloud};
    use reseflow_lie::{SE3, SO3, Vector3};

    /// An episode of two actions at x, from the world's origin.
    fn episode(x_m: f64, disturbance: Option<Disturbance>) -> Episode {
        let cloud = PointCloud { points: vec![[0.0; 3]; 4], colors: vec![[0; 3]; 4] };
        let frame = Observation { cloud, world_from_gripper: SE3::identity(), gripper_opening: 1.0 };
        let world_from_gripper = SE3::new(SO3::identity(), Vector3::new(x_m, 0.0, 0.0));
        let actions = vec![Action { world_from_gripper, opening: 1.0 }; 2];
        Episode { observations: vec![frame; 2], actions, alternative: None, disturbance }
    }

    #[test]
    fn trivial_predictors_are_made_from_undisturbed_episodes_alone() {
        let disturbance = Some(Disturbance { before: 0, answered_from: 1 });
        let set = |episodes| Dataset { episodes, meta: None };
        let held_out = set(vec![episode(0.2, None)]);
        let mixed = set(vec![episode(0.1, None), episode(0.9, disturbance), episode(0.1, None)]);
        let scores = trivial_scores(&mixed, &held_out).unwrap().unwrap();
        assert_eq!(scores.training_episodes, 2);
        for scores in [&scores.mean_trajectory, &scores.nearest_demonstration] {
            assert!((scores.d_geo_mean - 0.1).abs() < 1e-9, "{scores:?}");
        }
        let disturbed = set(vec![episode(0.9, disturbance)]);
        assert_eq!(trivial_scores(&disturbed, &held_out).unwrap(), None);
        assert!(trivial_scores(&set(Vec::new()), &held_out).is_err());
    }
}
