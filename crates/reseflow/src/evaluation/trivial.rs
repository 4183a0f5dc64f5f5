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
    /// Training episodes that both were made from.
    pub training_episodes: usize,
}

impl TrivialScores {
    /// The name and D̄_geo of the better one.
    pub fn better(&self) -> (&'static str, f64) {
        let (mean, nearest) = (self.mean_trajectory.d_geo_mean, self.nearest_demonstration.d_geo_mean);
        if mean < nearest { ("mean trajectory", mean) } else { ("nearest demonstration", nearest) }
    }
}

/// Fits both predictors to `training` and scores them on `held_out`.
///
/// # Errors
/// Bad input when either set is empty, or when the training poses have no mean.
pub fn trivial_scores(training: &Dataset, held_out: &Dataset) -> anyhow::Result<TrivialScores> {
    let no_mean = |fault| bad_input(format!("the training data has no mean trajectory: {fault}"));
    let mean = MeanTrajectory::fit(&training.episodes).map_err(no_mean)?;
    let nearest = NearestDemonstration::fit(&training.episodes);
    Ok(TrivialScores {
        mean_trajectory: score(held_out, &|first| Some(mean.predict(first)))?,
        nearest_demonstration: score(held_out, &|first| nearest.predict(first))?,
        nearest_by: NEAREST_BY.to_owned(),
        training_episodes: training.len(),
    })
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
