//! Depth images by ray casts: for every pixel the nearest surface along its ray.
//!
//! Rays are cast at a convex piece only where its outline lies in the image; a depth buffer keeps the nearest hit, so the
//! result is that of casting every ray at everything.

use glamx::Pose3;
use parry3d::query::Ray;

use super::Camera;
use super::outline::rows_within;
use super::rays::PixelRays;
use super::surface::{Piece, Surface};
use crate::convert::vector3;

/// The camera sees nothing beyond this depth, metres.
pub(super) const FAR_M: f64 = 3.0;
/// Nor anything nearer than this.
const NEAR_M: f64 = 0.02;
/// A piece all of whose corners lie behind what a pixel sees, by at least this, is hidden there, metres.
const BEHIND_M: f64 = 1e-5;

/// One pixel's nearest surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Hit {
    pub(crate) column: usize,
    pub(crate) row: usize,
    /// Along the view, metres.
    pub(crate) depth: f32,
    /// Which surface.
    pub(crate) index: usize,
}

/// The nearest surface of each pixel that sees one, row by row.
pub(super) fn depth_image(camera: &Camera, rays: &PixelRays, surfaces: &[(&Surface, Pose3)]) -> Vec<Hit> {
    let [columns, rows] = camera.size_px;
    let mut nearest = vec![(FAR_M as f32, usize::MAX); columns * rows];
    for (index, (surface, world_from_surface)) in surfaces.iter().enumerate() {
        let local = rays.seen_from(world_from_surface);
        for piece in surface.pieces() {
            let (outline, front_m) = outline(camera, piece, world_from_surface);
            rows_within(&outline, camera.size_px, |row, covered| {
                let direction = local.row(row);
                for column in covered {
                    let seen = &mut nearest[row * columns + column];
                    if seen.0 <= front_m {
                        continue;
                    }
                    let ray = Ray::new(local.origin, direction(column));
                    if let Some(depth) = piece.cast(&ray, seen.0)
                        && depth < seen.0
                        && f64::from(depth) > NEAR_M
                    {
                        *seen = (depth, index);
                    }
                }
            });
        }
    }
    let hit = |(pixel, &(depth, index)): (usize, &(f32, usize))| {
        (index != usize::MAX).then_some(Hit { column: pixel % columns, row: pixel / columns, depth, index })
    };
    nearest.iter().enumerate().filter_map(hit).collect()
}

/// The images of a piece's corners, pixels, and a depth that nothing of it is before, metres.
///
/// A piece that reaches behind the camera has the whole image for its outline.
fn outline(camera: &Camera, piece: &Piece, world_from_piece: &Pose3) -> (Vec<[f64; 2]>, f32) {
    let camera_from_world = camera.world_from_camera.inverse();
    let mut corners = Vec::with_capacity(8);
    let mut front_m = f64::INFINITY;
    for corner in piece.corners() {
        let at = camera_from_world.act(&vector3(world_from_piece.transform_point(corner)));
        front_m = front_m.min(at.z);
        let pixel = |axis: usize| camera.focal_px * at[axis] / at.z + camera.center_px[axis];
        corners.push([pixel(0), pixel(1)]);
    }
    if front_m < NEAR_M {
        let [right, bottom] = camera.size_px.map(|count| count as f64);
        return (vec![[0.0, 0.0], [right, 0.0], [right, bottom], [0.0, bottom]], 0.0);
    }
    (corners, (front_m - BEHIND_M) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glamx::Vec3;
    use rand::RngExt;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use reseflow_data::Shape;

    use crate::mesh::prism;

    /// Every ray at every piece.
    fn plain(camera: &Camera, rays: &PixelRays, surfaces: &[(&Surface, Pose3)]) -> Vec<Hit> {
        let mut hits = Vec::new();
        for (row, column) in
            (0..camera.size_px[1]).flat_map(|row| (0..camera.size_px[0]).map(move |c| (row, c)))
        {
            let mut nearest: Option<Hit> = None;
            for (index, (surface, pose)) in surfaces.iter().enumerate() {
                let local = rays.seen_from(pose);
                let ray = Ray::new(local.origin, local.row(row)(column));
                for depth in surface.pieces().iter().filter_map(|piece| piece.cast(&ray, FAR_M as f32)) {
                    let in_range = f64::from(depth) > NEAR_M && f64::from(depth) < FAR_M;
                    if in_range && nearest.is_none_or(|hit| depth < hit.depth) {
                        nearest = Some(Hit { column, row, depth, index });
                    }
                }
            }
            hits.extend(nearest);
        }
        hits
    }

    #[test]
    fn the_image_is_that_of_casting_every_ray_at_everything() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let cube = Surface::new(&Shape::Box { half_extents_m: [0.05, 0.08, 0.03] }).unwrap();
        let plate = Surface::new(&Shape::Box { half_extents_m: [0.3, 0.3, 0.01] }).unwrap();
        let solid =
            Surface::new(&prism(&[[0.1, 0.0], [0.2, 0.1], [0.1, 0.2], [-0.1, 0.1]], -0.05, 0.1)).unwrap();
        let (mut hits, mut hidden) = (0, 0);
        for round in 0..12 {
            let camera = Camera::looking_at([0.5, 0.1, 0.6], [0.0, 0.0, 0.0], 0.8, [80, 60]);
            let rays = PixelRays::new(&camera);
            let mut pose = || {
                let mut vector = |half: f32| Vec3::from_array([0; 3].map(|_| rng.random_range(-half..=half)));
                Pose3::new(vector(0.2), vector(3.0))
            };
            let mut surfaces = vec![(&cube, pose()), (&solid, pose()), (&plate, pose()), (&cube, pose())];
            if round % 3 == 0 {
                // A plate that the camera stands in: it reaches behind the view and hides nothing.
                surfaces.push((&plate, Pose3::from_translation(Vec3::new(0.4, 0.1, 0.58))));
            }
            let image = depth_image(&camera, &rays, &surfaces);
            assert_eq!(image, plain(&camera, &rays, &surfaces), "round {round}");
            let alone: usize =
                surfaces.iter().map(|&surface| depth_image(&camera, &rays, &[surface]).len()).sum();
            hits += image.len();
            hidden += alone - image.len();
        }
        assert!(hits > 5000 && hidden > 1000, "{hits} hits, {hidden} hidden ones");
    }
}
