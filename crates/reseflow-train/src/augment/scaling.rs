//! Scenes in another size.

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use reseflow_data::PointCloud;
use reseflow_lie::{SE3, Vector3};

/// A change of size about a point: positions move, orientations stay.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scaling {
    centre_m: Vector3<f64>,
    factor: f64,
}

impl Scaling {
    /// A factor exp(ε), ε ~ N(0, `scale_std`²), within \[½, 2\], about the centroid of `cloud`; `None` without `scale_std`.
    pub(super) fn draw(cloud: &PointCloud, scale_std: f64, rng: &mut ChaCha8Rng) -> Option<Self> {
        if scale_std == 0.0 || cloud.is_empty() {
            return None;
        }
        let exponent = Normal::new(0.0, scale_std).ok()?.sample(rng);
        let sum: Vector3<f64> = cloud.points.iter().map(|point| Vector3::from(point.map(f64::from))).sum();
        Some(Self { centre_m: sum / cloud.len() as f64, factor: exponent.exp().clamp(0.5, 2.0) })
    }

    fn position(&self, position_m: Vector3<f64>) -> Vector3<f64> {
        self.centre_m + self.factor * (position_m - self.centre_m)
    }

    pub(super) fn points(&self, points: &mut [[f32; 3]]) {
        for point in points {
            *point = self.position(Vector3::from(point.map(f64::from))).map(|value| value as f32).into();
        }
    }

    pub(super) fn pose(&self, pose: &mut SE3) {
        pose.translation = self.position(pose.translation);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::rand_core::SeedableRng;
    use reseflow_lie::{SO3, geodesic_distance};

    fn pose(angle: f64, position: [f64; 3]) -> SE3 {
        SE3::new(SO3::exp(&Vector3::new(angle, 0.3, -angle)), Vector3::from(position))
    }

    #[test]
    fn a_scaled_scene_has_its_distances_scaled_and_its_rotations_and_centroid_as_they_were() {
        let points: Vec<[f32; 3]> =
            (0..30_u8).map(|i| [f32::from(i), 0.1 * f32::from(i % 7), -0.5]).collect();
        let cloud = PointCloud { colors: vec![[0; 3]; points.len()], points };
        let gripper = pose(0.7, [1.0, -2.0, 0.5]);
        let mut factors = Vec::new();
        for seed in 0..20 {
            let scaling = Scaling::draw(&cloud, 0.3, &mut ChaCha8Rng::seed_from_u64(seed)).unwrap();
            let (mut seen, mut scaled_gripper) = (cloud.points.clone(), gripper);
            scaling.points(&mut seen);
            scaling.pose(&mut scaled_gripper);
            let factor = scaling.factor;
            factors.push(factor);
            for one in [pose(0.1, [0.0, 0.0, 0.0]), pose(2.0, [3.0, 1.0, -1.0])] {
                let mut other = one;
                scaling.pose(&mut other);
                let before = geodesic_distance(&gripper, &one);
                let after = geodesic_distance(&scaled_gripper, &other);
                assert!((after.rotation_rad - before.rotation_rad).abs() < 1e-12, "a rotation changed");
                assert!((after.translation_m - factor * before.translation_m).abs() < 1e-12);
            }
            let to = |point: [f32; 3], gripper: &SE3| {
                (Vector3::from(point.map(f64::from)) - gripper.translation).norm()
            };
            for (after, before) in seen.iter().zip(&cloud.points) {
                assert!((to(*after, &scaled_gripper) - factor * to(*before, &gripper)).abs() < 1e-5);
            }
            let centroid = |points: &[[f32; 3]]| {
                points.iter().map(|point| Vector3::from(point.map(f64::from))).sum::<Vector3<f64>>() / 30.0
            };
            assert!((centroid(&seen) - centroid(&cloud.points)).norm() < 1e-5, "the centroid moved");
        }
        assert!(factors.iter().any(|factor| *factor < 0.9) && factors.iter().any(|factor| *factor > 1.1));
        assert!(factors.iter().all(|factor| (0.5..=2.0).contains(factor)));
    }
}
