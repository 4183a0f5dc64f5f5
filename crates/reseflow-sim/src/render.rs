//! Pictures of a scene by ray casts: enough shading to see what is going on.

use glamx::{Pose3, Vec3};
use nalgebra::Vector3;
use parry3d::query::Ray;
use parry3d::shape::SharedShape;
use reseflow_data::SceneBody;

use crate::camera::Camera;
use crate::convert::{pose_from_se3, vec3};
use crate::mesh::ray_shape;

/// Where the light comes from.
const TO_LIGHT: Vec3 = Vec3::new(0.45, -0.35, 0.82);
const AMBIENT: f32 = 0.45;
/// How much light a shadow leaves of the direct light.
const SHADOW: f32 = 0.35;
/// Rays per pixel along each axis, against jagged edges.
const SAMPLES: usize = 2;

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

/// The viewpoint for pictures: beside the table, looking down at its middle.
pub fn overview_camera(width: usize, height: usize) -> Camera {
    Camera::looking_at([0.52, 0.27, 0.55], [-0.05, -0.02, 0.11], 0.72, [width, height])
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
    let mut pixels = Vec::with_capacity(3 * width * height);
    for row in 0..height {
        for column in 0..width {
            let mut sum = Vec3::ZERO;
            for sample in 0..SAMPLES * SAMPLES {
                let offset = |index: usize| (index as f64 + 0.5) / SAMPLES as f64;
                let x = column as f64 + offset(sample % SAMPLES);
                let y = row as f64 + offset(sample / SAMPLES);
                sum += shade(&drawn, camera, x, y);
            }
            let mean = sum / (SAMPLES * SAMPLES) as f32;
            pixels.extend(mean.to_array().map(|level| (level.clamp(0.0, 1.0) * 255.0).round() as u8));
        }
    }
    RgbPicture { width, height, pixels }
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
