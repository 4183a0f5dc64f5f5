//! Depth images by ray casts: for every pixel the nearest surface along its ray.
//!
//! Rays are cast only where a shape's bounding sphere can be seen; a depth buffer keeps the nearest hit, so the result
//! is that of casting every ray at every shape.

use glamx::{Pose3, Vec3};
use nalgebra::Vector3;
use parry3d::query::Ray;
use parry3d::shape::Shape;

use super::Camera;
use crate::convert::vec3;

/// The camera sees nothing beyond this depth, metres.
pub(super) const FAR_M: f64 = 3.0;
/// Nor anything nearer than this.
const NEAR_M: f64 = 0.02;

/// One pixel's nearest surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Hit {
    pub(crate) column: usize,
    pub(crate) row: usize,
    /// Along the view, metres.
    pub(crate) depth: f32,
    /// Which shape.
    pub(crate) index: usize,
}

/// The nearest surface of each pixel that sees one, row by row.
pub(super) fn depth_image(camera: &Camera, shapes: &[(&dyn Shape, Pose3)]) -> Vec<Hit> {
    let [columns, rows] = camera.size_px;
    let mut nearest = vec![(f32::INFINITY, usize::MAX); columns * rows];
    for (index, (shape, world_from_shape)) in shapes.iter().enumerate() {
        let sphere = shape.compute_bounding_sphere(world_from_shape);
        let Some([left, right, top, bottom]) = pixels_around(camera, sphere.center, sphere.radius) else {
            continue;
        };
        let shape_from_world = world_from_shape.inverse();
        let origin = shape_from_world.transform_point(vec3(&camera.world_from_camera.translation));
        for row in top..bottom {
            for column in left..right {
                let ray_in_camera = Vector3::from(camera.ray(column, row));
                let direction = vec3(&camera.world_from_camera.rotation.act(&ray_in_camera));
                let ray = Ray::new(origin, shape_from_world.transform_vector(direction));
                let limit = nearest[row * columns + column].0.min(FAR_M as f32);
                if let Some(depth) = shape.cast_local_ray(&ray, limit, true)
                    && depth < limit
                    && f64::from(depth) > NEAR_M
                {
                    nearest[row * columns + column] = (depth, index);
                }
            }
        }
    }
    let hit = |(pixel, &(depth, index)): (usize, &(f32, usize))| {
        (index != usize::MAX).then_some(Hit { column: pixel % columns, row: pixel / columns, depth, index })
    };
    nearest.iter().enumerate().filter_map(hit).collect()
}

/// The half-open ranges of columns and rows that a sphere can cover: left, right, top, bottom. `None`: it is out of view.
fn pixels_around(camera: &Camera, center: Vec3, radius: f32) -> Option<[usize; 4]> {
    let [columns, rows] = camera.size_px;
    let center = camera.world_from_camera.inverse().act(&crate::convert::vector3(center));
    let radius = f64::from(radius);
    if center.z + radius < NEAR_M {
        return None;
    }
    let front = center.z - radius;
    if front < NEAR_M {
        return Some([0, columns, 0, rows]);
    }
    // The extreme directions of the sphere's bounding cube: an outer bound on those of the sphere.
    let range = |middle: f64, principal: f64, count: usize| {
        let low = ((middle - radius) / front).min((middle - radius) / (center.z + radius));
        let high = ((middle + radius) / front).max((middle + radius) / (center.z + radius));
        let first = (principal + camera.focal_px * low).floor().clamp(0.0, count as f64) as usize;
        let end = (principal + camera.focal_px * high).ceil().clamp(0.0, count as f64) as usize;
        (first < end).then_some((first, end))
    };
    let (left, right) = range(center.x, camera.center_px[0], columns)?;
    let (top, bottom) = range(center.y, camera.center_px[1], rows)?;
    Some([left, right, top, bottom])
}

#[cfg(test)]
mod tests {
    use super::*;
    use parry3d::shape::Cuboid;

    fn camera() -> Camera {
        Camera::looking_at([0.5, 0.1, 0.6], [0.0, 0.0, 0.0], 0.8, [80, 60])
    }

    #[test]
    fn culling_changes_nothing() {
        let camera = camera();
        let cube = Cuboid::new(Vec3::new(0.05, 0.08, 0.03));
        let plate = Cuboid::new(Vec3::new(0.3, 0.3, 0.01));
        let poses = [
            Pose3::new(Vec3::new(0.1, 0.05, 0.1), Vec3::new(0.3, 0.2, 0.9)),
            Pose3::from_translation(Vec3::new(-0.1, 0.0, 0.0)),
        ];
        let shapes: [(&dyn Shape, Pose3); 2] = [(&cube, poses[0]), (&plate, poses[1])];
        let mut plain = Vec::new();
        for row in 0..60 {
            for column in 0..80 {
                let direction =
                    camera.world_from_camera.rotation.act(&Vector3::from(camera.ray(column, row)));
                let ray = Ray::new(vec3(&camera.world_from_camera.translation), vec3(&direction));
                let depths = shapes.map(|(shape, pose)| shape.cast_ray(&pose, &ray, FAR_M as f32, true));
                let index = match depths {
                    [Some(a), Some(b)] => usize::from(b < a),
                    [Some(_), None] => 0,
                    [None, Some(_)] => 1,
                    [None, None] => continue,
                };
                plain.push((column, row, index, depths[index].unwrap()));
            }
        }
        let culled = depth_image(&camera, &shapes);
        assert!(plain.len() > 500, "the shapes are hardly in view: {}", plain.len());
        assert_eq!(culled.len(), plain.len());
        for (hit, (column, row, index, depth)) in culled.iter().zip(plain) {
            assert_eq!((hit.column, hit.row, hit.index), (column, row, index));
            assert!((hit.depth - depth).abs() < 1e-5);
        }
    }
}
