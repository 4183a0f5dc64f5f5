//! Pictures of a scene by ray casts: enough shading to see what is going on.

use glamx::{Pose3, Vec3};
use nalgebra::Vector3;
use parry3d::query::Ray;
use parry3d::shape::SharedShape;
use reseflow_data::{SceneBody, Shape};

use crate::camera::Camera;
use crate::convert::{pose_from_se3, vec3};
use crate::mesh::ray_shape;

/// Where the light comes from.
const TO_LIGHT: Vec3 = Vec3::new(0.45, -0.35, 0.82);
const AMBIENT: f32 = 0.45;
/// How much light a shadow leaves of the direct light.
const SHADOW: f32 = 0.35;
/// Rays per pixel along each axis where edges would be jagged.
const SAMPLES: usize = 3;
/// Pixels whose colours differ by more than this, of 1, lie at an edge.
const EDGE_CONTRAST: f32 = 0.02;

/// A picture, row by row from the top left, three bytes a pixel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RgbPicture {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// sRGB, `3 * width * height` bytes.
    pub pixels: Vec<u8>,
}

/// Full angle of view of pictures, from top to bottom.
const PICTURE_VIEW_RAD: f64 = 0.62;
/// From what is looked at to the eye of pictures: from the front, a little aside, above.
const TO_EYE: [f64; 3] = [0.73, 0.37, 0.58];
/// What is drawn keeps this share of the half picture free at each edge.
const PICTURE_MARGIN: f64 = 0.06;

/// The viewpoint for pictures: beside the table, as near as lets all of `bodies` but the table be seen.
///
/// Given the bodies of several moments, one viewpoint fits them all.
pub fn overview_camera<'a>(
    bodies: impl IntoIterator<Item = &'a SceneBody>,
    width: usize,
    height: usize,
) -> Camera {
    let shown = bodies.into_iter().filter(|body| body.name != "table");
    let corners: Vec<Vector3<f64>> = shown.flat_map(corners).collect();
    let fold = |start: f64, choose: fn(f64, f64) -> f64| {
        corners.iter().fold(Vector3::repeat(start), |bound, corner| bound.zip_map(corner, choose))
    };
    let (low, high) = (fold(f64::INFINITY, f64::min), fold(f64::NEG_INFINITY, f64::max));
    let target = if corners.is_empty() { Vector3::zeros() } else { (low + high) * 0.5 };
    let to_eye = Vector3::from(TO_EYE).normalize();
    let facing =
        Camera::looking_at((target + to_eye).into(), target.into(), PICTURE_VIEW_RAD, [width, height]);
    let half_view = (0.5 * PICTURE_VIEW_RAD).tan() * (1.0 - PICTURE_MARGIN);
    let wide = half_view * width as f64 / height as f64;
    let camera_from_world = facing.world_from_camera.inverse();
    // A corner at (x, y) off the axis and z behind the target is seen from a distance d when |x| ≤ (d + z) tan.
    let needed = |corner: &Vector3<f64>| {
        let at = camera_from_world.act(corner);
        (at.x.abs() / wide).max(at.y.abs() / half_view) - (at.z - 1.0)
    };
    let distance = corners.iter().map(needed).fold(0.5, f64::max);
    let eye = target + to_eye * distance;
    Camera::looking_at(eye.into(), target.into(), PICTURE_VIEW_RAD, [width, height])
}

/// The corners of a body, world frame.
fn corners(body: &SceneBody) -> Vec<Vector3<f64>> {
    let local: Vec<[f64; 3]> = match &body.shape {
        Shape::Box { half_extents_m: [x, y, z] } => (0..8)
            .map(|corner| {
                let sign = |axis: usize| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 };
                [sign(0) * x, sign(1) * y, sign(2) * z]
            })
            .collect(),
        Shape::Mesh { vertices_m, .. } => vertices_m.clone(),
    };
    local.into_iter().map(|point| body.world_from_body.act(&Vector3::from(point))).collect()
}

struct Drawn {
    world_from_shape: Pose3,
    shape: SharedShape,
    color: Vec3,
    center: Vec3,
    radius: f32,
}

