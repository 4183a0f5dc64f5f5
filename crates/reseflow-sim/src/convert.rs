//! The one place where f64 poses (nalgebra) meet the physics engine's f32 poses (glam).

use glamx::{Pose3, Quat, Vec3};
use nalgebra::Vector3;
use reseflow_lie::{SE3, SO3};

/// The engine's pose nearest to `pose`.
pub(crate) fn pose_from_se3(pose: &SE3) -> Pose3 {
    let [x, y, z, w] = pose.rotation.quaternion_xyzw();
    let rotation = Quat::from_xyzw(x as f32, y as f32, z as f32, w as f32).normalize();
    Pose3::from_parts(vec3(&pose.translation), rotation)
}

/// The pose in f64; `None` where the engine's pose is not finite or no rotation any more.
pub(crate) fn se3_from_pose(pose: &Pose3) -> Option<SE3> {
    let xyzw = pose.rotation.to_array().map(f64::from);
    let rotation = SO3::from_quaternion_xyzw(xyzw).ok()?;
    let pose = SE3::new(rotation, vector3(pose.translation));
    pose.is_finite().then_some(pose)
}

/// A vector for the engine.
pub(crate) fn vec3(vector: &Vector3<f64>) -> Vec3 {
    Vec3::new(vector.x as f32, vector.y as f32, vector.z as f32)
}

/// A vector from the engine.
pub(crate) fn vector3(vector: Vec3) -> Vector3<f64> {
    Vector3::new(f64::from(vector.x), f64::from(vector.y), f64::from(vector.z))
}

/// A point given by its components, for the engine.
pub(crate) fn point3(point: &[f64; 3]) -> Vec3 {
    Vec3::new(point[0] as f32, point[1] as f32, point[2] as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;

    #[test]
    fn there_and_back_keeps_a_pose_to_f32() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for _ in 0..100 {
            let pose = SE3::sample_gaussian(&SE3::identity(), 2.0, 1.0, &mut rng);
            let back = se3_from_pose(&pose_from_se3(&pose)).unwrap();
            assert!(pose.body_twist_to(&back).vector6().norm() < 3e-6);
        }
    }

    #[test]
    fn a_broken_pose_is_refused() {
        let nan = Pose3::from_translation(Vec3::new(f32::NAN, 0.0, 0.0));
        assert!(se3_from_pose(&nan).is_none());
    }
}
