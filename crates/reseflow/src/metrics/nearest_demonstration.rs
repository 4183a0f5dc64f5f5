//! The second predictor that any policy must beat: the nearest training demonstration, moved along with the gripper.
//!
//! "Nearest" uses only what a policy may see at the start: the symmetric chamfer distance (Barrow et al., 1977) between the two
//! coloured clouds, each in the frame of its own gripper. Colour counts as a fourth to sixth coordinate.

use rayon::prelude::*;
use reseflow_data::{Action, ActionChunk, Episode, Observation};
use reseflow_lie::Vector3;

/// How many metres the full range of one colour channel is worth.
const COLOR_SCALE_M: f32 = 0.1;

/// A point and its colour in the gripper's frame, all in metres.
type Feature = [f32; 6];

/// Training demonstrations, ready to be compared with.
#[derive(Debug, Clone)]
pub struct NearestDemonstration<'a> {
    demonstrations: Vec<(&'a Episode, Vec<Feature>)>,
}

impl<'a> NearestDemonstration<'a> {
    /// Prepares `demonstrations`; episodes without an observation are left out.
    pub fn fit(demonstrations: &'a [Episode]) -> Self {
        let prepare = |episode: &'a Episode| Some((episode, features(episode.observations.first()?)));
        Self { demonstrations: demonstrations.iter().filter_map(prepare).collect() }
    }

    /// The nearest demonstration's actions, moved by what takes its gripper to the gripper of `first`; `None` when there is no
    /// demonstration.
    pub fn predict(&self, first: &Observation) -> Option<ActionChunk> {
        let query = features(first);
        let distance = |(_, cloud): &(&Episode, Vec<Feature>)| chamfer(&query, cloud);
        let distances: Vec<f32> = self.demonstrations.par_iter().map(distance).collect();
        let (nearest, _) = distances.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1))?;
        let episode = self.demonstrations.get(nearest)?.0;
        let here_from_there = first.world_from_gripper * episode.observations.first()?.world_from_gripper.inverse();
        let moved = |action: &Action| Action {
            world_from_gripper: here_from_there * action.world_from_gripper,
            opening: action.opening,
        };
        Some(ActionChunk(episode.actions.iter().map(moved).collect()))
    }
}

fn features(observation: &Observation) -> Vec<Feature> {
    let gripper_from_world = observation.world_from_gripper.inverse();
    let cloud = &observation.cloud;
    let feature = |(point, color): (&[f32; 3], &[u8; 3])| {
        let local = gripper_from_world.act(&Vector3::from(point.map(f64::from)));
        let [r, g, b] = color.map(|channel| f32::from(channel) / 255.0 * COLOR_SCALE_M);
        [local.x as f32, local.y as f32, local.z as f32, r, g, b]
    };
    cloud.points.iter().zip(&cloud.colors).map(feature).collect()
}

/// The mean squared distance from each point to the other cloud's nearest, both ways.
fn chamfer(a: &[Feature], b: &[Feature]) -> f32 {
    let mut nearest_to_a = vec![f32::INFINITY; a.len()];
    let mut nearest_to_b = vec![f32::INFINITY; b.len()];
    for (p, near_p) in a.iter().zip(&mut nearest_to_a) {
        for (q, near_q) in b.iter().zip(&mut nearest_to_b) {
            let squared: f32 = p.iter().zip(q).map(|(x, y)| (x - y) * (x - y)).sum();
            *near_p = near_p.min(squared);
            *near_q = near_q.min(squared);
        }
    }
    let mean = |values: &[f32]| values.iter().sum::<f32>() / values.len().max(1) as f32;
    mean(&nearest_to_a) + mean(&nearest_to_b)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use reseflow_data::PointCloud;
    use reseflow_lie::{BodyTwist, SE3, geodesic_distance};

    /// One frame and one action; two points whose second lies at `x_m` in the gripper's frame.
    pub(in crate::metrics) fn demonstration(world_from_gripper: &SE3, gripper_from_action: &SE3, x_m: f64) -> Episode {
        let world = |p: [f64; 3]| {
            let point = world_from_gripper.act(&Vector3::from(p));
            [point.x as f32, point.y as f32, point.z as f32]
        };
        let cloud = PointCloud {
            points: vec![world([0.0, 0.0, 0.1]), world([x_m, 0.0, 0.1])],
            colors: vec![[255, 0, 0], [0, 0, 255]],
        };
        let first = Observation { cloud, world_from_gripper: *world_from_gripper, gripper_opening: 1.0 };
        let world_from_gripper = *world_from_gripper * *gripper_from_action;
        Episode { observations: vec![first], actions: vec![Action { world_from_gripper, opening: x_m }] }
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
    }

    #[test]
    fn colour_tells_scenes_apart() {
        let red: Vec<Feature> = vec![[0.0, 0.0, 0.0, COLOR_SCALE_M, 0.0, 0.0]];
        let blue: Vec<Feature> = vec![[0.0, 0.0, 0.0, 0.0, 0.0, COLOR_SCALE_M]];
        assert!(chamfer(&red, &blue) > 0.01 && chamfer(&red, &red) == 0.0);
        let two = [red[0], blue[0]];
        assert_eq!(chamfer(&red, &two), chamfer(&two, &red), "symmetric");
    }
}
