//! Augmentations of a training window, drawn anew each time: the whole scene in another size, points left out, points moved.
//!
//! There is none by rotations: the network is equivariant, so they would teach it nothing.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use reseflow_data::{ActionChunk, Observation, PointCloud};
use reseflow_lie::{SE3, Vector3};

use crate::TrainConfig;

/// A change of size about a point: positions move, orientations stay.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scaling {
    centre_m: Vector3<f64>,
    factor: f64,
}

impl Scaling {
    /// A factor exp(ε), ε ~ N(0, `scale_std`²), within \[½, 2\], about the centroid of `cloud`; `None` without `scale_std`.
    pub(crate) fn draw(cloud: &PointCloud, train: &TrainConfig, rng: &mut ChaCha8Rng) -> Option<Self> {
        if train.scale_std == 0.0 || cloud.is_empty() {
            return None;
        }
        let exponent = Normal::new(0.0, train.scale_std).ok()?.sample(rng);
        let sum: Vector3<f64> = cloud.points.iter().map(|point| Vector3::from(point.map(f64::from))).sum();
        Some(Self { centre_m: sum / cloud.len() as f64, factor: exponent.exp().clamp(0.5, 2.0) })
    }

    fn position(&self, position_m: Vector3<f64>) -> Vector3<f64> {
        self.centre_m + self.factor * (position_m - self.centre_m)
    }

    fn pose(&self, pose: &mut SE3) {
        pose.translation = self.position(pose.translation);
    }

    /// Cloud and gripper in the other size.
    pub(crate) fn observation(&self, observation: &mut Observation) {
        for point in &mut observation.cloud.points {
            *point = self.position(Vector3::from(point.map(f64::from))).map(|value| value as f32).into();
        }
        self.pose(&mut observation.world_from_gripper);
    }

    /// The actions in the other size.
    pub(crate) fn actions(&self, chunk: &mut ActionChunk) {
        chunk.0.iter_mut().for_each(|action| self.pose(&mut action.world_from_gripper));
    }
}

/// Leaves out a random share of the points, uniform in 0 … `share`; those that stay keep their order.
pub(crate) fn drop_points(cloud: &mut PointCloud, share: f64, rng: &mut ChaCha8Rng) {
    if share == 0.0 || cloud.is_empty() {
        return;
    }
    let count = cloud.len();
    let most = (share * count as f64).floor() as usize;
    let dropped = rng.random_range(0..=most);
    // Walking over the points, each goes with the chance that makes every set of `dropped` points equally likely.
    let mut left = dropped;
    let keep: Vec<bool> = (0..count)
        .map(|index| {
            let drop = rng.random_range(0..count - index) < left;
            left -= usize::from(drop);
            !drop
        })
        .collect();
    let mut kept = keep.iter();
    cloud.points.retain(|_| kept.next().is_some_and(|keep| *keep));
    let mut kept = keep.iter();
    cloud.colors.retain(|_| kept.next().is_some_and(|keep| *keep));
}