/// Draws `bodies` as `camera` sees them, the picture as large as the camera's image.
pub fn render(bodies: &[SceneBody], camera: &Camera) -> RgbPicture {
    let drawn: Vec<Drawn> = bodies
        .iter()
        .filter_map(|body| {
            let world_from_shape = pose_from_se3(&body.world_from_body);
            let shape = ray_shape(&body.shape)?;
            let sphere = shape.compute_bounding_sphere(&world_from_shape);
            let color = Vec3::from_array(body.color.map(|level| f32::from(level) / 255.0));
            Some(Drawn { world_from_shape, shape, color, center: sphere.center, radius: sphere.radius })
        })
        .collect();
    let [width, height] = camera.size_px;
    // One ray through each pixel's middle; more where the next pixels look different: that is where edges are jagged.
    let middle =
        |pixel: usize| shade(&drawn, camera, (pixel % width) as f64 + 0.5, (pixel / width) as f64 + 0.5);
    let coarse: Vec<Vec3> = (0..width * height).map(middle).collect();
    let differs = |a: usize, b: usize| (coarse[a] - coarse[b]).abs().max_element() > EDGE_CONTRAST;
    let mut pixels = Vec::with_capacity(3 * width * height);
    for (pixel, &single) in coarse.iter().enumerate() {
        let (column, row) = (pixel % width, pixel / width);
        let on_edge = (column > 0 && differs(pixel, pixel - 1))
            || (column + 1 < width && differs(pixel, pixel + 1))
            || (row > 0 && differs(pixel, pixel - width))
            || (row + 1 < height && differs(pixel, pixel + width));
        let color = if on_edge { supersample(&drawn, camera, column, row) } else { single };
        pixels.extend(color.to_array().map(|level| (level.clamp(0.0, 1.0) * 255.0).round() as u8));
    }
    RgbPicture { width, height, pixels }
}

/// The mean colour of several rays through one pixel.
fn supersample(drawn: &[Drawn], camera: &Camera, column: usize, row: usize) -> Vec3 {
    let mut sum = Vec3::ZERO;
    for sample in 0..SAMPLES * SAMPLES {
        let offset = |index: usize| (index as f64 + 0.5) / SAMPLES as f64;
        let (x, y) = (column as f64 + offset(sample % SAMPLES), row as f64 + offset(sample / SAMPLES));
        sum += shade(drawn, camera, x, y);
    }
    sum / (SAMPLES * SAMPLES) as f32
}

/// The colour at image coordinates (x, y).
fn shade(drawn: &[Drawn], camera: &Camera, x: f64, y: f64) -> Vec3 {
    let [cx, cy] = camera.center_px;
    let in_camera = Vector3::new((x - cx) / camera.focal_px, (y - cy) / camera.focal_px, 1.0).normalize();
    let direction = vec3(&camera.world_from_camera.rotation.act(&in_camera));
    let ray = Ray::new(vec3(&camera.world_from_camera.translation), direction);
    let Some((distance, index, normal)) = nearest(drawn, &ray) else {
        // A light backdrop, a little darker upwards.
        return Vec3::new(0.93, 0.945, 0.96) * (1.0 - 0.12 * (1.0 - y as f32 / camera.size_px[1] as f32));
    };
    let normal = if normal.dot(direction) > 0.0 { -normal } else { normal };
    let light = TO_LIGHT.normalize();
    let lambert = normal.dot(light).max(0.0);
    let surface = ray.point_at(distance) + normal * 2e-4;
    let shadowed = lambert > 0.0 && nearest(drawn, &Ray::new(surface, light)).is_some();
    let direct = if shadowed { SHADOW * lambert } else { lambert };
    drawn[index].color * (AMBIENT + 0.65 * direct)
}

/// The nearest surface along a ray: distance, index, normal.
fn nearest(drawn: &[Drawn], ray: &Ray) -> Option<(f32, usize, Vec3)> {
    let mut best: Option<(f32, usize, Vec3)> = None;
    for (index, body) in drawn.iter().enumerate() {
        let to_center = body.center - ray.origin;
        let along = to_center.dot(ray.dir);
        let off_axis = to_center.length_squared() - along * along;
        if off_axis > body.radius * body.radius {
            continue;
        }
        let limit = best.map_or(f32::MAX, |(distance, ..)| distance);
        if let Some(hit) = body.shape.cast_ray_and_get_normal(&body.world_from_shape, ray, limit, true)
            && hit.time_of_impact < limit
        {
            best = Some((hit.time_of_impact, index, hit.normal));
        }
    }
    best
}
