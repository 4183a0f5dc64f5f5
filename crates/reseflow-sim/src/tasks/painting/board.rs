//! The board: where it stands, what it is made of, and what is printed on it.
//!
//! The board's frame has its origin in the middle of the painted face, x to the right of somebody who looks at it, y up the
//! slope and z out of it.

use nalgebra::{Matrix3, Vector3};
use rapier3d::prelude::{CoefficientCombineRule, Collider, ColliderBuilder};
use reseflow_data::Shape;
use reseflow_lie::{SE3, SO3};

use super::stroke::Place;
use crate::convert::vec3;

/// Half of the edge of a square board of nominal size, metres.
pub(super) const NOMINAL_HALF_M: f64 = 0.16;
/// How far the middle of the lower edge of the face is above the table, metres.
const LOWER_EDGE_M: f64 = 0.03;
const THICKNESS_M: f64 = 0.02;
const BOARD_MASS_KG: f32 = 1.0;
const STAND_MASS_KG: f32 = 3.0;
/// The mass of the board on its stand, kilograms.
pub(super) const MASS_KG: f64 = (BOARD_MASS_KG + STAND_MASS_KG) as f64;
const FRICTION: f32 = 0.4;

/// Where a board lies whose face looks `yaw_rad` to the left of the world's x axis and is tilted by `tilt_rad` from level.
pub(super) fn world_from_board(center_m: [f64; 2], yaw_rad: f64, tilt_rad: f64, half_m: f64) -> SE3 {
    let (sin, cos) = tilt_rad.sin_cos();
    let right = Vector3::y();
    let up_slope = Vector3::new(-cos, 0.0, sin);
    let normal = Vector3::new(sin, 0.0, cos);
    // Columns orthonormal by construction.
    let tilted = SO3::from_matrix(&Matrix3::from_columns(&[right, up_slope, normal]))
        .unwrap_or_else(|_| SO3::identity());
    let height = LOWER_EDGE_M + half_m * sin;
    SE3::new(SO3::exp(&(Vector3::z() * yaw_rad)) * tilted, Vector3::new(center_m[0], center_m[1], height))
}

/// The corners of the stand in the board's frame: under the board, and below them on the table, metres.
pub(super) fn stand_corners(world_from_board: &SE3, half_m: f64) -> [Vector3<f64>; 8] {
    let corner = |index: usize| {
        let [x, y] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]][index % 4];
        let under = Vector3::new(x * half_m, y * half_m, -THICKNESS_M);
        if index < 4 {
            return under;
        }
        let mut on_table = world_from_board.act(&under);
        on_table.z = 0.0;
        world_from_board.inverse().act(&on_table)
    };
    std::array::from_fn(corner)
}

/// The board's and the stand's colliders; `None` for a board without size.
pub(super) fn colliders(corners: &[Vector3<f64>; 8], half_m: f64) -> Option<Vec<Collider>> {
    let [half, half_thickness] = [half_m as f32, 0.5 * THICKNESS_M as f32];
    let hull: Vec<_> = corners.iter().map(vec3).collect();
    let surface = |collider: ColliderBuilder, mass: f32| {
        collider.mass(mass).friction(FRICTION).friction_combine_rule(CoefficientCombineRule::Max).build()
    };
    let board = ColliderBuilder::cuboid(half, half, half_thickness).translation(vec3(&Vector3::new(
        0.0,
        0.0,
        -0.5 * THICKNESS_M,
    )));
    let stand = ColliderBuilder::convex_hull(&hull)?;
    (half_m > 0.0).then(|| vec![surface(board, BOARD_MASS_KG), surface(stand, STAND_MASS_KG)])
}

/// The board as it is drawn: a slab under the face.
pub(super) fn board_shape(half_m: f64) -> (Shape, Vector3<f64>) {
    let shape = Shape::Box { half_extents_m: [half_m, half_m, 0.5 * THICKNESS_M] };
    (shape, Vector3::new(0.0, 0.0, -0.5 * THICKNESS_M))
}