/// Moves every point by independent noise.
pub(crate) fn jitter(cloud: &mut PointCloud, sigma_m: f64, rng: &mut ChaCha8Rng) {
    if let Ok(noise) = Normal::new(0.0, sigma_m) {
        for value in cloud.points.iter_mut().flatten() {
            *value += noise.sample(rng) as f32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::rand_core::SeedableRng;
    use reseflow_data::Action;
    use reseflow_lie::{SO3, geodesic_distance};

    fn rng(seed: u64) -> ChaCha8Rng {
        ChaCha8Rng::seed_from_u64(seed)
    }

    /// A cloud whose points and colours tell their index.
    fn cloud(count: u8) -> PointCloud {
        let points = (0..count).map(|i| [f32::from(i), 0.1 * f32::from(i % 7), -0.5]);
        PointCloud { points: points.collect(), colors: (0..count).map(|i| [i, 0, 0]).collect() }
    }

    fn pose(angle: f64, position: [f64; 3]) -> SE3 {
        let rotation = SO3::exp(&Vector3::new(angle, 0.3, -angle));
        SE3 { rotation, translation: Vector3::from(position) }
    }

    #[test]
    fn a_scaled_scene_has_its_distances_scaled_and_its_rotations_and_centroid_as_they_were() {
        let train = TrainConfig { scale_std: 0.3, ..TrainConfig::default() };
        let mut factors = Vec::new();
        for seed in 0..20 {
            let before = Observation {
                cloud: cloud(30),
                world_from_gripper: pose(0.7, [1.0, -2.0, 0.5]),
                gripper_opening: 0.4,
            };
            let actions = ActionChunk(
                [(0.1, [0.0, 0.0, 0.0]), (2.0, [3.0, 1.0, -1.0])]
                    .map(|(angle, at)| Action { world_from_gripper: pose(angle, at), opening: 0.5 })
                    .to_vec(),
            );
            let scaling = Scaling::draw(&before.cloud, &train, &mut rng(seed)).unwrap();
            let (mut after, mut moved) = (before.clone(), actions.clone());
            scaling.observation(&mut after);
            scaling.actions(&mut moved);
            let factor = scaling.factor;
            factors.push(factor);

            for (one, other) in actions.iter().zip(moved.iter()) {
                let before = geodesic_distance(&before.world_from_gripper, &one.world_from_gripper);
                let after = geodesic_distance(&after.world_from_gripper, &other.world_from_gripper);
                assert!((after.rotation_rad - before.rotation_rad).abs() < 1e-12, "a rotation changed");
                assert!((after.translation_m - factor * before.translation_m).abs() < 1e-12);
                assert_eq!(one.opening, other.opening);
            }
            let to_gripper = |seen: &Observation, index: usize| {
                let point = Vector3::from(seen.cloud.points[index].map(f64::from));
                (point - seen.world_from_gripper.translation).norm()
            };
            for index in 0..30 {
                assert!((to_gripper(&after, index) - factor * to_gripper(&before, index)).abs() < 1e-5);
            }
            let centroid = |seen: &Observation| {
                seen.cloud
                    .points
                    .iter()
                    .map(|point| Vector3::from(point.map(f64::from)))
                    .sum::<Vector3<f64>>()
                    / 30.0
            };
            assert!((centroid(&after) - centroid(&before)).norm() < 1e-5, "the centroid moved");
            assert_eq!(after.cloud.colors, before.cloud.colors);
        }
        assert!(factors.iter().any(|factor| *factor < 0.9) && factors.iter().any(|factor| *factor > 1.1));
        assert!(factors.iter().all(|factor| (0.5..=2.0).contains(factor)));
    }

    #[test]
    fn a_thinned_cloud_keeps_at_least_its_share_in_order_with_its_colours() {
        let whole = cloud(101);
        let mut counts = Vec::new();
        let mut seen = [0_usize; 101];
        for seed in 0..400 {
            let mut thinned = whole.clone();
            drop_points(&mut thinned, 0.5, &mut rng(seed));
            assert_eq!(thinned.points.len(), thinned.colors.len());
            assert!(2 * thinned.len() >= whole.len(), "{} of 101 points are left", thinned.len());
            let indices: Vec<usize> = thinned.points.iter().map(|point| point[0] as usize).collect();
            assert!(indices.is_sorted_by(|a, b| a < b), "the order changed: {indices:?}");
            for (&index, color) in indices.iter().zip(&thinned.colors) {
                assert_eq!(usize::from(color[0]), index, "a point has another one's colour");
                seen[index] += 1;
            }
            counts.push(thinned.len());
        }
        assert!(counts.iter().min() < Some(&60) && counts.iter().max() > Some(&95), "{counts:?}");
        // On average three quarters stay, and no place in the list is favoured (400 draws: five standard deviations are 45).
        assert!(seen.iter().all(|times| times.abs_diff(300) < 50), "{seen:?}");
    }

    #[test]
    fn augmentations_that_are_off_draw_nothing() {
        let (mut one, mut other) = (rng(3), rng(3));
        let mut same = cloud(20);
        drop_points(&mut same, 0.0, &mut one);
        assert!(Scaling::draw(&same, &TrainConfig::default(), &mut one).is_none());
        assert_eq!(same, cloud(20));
        assert_eq!(one.random::<u64>(), other.random::<u64>());
    }
}
