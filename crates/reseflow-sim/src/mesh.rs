//! Meshes of simple solids, for drawing and for ray casts.

use reseflow_data::Shape;

use glamx::Vec3;
use parry3d::shape::SharedShape;

use crate::convert::point3;

/// The upright prism over a convex polygon.
///
/// `polygon` holds the corners in the xy plane, metres, counter-clockwise seen from +z.
pub(crate) fn prism(polygon: &[[f64; 2]], bottom_m: f64, top_m: f64) -> Shape {
    let count = polygon.len() as u32;
    let at = |z: f64| polygon.iter().map(move |&[x, y]| [x, y, z]);
    let vertices_m = at(bottom_m).chain(at(top_m)).collect();
    let mut triangles = Vec::new();
    for i in 1..count.saturating_sub(1) {
        triangles.push([0, i + 1, i]);
        triangles.push([count, count + i, count + i + 1]);
    }
    for i in 0..count {
        let next = (i + 1) % count;
        triangles.push([i, next, count + next]);
        triangles.push([i, count + next, count + i]);
    }
    Shape::Mesh { vertices_m, triangles }
}

/// The shape that rays are cast at; `None` for a mesh without triangles.
pub(crate) fn ray_shape(shape: &Shape) -> Option<SharedShape> {
    match shape {
        Shape::Box { half_extents_m: [x, y, z] } => {
            Some(SharedShape::cuboid(*x as f32, *y as f32, *z as f32))
        }
        Shape::Mesh { vertices_m, triangles } => {
            let vertices: Vec<Vec3> = vertices_m.iter().map(point3).collect();
            SharedShape::trimesh(vertices, triangles.clone()).ok()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn a_prism_has_the_volume_of_base_times_height() {
        // The divergence theorem over a closed, outward-oriented surface: V = Σ a·(b × c) / 6.
        let polygon = [[0.1, 0.0], [0.3, 0.1], [0.2, 0.4], [0.0, 0.2]];
        let area = (0..4).map(|i| {
            let ([x0, y0], [x1, y1]) = (polygon[i], polygon[(i + 1) % 4]);
            0.5 * (x0 * y1 - x1 * y0)
        });
        let Shape::Mesh { vertices_m, triangles } = prism(&polygon, -0.1, 0.2) else { unreachable!() };
        let vertex = |i: u32| Vector3::from(vertices_m[i as usize]);
        let volume: f64 =
            triangles.iter().map(|&[a, b, c]| vertex(a).dot(&vertex(b).cross(&vertex(c))) / 6.0).sum();
        assert!((volume - area.sum::<f64>() * 0.3).abs() < 1e-12);
    }
}
