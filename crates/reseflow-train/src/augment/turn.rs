//! Scenes turned as a whole.

use rand_chacha::ChaCha8Rng;
use reseflow_data::PointCloud;
use reseflow_lie::{SE3, SO3, Vector3};

/// A rotation of everything about a point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Turn {
    turned_from_world: SE3,
}

impl Turn {
    /// A rotation drawn uniformly from SO(3), about the centroid of `cloud`; `None` where there is no cloud.
    pub(super) fn draw(cloud: &PointCloud, rng: &mut ChaCha8Rng) -> Option<Self> {
        if cloud.is_empty() {
            return None;
        }
        let sum: Vector3<f64> = cloud.points.iter().map(|point| Vector3::from(point.map(f64::from))).sum();
        let centre_m = sum / cloud.len() as f64;
        let rotation = SO3::sample_haar(rng);
        Some(Self { turned_from_world: SE3::new(rotation, centre_m - rotation.act(&centre_m)) })
    }

    pub(super) fn points(&self, points: &mut [[f32; 3]]) {
        for point in points {
            let turned = self.turned_from_world.act(&Vector3::from(point.map(f64::from)));
            *point = turned.map(|value| value as f32).into();
        }
    }

    pub(super) fn pose(&self, pose: &mut SE3) {
        *pose = self.turned_from_world * *pose;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::rand_core::SeedableRng;
    use reseflow_lie::geodesic_distance;

    fn cloud() -> PointCloud {
        let points: Vec<[f32; 3]> =
            (0..30_u8).map(|i| [0.02 * f32::from(i), 0.1 * f32::from(i % 7), -0.5]).collect();
        PointCloud { colors: vec![[0; 3]; points.len()], points }
    }

    fn centroid(points: &[[f32; 3]]) -> Vector3<f64> {
        points.iter().map(|point| Vector3::from(point.map(f64::from))).sum::<Vector3<f64>>()
            / points.len() as f64
    }

    #[test]
    fn a_turned_scene_keeps_its_centroid_and_what_lies_where_as_seen_from_a_pose() {
        let before = SE3::new(SO3::exp(&Vector3::new(0.4, -1.0, 0.2)), Vector3::new(0.3, 0.1, -0.2));
        for seed in 0..50 {
            let turn = Turn::draw(&cloud(), &mut ChaCha8Rng::seed_from_u64(seed)).unwrap();
            let (mut points, mut after) = (cloud().points, before);
            turn.points(&mut points);
            turn.pose(&mut after);
            assert!((centroid(&points) - centroid(&cloud().points)).norm() < 1e-6, "the centroid moved");
            assert!(geodesic_distance(&before, &after).rotation_rad > 0.05, "nothing turned");
            for (new, old) in points.iter().zip(&cloud().points) {
                let seen =
                    |pose: &SE3, point: &[f32; 3]| pose.inverse().act(&Vector3::from(point.map(f64::from)));
                assert!((seen(&after, new) - seen(&before, old)).norm() < 1e-6, "a point was left behind");
            }
        }
    }

    /// Under Haar's measure every axis goes anywhere: the mean of its images is zero and each component squared has the mean ⅓.
    #[test]
    fn turns_are_uniform() {
        let mut rng = ChaCha8Rng::seed_from_u64(9);
        let count = 3000;
        for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
            let (mut mean, mut squares) = (Vector3::zeros(), Vector3::zeros());
            for _ in 0..count {
                let turn = Turn::draw(&cloud(), &mut rng).unwrap();
                let image = turn.turned_from_world.rotation.act(&axis);
                mean += image / f64::from(count);
                squares += image.component_mul(&image) / f64::from(count);
            }
            // Four standard deviations: of a component 1/√3, of its square √(4/45), over √count.
            let allowed = 4.0 / f64::from(count).sqrt();
            assert!(mean.amax() < allowed * 0.577, "{mean}");
            assert!((squares - Vector3::repeat(1.0 / 3.0)).amax() < allowed * 0.298, "{squares}");
        }
    }
}
