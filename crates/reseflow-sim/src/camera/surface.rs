//! What the camera casts rays at: a shape as convex pieces, each with the corners that bound its outline.

use glamx::Vec3;
use parry3d::query::{Ray, RayCast};
use parry3d::shape::{Cuboid, Triangle};
use reseflow_data::Shape;

use crate::convert::point3;

/// A convex piece of a surface.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Piece {
    /// A box about the origin.
    Box(Cuboid),
    /// A triangle, seen from either side.
    Triangle(Triangle),
}

/// The surface of a shape, in the shape's frame.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Surface {
    pieces: Vec<Piece>,
}

impl Surface {
    /// The surface of `shape`; `None` for a mesh without triangles.
    ///
    /// A triangle whose indices name no vertex is left out.
    pub(crate) fn new(shape: &Shape) -> Option<Surface> {
        let pieces: Vec<Piece> = match shape {
            Shape::Box { half_extents_m } => vec![Piece::Box(Cuboid::new(point3(half_extents_m)))],
            Shape::Mesh { vertices_m, triangles } => {
                let corner = |&index: &u32| vertices_m.get(index as usize).map(point3);
                let triangle = |[a, b, c]: &[u32; 3]| {
                    Some(Piece::Triangle(Triangle::new(corner(a)?, corner(b)?, corner(c)?)))
                };
                triangles.iter().filter_map(triangle).collect()
            }
        };
        (!pieces.is_empty()).then_some(Surface { pieces })
    }

    pub(super) fn pieces(&self) -> &[Piece] {
        &self.pieces
    }
}

impl Piece {
    /// The corners of its convex hull, metres.
    pub(super) fn corners(&self) -> impl Iterator<Item = Vec3> + '_ {
        let count = match self {
            Piece::Box(_) => 8,
            Piece::Triangle(_) => 3,
        };
        (0..count).map(move |index| match self {
            Piece::Box(cuboid) => {
                let sign = |axis: usize| if index >> axis & 1 == 0 { -1.0 } else { 1.0 };
                cuboid.half_extents * Vec3::new(sign(0), sign(1), sign(2))
            }
            Piece::Triangle(triangle) => triangle.vertices()[index],
        })
    }

    /// How far along a ray, in its direction's lengths, the piece is hit; at most `limit`.
    pub(super) fn cast(&self, ray: &Ray, limit: f32) -> Option<f32> {
        match self {
            Piece::Box(cuboid) => cuboid.cast_local_ray(ray, limit, true),
            Piece::Triangle(triangle) => triangle.cast_local_ray(ray, limit, true),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{prism, ray_shape};

    #[test]
    fn pieces_are_hit_where_the_engines_own_shapes_are() {
        let cube = Shape::Box { half_extents_m: [0.05, 0.08, 0.03] };
        for shape in [cube, prism(&[[0.1, 0.0], [0.3, 0.1], [0.2, 0.4], [0.0, 0.2]], -0.1, 0.2)] {
            let (surface, engine) = (Surface::new(&shape).unwrap(), ray_shape(&shape).unwrap());
            let mut hits = 0;
            for index in 0..900_u16 {
                let (a, b) = (f32::from(index % 30) / 60.0 - 0.25, f32::from(index / 30) / 60.0 - 0.25);
                let ray = Ray::new(Vec3::new(0.9, 0.8, 1.1), Vec3::new(a - 0.9, b - 0.8, -1.0));
                let nearest = surface.pieces().iter().filter_map(|piece| piece.cast(&ray, 9.0));
                let nearest = nearest.fold(f32::INFINITY, f32::min);
                let expected = engine.cast_local_ray(&ray, 9.0, true).unwrap_or(f32::INFINITY);
                assert!(nearest == expected || (nearest - expected).abs() < 1e-6, "{nearest}, {expected}");
                hits += usize::from(nearest.is_finite());
            }
            assert!((20..880).contains(&hits), "{hits} hits show nothing");
        }
    }

    #[test]
    fn a_mesh_without_triangles_has_no_surface() {
        let empty = Shape::Mesh { vertices_m: vec![[0.0; 3]], triangles: Vec::new() };
        assert!(Surface::new(&empty).is_none());
    }
}
