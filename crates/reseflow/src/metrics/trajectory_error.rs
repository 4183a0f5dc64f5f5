//! How far a predicted trajectory is from the expert's (the ReSeFlow paper, equations "dgeo" and "avg_dgeo").

use reseflow_data::{Action, ActionChunk, gripper_half_turn};
use reseflow_lie::{GeodesicDistance, SE3, geodesic_distance};

use super::mean;

/// The errors of one predicted trajectory, action by action.
#[derive(Debug, Clone, PartialEq)]
pub struct TrajectoryError {
    /// The distance of each of the L poses.
    pub poses: Vec<GeodesicDistance>,
    /// The mean D_geo over the trajectory, or over the trajectory with the gripper turned by half a turn about its approach axis,
    /// whichever is less: a two-finger gripper closes the same way in both.
    pub half_turn_d_geo: f64,
    /// |predicted − true opening|, mean over the actions.
    pub opening: f64,
}

impl TrajectoryError {
    /// Compares the actions that both have; a recorded episode may be shorter than the prediction.
    ///
    /// Returns `None` when there is nothing to compare.
    pub fn between(predicted: &ActionChunk, truth: &[Action]) -> Option<Self> {
        let pairs: Vec<(&Action, &Action)> = predicted.iter().zip(truth).collect();
        let distance = |turn: &SE3| -> Vec<GeodesicDistance> {
            let turned = |action: &Action| action.world_from_gripper * *turn;
            pairs.iter().map(|(p, t)| geodesic_distance(&turned(p), &t.world_from_gripper)).collect()
        };
        let poses = distance(&SE3::identity());
        let openings: Vec<f64> = pairs.iter().map(|(p, t)| (p.opening - t.opening).abs()).collect();
        Some(Self {
            half_turn_d_geo: mean_d_geo(&poses)?.min(mean_d_geo(&distance(&gripper_half_turn()))?),
            opening: mean(&openings)?,
            poses,
        })
    }

    /// D̄_geo: the mean of D_geo over the trajectory.
    pub fn d_geo(&self) -> f64 {
        mean_d_geo(&self.poses).unwrap_or_default()
    }
}

fn mean_d_geo(poses: &[GeodesicDistance]) -> Option<f64> {
    mean(&poses.iter().map(GeodesicDistance::d_geo).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use reseflow_lie::{SO3, Vector3};
    use std::f64::consts::PI;

    fn action(angle_rad: f64, x_m: f64, opening: f64) -> Action {
        let rotation = SO3::exp(&Vector3::new(0.0, 0.0, angle_rad));
        Action { world_from_gripper: SE3::new(rotation, Vector3::new(x_m, 0.0, 0.0)), opening }
    }

    #[test]
    fn is_the_mean_of_the_papers_distance() {
        let truth = [action(0.0, 0.0, 1.0), action(0.5, 1.0, 0.0)];
        let predicted = ActionChunk(vec![action(0.3, 0.4, 0.5), action(0.5, 1.0, 0.0)]);
        let error = TrajectoryError::between(&predicted, &truth).unwrap();
        assert!(
            (error.d_geo() - 0.25).abs() < 1e-12,
            "3-4-5 at the first action, 0 at the second: {error:?}"
        );
        assert!((error.poses[0].rotation_rad - 0.3).abs() < 1e-12);
        assert!((error.poses[0].translation_m - 0.4).abs() < 1e-12);
        assert!((error.opening - 0.25).abs() < 1e-12);
        assert!((error.half_turn_d_geo - error.d_geo()).abs() < 1e-12);
    }

    #[test]
    fn a_half_turned_gripper_is_forgiven_only_there() {
        let truth = [action(0.0, 0.0, 1.0), action(0.5, 1.0, 1.0)];
        let turned = ActionChunk(vec![action(PI, 0.0, 1.0), action(0.5 + PI, 1.0, 1.0)]);
        let error = TrajectoryError::between(&turned, &truth).unwrap();
        assert!((error.d_geo() - PI).abs() < 1e-9);
        assert!(error.half_turn_d_geo < 1e-9);
        let half = ActionChunk(vec![action(PI, 0.0, 1.0), action(0.5, 1.0, 1.0)]);
        let error = TrajectoryError::between(&half, &truth).unwrap();
        assert!(
            (error.half_turn_d_geo - PI / 2.0).abs() < 1e-9,
            "a turn in mid-trajectory is an error: {error:?}"
        );
    }

    #[test]
    fn compares_what_both_have() {
        let error =
            TrajectoryError::between(&ActionChunk(vec![action(0.0, 0.0, 1.0); 3]), &[action(0.0, 2.0, 1.0)]);
        assert_eq!(error.map(|e| e.poses.len()), Some(1));
        assert_eq!(TrajectoryError::between(&ActionChunk::default(), &[action(0.0, 0.0, 1.0)]), None);
    }
}
