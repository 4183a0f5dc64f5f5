//! The second predictor that any policy must beat: the nearest training demonstration, moved along with the gripper.
//!
//! "Nearest" uses only what a policy may see at the start: where the cloud's centroid lies in the gripper's frame, and in which
//! direction the salient colours lie from the rest. Metres and radians are added as D_geo adds them. Distances between whole clouds
//! (chamfer, with or without colour) were tried and find far worse demonstrations.

use reseflow_data::{Action, ActionChunk, Episode, Observation};
use reseflow_lie::Vector3;
use reseflow_sim::is_salient;

/// What "nearest" means, for reports.
pub const NEAREST_BY: &str = "centroid of the cloud (m) and direction from its other points to its salient ones (rad), in the gripper's frame";

/// A scene as the gripper sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Descriptor {
    /// The cloud's centroid in the gripper's frame, metres.
    centroid_m: Vector3<f64>,
    /// The unit vector from the centroid of the other points to that of the salient ones; zero where there is only one kind.
    salient_direction: Vector3<f64>,
}

/// Training demonstrations, ready to be compared with.
#[derive(Debug, Clone)]
pub struct NearestDemonstration<'a> {
    demonstrations: Vec<(&'a Episode, Descriptor)>,
}

impl<'a> NearestDemonstration<'a> {
    /// Prepares `demonstrations`; episodes without an observation and those that were disturbed are left out.
    pub fn fit(demonstrations: &'a [Episode]) -> Self {
        let prepare = |episode: &'a Episode| Some((episode, Descriptor::of(episode.observations.first()?)));
        let calm = demonstrations.iter().filter(|episode| episode.disturbance.is_none());
        Self { demonstrations: calm.filter_map(prepare).collect() }
    }

    /// The nearest demonstration's actions, moved by what takes its gripper to the gripper of `first`; `None` when there is no
    /// demonstration.
    pub fn predict(&self, first: &Observation) -> Option<ActionChunk> {
        let query = Descriptor::of(first);
        let distance = |candidate: &(&Episode, Descriptor)| query.distance_squared(&candidate.1);
        let (episode, _) = self.demonstrations.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
        let here_from_there =
            first.world_from_gripper * episode.observations.first()?.world_from_gripper.inverse();
        let moved = |action: &Action| Action {
            world_from_gripper: here_from_there * action.world_from_gripper,
            opening: action.opening,
        };
        Some(ActionChunk(episode.actions.iter().map(moved).collect()))
    }
}

impl Descriptor {
    fn of(observation: &Observation) -> Self {
        let gripper_from_world = observation.world_from_gripper.inverse();
        let cloud = &observation.cloud;
        let centroid = |keep: &dyn Fn([u8; 3]) -> bool| {
            let kept = cloud.points.iter().zip(&cloud.colors).filter(|(_, color)| keep(**color));
            let (sum, count) = kept.fold((Vector3::zeros(), 0.0), |(sum, count), (point, _)| {
                (sum + Vector3::from(point.map(f64::from)), count + 1.0)
            });
            (count > 0.0).then(|| gripper_from_world.act(&(sum / count)))
        };
        let direction = match (centroid(&is_salient), centroid(&|color| !is_salient(color))) {
            (Some(salient), Some(rest)) => (salient - rest).try_normalize(1e-9),
            _ => None,
        };
        Self {
            centroid_m: centroid(&|_| true).unwrap_or_default(),
            salient_direction: direction.unwrap_or_default(),
        }
    }

    fn distance_squared(&self, other: &Self) -> f64 {
        (self.centroid_m - other.centroid_m).norm_squared()
            + (self.salient_direction - other.salient_direction).norm_squared()
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use reseflow_data::PointCloud;
    use reseflow_lie::{BodyTwist, SE3, geodesic_distance};

    /// One frame and one action; a salient point lies `x_m` beside a grey one in the gripper's frame.
    pub(in crate::metrics) fn demonstration(
        world_from_gripper: &SE3,
        gripper_from_action: &SE3,
        x_m: f64,
    ) -> Episode {
        let world = |p: [f64; 3]| {
            let point = world_from_gripper.act(&Vector3::from(p));
            [point.x as f32, point.y as f32, point.z as f32]
        };
        let cloud = PointCloud {
            points: vec![world([0.0, 0.0, 0.1]), world([x_m, 0.0, 0.1])],
            colors: vec![[120, 120, 120], [230, 20, 20]],
        };
        let first = Observation { cloud, world_from_gripper: *world_from_gripper, gripper_opening: 1.0 };
        let world_from_gripper = *world_from_gripper * *gripper_from_action;
        Episode {
            observations: vec![first],
            actions: vec![Action { world_from_gripper, opening: x_m }],
            alternative: None,
            disturbance: None,
        }
    }

    #[test]
    fn finds_the_same_scene_wherever_it_was_moved() {
        let step = SE3::exp(&BodyTwist::new(Vector3::new(0.0, 0.0, 0.4), Vector3::new(0.1, 0.0, 0.0)));
        let start = SE3::identity();
        let other = SE3::exp(&BodyTwist::new(Vector3::new(0.5, 1.0, 0.4), Vector3::new(1.0, 2.0, 0.0)));
        let demonstrations: Vec<Episode> = [0.1, 0.2, 0.3].map(|x| demonstration(&start, &step, x)).to_vec();
        let query = demonstration(&other, &step, 0.21);
        let nearest = NearestDemonstration::fit(&demonstrations);
        let predicted = nearest.predict(&query.observations[0]).unwrap();
        assert_eq!(predicted.0[0].opening, 0.2, "the second demonstration is the nearest");
        let truth = query.actions[0].world_from_gripper;
        assert!(geodesic_distance(&predicted.0[0].world_from_gripper, &truth).d_geo() < 1e-6);
        assert_eq!(NearestDemonstration::fit(&[]).predict(&query.observations[0]), None);
    }

    #[test]
    fn colour_tells_directions_apart() {
        let (identity, mut turned) =
            (SE3::identity(), demonstration(&SE3::identity(), &SE3::identity(), 0.2));
        let query = demonstration(&identity, &identity, 0.2);
        turned.observations[0].cloud.colors.reverse();
        let (a, b) = (Descriptor::of(&query.observations[0]), Descriptor::of(&turned.observations[0]));
        assert!((a.distance_squared(&b) - 4.0).abs() < 1e-9, "opposite unit vectors, the same centroid");
        turned.observations[0].cloud.colors = vec![[120; 3]; 2];
        assert_eq!(Descriptor::of(&turned.observations[0]).salient_direction, Vector3::zeros());
    }
}