/// The stand as it is drawn.
pub(super) fn stand_shape(corners: &[Vector3<f64>; 8]) -> Shape {
    let quads = [[0, 1, 2, 3], [7, 6, 5, 4], [1, 0, 4, 5], [2, 1, 5, 6], [3, 2, 6, 7], [0, 3, 7, 4]];
    Shape::Mesh {
        vertices_m: corners.iter().map(|corner| [corner.x, corner.y, corner.z]).collect(),
        triangles: quads.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
    }
}

/// A ribbon along `places`, `width_m` wide, `height_m` over the face.
pub(super) fn ribbon(places: &[Place], width_m: f64, height_m: f64) -> Shape {
    let mut vertices_m = Vec::with_capacity(2 * places.len());
    for place in places {
        let (sin, cos) = place.heading_rad.sin_cos();
        let [x, y] = place.point_m;
        for side in [0.5 * width_m, -0.5 * width_m] {
            vertices_m.push([x - side * sin, y + side * cos, height_m]);
        }
    }
    let pairs = 0..places.len().saturating_sub(1) as u32;
    let triangles = pairs.flat_map(|i| {
        let [left, right, next_left, next_right] = [2 * i, 2 * i + 1, 2 * i + 2, 2 * i + 3];
        [[left, right, next_right], [left, next_right, next_left]]
    });
    Shape::Mesh { triangles: triangles.collect(), vertices_m }
}

/// Regular polygons of `sides` corners about `centers`, `height_m` over the face, as one mesh.
pub(super) fn discs(centers: &[[f64; 2]], radius_m: f64, sides: u32, height_m: f64) -> Shape {
    let mut vertices_m = Vec::new();
    let mut triangles = Vec::new();
    for &[x, y] in centers {
        let first = vertices_m.len() as u32;
        for corner in 0..sides {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(corner) / f64::from(sides)).sin_cos();
            vertices_m.push([x + radius_m * cos, y + radius_m * sin, height_m]);
        }
        triangles.extend((1..sides - 1).map(|corner| [first, first + corner, first + corner + 1]));
    }
    Shape::Mesh { vertices_m, triangles }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_board_looks_to_the_front_and_its_lower_edge_has_its_height() {
        let pose = world_from_board([0.1, -0.05], 0.4, 0.7, 0.16);
        let normal = pose.rotation.act(&Vector3::z());
        assert!((normal.z - 0.7_f64.cos()).abs() < 1e-12);
        assert!((normal.y.atan2(normal.x) - 0.4).abs() < 1e-12);
        assert!(pose.rotation.act(&Vector3::y()).z > 0.0);
        let edge = pose.act(&Vector3::new(0.03, -0.16, 0.0));
        assert!((edge.z - LOWER_EDGE_M).abs() < 1e-12);
        let feet = stand_corners(&pose, 0.16);
        assert!(feet[4..].iter().all(|foot| pose.act(foot).z.abs() < 1e-12));
    }

    #[test]
    fn a_ribbon_covers_its_length_times_its_width() {
        let places: Vec<Place> = (0..=40)
            .map(|i| {
                let angle = f64::from(i) * 0.05;
                Place {
                    point_m: [0.1 * angle.cos(), 0.1 * angle.sin()],
                    heading_rad: angle + 0.5 * std::f64::consts::PI,
                }
            })
            .collect();
        let Shape::Mesh { vertices_m, triangles } = ribbon(&places, 0.01, 0.0) else { unreachable!() };
        let area = |[a, b, c]: [u32; 3]| {
            let [a, b, c] = [a, b, c].map(|i| Vector3::from(vertices_m[i as usize]));
            let cross = (b - a).cross(&(c - a));
            assert!(cross.z > 0.0, "counter-clockwise seen from outside");
            0.5 * cross.norm()
        };
        let total: f64 = triangles.iter().map(|&triangle| area(triangle)).sum();
        assert!((total - 0.1 * 2.0 * 0.01).abs() < 2e-6, "{total}");
    }
}
