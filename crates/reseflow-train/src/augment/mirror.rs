//! Scenes seen in a mirror.

use reseflow_lie::{Matrix3, SE3, SO3, Vector3};

/// How long the horizontal part of an axis must be to have a direction.
const LEVEL: f64 = 1e-6;

/// The reflection in a plane through the gripper's origin.
///
/// A parallel gripper is its own mirror image in the plane across its x axis and in the one across its y axis, along which it closes. So
/// the mirrored pose R ↦ S R D is again a pose of the same gripper, with D = diag(−1, 1, 1) or diag(1, −1, 1), and a gripper whose own plane
/// is the mirror stays where it is.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mirror {
    point_m: Vector3<f64>,
    /// The plane's normal, a unit vector.
    normal: Vector3<f64>,
    /// The diagonal of D.
    gripper: Vector3<f64>,
}

impl Mirror {
    /// The plane across the gripper's x axis: the gripper stays where it is.
    pub(super) fn of_gripper(world_from_gripper: &SE3) -> Self {
        let normal = world_from_gripper.rotation.act(&Vector3::x());
        Self { point_m: world_from_gripper.translation, normal, gripper: Vector3::new(-1.0, 1.0, 1.0) }
    }

    /// The upright plane nearest to the one across the gripper's y axis, so that what is up stays up, and where the fingers close level the
    /// gripper stays where it is. There is none where they close straight up and down.
    pub(super) fn upright(world_from_gripper: &SE3) -> Option<Self> {
        let mut normal = world_from_gripper.rotation.act(&Vector3::y());
        normal.z = 0.0;
        let normal = normal.try_normalize(LEVEL)?;
        Some(Self { point_m: world_from_gripper.translation, normal, gripper: Vector3::new(1.0, -1.0, 1.0) })
    }

    fn position(&self, position_m: Vector3<f64>) -> Vector3<f64> {
        position_m - self.normal * (2.0 * self.normal.dot(&(position_m - self.point_m)))
    }

    pub(super) fn points(&self, points: &mut [[f32; 3]]) {
        for point in points {
            *point = self.position(Vector3::from(point.map(f64::from))).map(|value| value as f32).into();
        }
    }

    pub(super) fn pose(&self, pose: &mut SE3) {
        let reflection = Matrix3::identity() - 2.0 * self.normal * self.normal.transpose();
        let mirrored = reflection * pose.rotation.matrix() * Matrix3::from_diagonal(&self.gripper);
        // A product of two reflections and a rotation is a rotation, so this never fails.
        if let Ok(rotation) = SO3::from_matrix(&mirrored) {
            *pose = SE3::new(rotation, self.position(pose.translation));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use reseflow_lie::geodesic_distance;

    fn pose(angle: f64, position: [f64; 3]) -> SE3 {
        SE3::new(SO3::exp(&Vector3::new(angle, 0.3, -angle)), Vector3::from(position))
    }

    #[test]
    fn the_gripper_is_its_own_mirror_image() {
        let gripper = pose(0.8, [0.3, -0.2, 0.4]);
        let mut mirrored = gripper;
        Mirror::of_gripper(&gripper).pose(&mut mirrored);
        let apart = geodesic_distance(&gripper, &mirrored);
        assert!(apart.rotation_rad < 1e-12 && apart.translation_m < 1e-12, "{apart:?}");
    }

    #[test]
    fn an_upright_mirror_keeps_heights_and_a_gripper_that_closes_level() {
        let gripper = pose(0.8, [0.3, -0.2, 0.4]);
        let mirror = Mirror::upright(&gripper).unwrap();
        let point = Vector3::new(0.5, 0.1, -0.7);
        let seen = mirror.position(point);
        assert!((seen.z - point.z).abs() < 1e-12 && (seen - point).norm() > 0.1, "{seen}");
        let mut mirrored = gripper;
        mirror.pose(&mut mirrored);
        let tilt = |pose: &SE3| pose.rotation.act(&Vector3::z()).z;
        assert!((tilt(&mirrored) - tilt(&gripper)).abs() < 1e-12, "the approach is as steep as it was");
        assert!(geodesic_distance(&gripper, &mirrored).rotation_rad > 0.1, "this one closes aslant");
        let turned =
            |axis: Vector3<f64>, angle: f64| SE3::new(SO3::exp(&(axis * angle)), gripper.translation);
        // The fingers close along y, whatever the turn about it.
        let level = turned(Vector3::y(), 0.7);
        let mut kept = level;
        Mirror::upright(&level).unwrap().pose(&mut kept);
        let apart = geodesic_distance(&level, &kept);
        assert!(apart.rotation_rad < 1e-12 && apart.translation_m < 1e-12, "{apart:?}");
        let steep = turned(Vector3::x(), std::f64::consts::FRAC_PI_2);
        assert!(Mirror::upright(&steep).is_none(), "every upright plane is as near");
    }

    #[test]
    fn a_mirror_keeps_distances_turns_handedness_and_undoes_itself() {
        let mirror = Mirror::of_gripper(&pose(0.8, [0.3, -0.2, 0.4]));
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Vector3::from);
        let seen = corners.map(|corner| mirror.position(corner));
        for (i, j) in [(0, 1), (0, 2), (1, 3), (2, 3)] {
            assert!(((seen[i] - seen[j]).norm() - (corners[i] - corners[j]).norm()).abs() < 1e-12);
        }
        let volume = |c: &[Vector3<f64>; 4]| (c[1] - c[0]).cross(&(c[2] - c[0])).dot(&(c[3] - c[0]));
        assert!((volume(&seen) + volume(&corners)).abs() < 1e-12, "the handedness stayed");
        let before = pose(2.0, [0.5, 0.1, -0.7]);
        let mut after = before;
        mirror.pose(&mut after);
        // The gripper's x axis is reflected and turned about, its other axes are reflected.
        for (axis, sign) in [(Vector3::x(), -1.0), (Vector3::y(), 1.0), (Vector3::z(), 1.0)] {
            let tip = before.translation + before.rotation.act(&axis) * sign;
            let expected = mirror.position(tip) - mirror.position(before.translation);
            assert!((after.rotation.act(&axis) - expected).norm() < 1e-12);
        }
        assert!(geodesic_distance(&before, &after).rotation_rad > 0.1, "nothing was mirrored");
        mirror.pose(&mut after);
        let apart = geodesic_distance(&before, &after);
        assert!(apart.rotation_rad < 1e-12 && apart.translation_m < 1e-12, "{apart:?}");
    }
}
