//! The rays of a pinhole camera: one through the middle of each pixel, as long as a depth of 1 along the view.

use glamx::{Pose3, Vec3};
use nalgebra::Vector3;

use super::Camera;
use crate::convert::vec3;

/// The rays of a camera.
///
/// A ray's direction is an affine function of its column and its row, in every frame: three vectors give all of them.
#[derive(Debug, Clone)]
pub(super) struct PixelRays {
    origin: Vector3<f64>,
    /// The camera's axes, world frame.
    axes: [Vector3<f64>; 3],
    /// Where the column's, and the row's, pixels lie on the image plane at depth 1.
    x: Vec<f64>,
    y: Vec<f64>,
}

impl PixelRays {
    pub(super) fn new(camera: &Camera) -> PixelRays {
        let along = |axis: usize| {
            let at = |pixel| (pixel as f64 + 0.5 - camera.center_px[axis]) / camera.focal_px;
            (0..camera.size_px[axis]).map(at).collect()
        };
        let pose = &camera.world_from_camera;
        let axes = [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| pose.rotation.act(&axis));
        PixelRays { origin: pose.translation, axes, x: along(0), y: along(1) }
    }

    /// The point that pixel (column, row) sees at a depth along the view, world frame, metres.
    pub(super) fn point_at(&self, column: usize, row: usize, depth_m: f64) -> Vector3<f64> {
        let [right, down, forward] = self.axes;
        self.origin + (right * self.x[column] + down * self.y[row] + forward) * depth_m
    }

    /// The rays in the frame of something that stands at `world_from_local`.
    pub(super) fn seen_from(&self, world_from_local: &Pose3) -> LocalRays<'_> {
        let local_from_world = world_from_local.inverse();
        let axes = self.axes.map(|axis| local_from_world.transform_vector(vec3(&axis)));
        LocalRays { rays: self, origin: local_from_world.transform_point(vec3(&self.origin)), axes }
    }
}

/// The rays of a camera in another frame.
#[derive(Debug)]
pub(super) struct LocalRays<'a> {
    rays: &'a PixelRays,
    /// Where all of them begin, metres.
    pub(super) origin: Vec3,
    axes: [Vec3; 3],
}

impl LocalRays<'_> {
    /// The directions of a row's rays, as a function of the column.
    pub(super) fn row(&self, row: usize) -> impl Fn(usize) -> Vec3 + '_ {
        let [right, down, forward] = self.axes;
        let middle = down * self.rays.y[row] as f32 + forward;
        move |column| right * self.rays.x[column] as f32 + middle
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::convert::vector3;

    #[test]
    fn rays_end_where_their_pixels_are_in_every_frame() {
        let camera = Camera::looking_at([0.5, 0.1, 0.6], [0.0, 0.0, 0.0], 0.8, [80, 60]);
        let rays = PixelRays::new(&camera);
        let pose = Pose3::new(Vec3::new(0.1, 0.05, 0.1), Vec3::new(0.3, 0.2, 0.9));
        let local = rays.seen_from(&pose);
        for (column, row) in [(0, 0), (79, 0), (31, 44), (79, 59)] {
            let point = rays.point_at(column, row, 0.7);
            // The definition of a pinhole camera: column = focal · x/z + centre.
            let in_camera = camera.world_from_camera.inverse().act(&point);
            let pixel = [0, 1]
                .map(|axis| camera.focal_px * in_camera[axis] / in_camera.z + camera.center_px[axis] - 0.5);
            assert!((pixel[0] - column as f64).abs() < 1e-9 && (pixel[1] - row as f64).abs() < 1e-9);
            assert!((in_camera.z - 0.7).abs() < 1e-12);
            let there = pose.transform_point(local.origin + local.row(row)(column) * 0.7);
            assert!((vector3(there) - point).norm() < 1e-6);
        }
    }
}
