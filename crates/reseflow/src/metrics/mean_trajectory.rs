//! The first predictor that any policy must beat: the mean trajectory relative to the gripper. It never looks at the cloud.

use reseflow_data::{Action, ActionChunk, Episode, Observation};
use reseflow_lie::{LieError, SE3};

use super::mean;

/// For each action the Fréchet mean, over the training episodes, of its pose in the frame of the gripper at the start.
#[derive(Debug, Clone)]
pub struct MeanTrajectory {
    gripper_from_action: Vec<(SE3, f64)>,
}

impl MeanTrajectory {
    /// The mean of `demonstrations`, without those that were disturbed.
    ///
    /// # Errors
    /// When there is no demonstration, or when the poses are scattered so widely that their mean does not converge.
    pub fn fit(demonstrations: &[Episode]) -> Result<Self, LieError> {
        let calm: Vec<&Episode> =
            demonstrations.iter().filter(|episode| episode.disturbance.is_none()).collect();
        let horizon = calm.iter().map(|episode| episode.actions.len()).max().unwrap_or(0);
        let gripper_from_action =
            (0..horizon).map(|step| mean_action(&calm, step)).collect::<Result<_, _>>()?;
        if horizon == 0 { Err(LieError::EmptyMean) } else { Ok(Self { gripper_from_action }) }
    }

    /// The mean trajectory, starting from the gripper of `first`.
    pub fn predict(&self, first: &Observation) -> ActionChunk {
        let action = |(gripper_from_action, opening): &(SE3, f64)| Action {
            world_from_gripper: first.world_from_gripper * *gripper_from_action,
            opening: *opening,
        };
        ActionChunk(self.gripper_from_action.iter().map(action).collect())
    }
}

fn mean_action(demonstrations: &[&Episode], step: usize) -> Result<(SE3, f64), LieError> {
    let mut poses = Vec::with_capacity(demonstrations.len());
    let mut openings = Vec::with_capacity(demonstrations.len());
    for episode in demonstrations {
        if let (Some(first), Some(action)) = (episode.observations.first(), episode.actions.get(step)) {
            poses.push(first.world_from_gripper.inverse() * action.world_from_gripper);
            openings.push(action.opening);
        }
    }
    let pose = SE3::frechet_mean(&poses, &vec![1.0; poses.len()])?;
    Ok((pose, mean(&openings).unwrap_or_default()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::nearest_demonstration::tests::demonstration;
    use reseflow_lie::{BodyTwist, Vector3, geodesic_distance};

    fn pose(angular: [f64; 3], linear: [f64; 3]) -> SE3 {
        SE3::exp(&BodyTwist::new(Vector3::from(angular), Vector3::from(linear)))
    }

    #[test]
    fn moves_with_the_gripper_and_averages_what_is_relative_to_it() {
        let (a, b) = (pose([0.3, 0.0, 0.0], [0.1, 0.0, 0.0]), pose([-0.3, 0.0, 0.0], [0.3, 0.0, 0.0]));
        let starts = [pose([0.1, 1.0, 0.4], [1.0, 2.0, 3.0]), pose([2.0, 0.0, 0.3], [-1.0, 0.0, 0.5])];
        let demonstrations = [demonstration(&starts[0], &a, 0.0), demonstration(&starts[1], &b, 1.0)];
        let mean = MeanTrajectory::fit(&demonstrations).unwrap();
        let start = pose([0.0, 0.2, 0.9], [5.0, 0.0, 0.0]);
        let predicted = mean.predict(&demonstration(&start, &a, 0.0).observations[0]);
        // The two relative poses are mirror images about the identity rotation and 0.2 m along x (at first order exact in x).
        let expected_x = 0.5 * (a.translation + b.translation);
        let expected = start * SE3::new(reseflow_lie::SO3::identity(), expected_x);
        assert!(geodesic_distance(&predicted.0[0].world_from_gripper, &expected).d_geo() < 1e-9);
        assert_eq!(predicted.0[0].opening, 0.5);
    }

    #[test]
    fn needs_a_demonstration() {
        assert!(MeanTrajectory::fit(&[]).is_err());
    }
}
