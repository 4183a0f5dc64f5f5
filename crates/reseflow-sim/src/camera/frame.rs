//! One frame: what one or two views see of the world, masked, with the sensor's noise, cut down to N points.

use nalgebra::Vector3;
use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};
use reseflow_data::PointCloud;

use super::depth::{self, Hit, depth_image};
use super::rays::PixelRays;
use super::select::{self, Selection};
use super::{Camera, CameraSettings, is_salient};
use crate::world::{Role, World};

/// Colour noise of the sensor, levels of 255.
const COLOR_NOISE: i16 = 2;

/// A pixel that sees a surface.
#[derive(Clone, Copy)]
struct Sight<'a> {
    rays: &'a PixelRays,
    hit: Hit,
    color: [u8; 3],
}

impl Sight<'_> {
    /// Where the surface is that the pixel would see at `depth` along the view.
    fn point_at(&self, depth: f64) -> [f32; 3] {
        let point = self.rays.point_at(self.hit.column, self.hit.row, depth);
        [point.x as f32, point.y as f32, point.z as f32]
    }

    /// Adds one noisy measurement; says whether the crop kept it.
    fn measure<R: Rng>(&self, settings: &CameraSettings, rng: &mut R, cloud: &mut PointCloud) -> bool {
        let noise: f64 = StandardNormal.sample(rng);
        let point = self.point_at(f64::from(self.hit.depth) + noise * settings.depth_noise_m);
        let color = self.color.map(|level| {
            (i16::from(level) + rng.random_range(-COLOR_NOISE..=COLOR_NOISE)).clamp(0, 255) as u8
        });
        if f64::from(point[2]) < settings.crop_below_m {
            return false;
        }
        cloud.points.push(point);
        cloud.colors.push(color);
        true
    }
}

/// N points of what `camera`, and the second view where `settings` asks for one, see of `world`, with noise from `rng`.
pub(crate) fn observe<R: Rng>(
    camera: &Camera,
    settings: &CameraSettings,
    world: &World,
    points: usize,
    rng: &mut R,
) -> PointCloud {
    let second = settings.second_view_rad.map(|angle| camera.turned_about_table(angle));
    let views: Vec<(&Camera, PixelRays)> =
        std::iter::once(camera).chain(second.as_ref()).map(|view| (view, PixelRays::new(view))).collect();
    let mut sights: Vec<Sight> =
        views.iter().flat_map(|(view, rays)| sights(view, rays, settings, world)).collect();
    if settings.drop_fraction > 0.0 {
        sights.retain(|_| rng.random::<f64>() >= settings.drop_fraction);
    }

    let mut candidates = PointCloud::default();
    let mut salient = Vec::new();
    for sight in &sights {
        let kept = sight.measure(settings, rng, &mut candidates);
        if kept && candidates.colors.last().is_some_and(|&rgb| is_salient(rgb)) {
            salient.push(*sight);
        }
    }
    measure_again(&salient, points, settings, rng, &mut candidates);
    fill(&sights, points, settings, rng, &mut candidates);
    if candidates.is_empty() {
        // Nothing is in view: the view's far end stands in.
        let far = camera.world_from_camera.act(&Vector3::new(0.0, 0.0, depth::FAR_M));
        candidates.points.resize(points, [far.x as f32, far.y as f32, far.z as f32]);
        candidates.colors.resize(points, [0; 3]);
    }
    select::select(&candidates, points, settings.selection)
}

/// Every pixel of a view that sees something which is not masked.
fn sights<'a>(
    camera: &Camera,
    rays: &'a PixelRays,
    settings: &CameraSettings,
    world: &World,
) -> Vec<Sight<'a>> {
    // A crop above the table's top drops all of the table, whatever the noise: it need not be cast at.
    let wants_table = settings.crop_below_m <= 0.0;
    let parts: Vec<_> = world.parts().filter(|(part, _)| wants_table || part.role != Role::Table).collect();
    let surfaces: Vec<_> = parts.iter().map(|(part, pose)| (&part.surface, **pose)).collect();
    depth_image(camera, rays, &surfaces)
        .into_iter()
        .filter(|hit| !(settings.mask_gripper && parts[hit.index].0.role == Role::Gripper))
        .map(|hit| Sight { rays, hit, color: parts[hit.index].0.color })
        .collect()
}

/// A small salient patch is measured again until it has enough points: a second look at the same pixels.
fn measure_again<R: Rng>(
    salient: &[Sight],
    points: usize,
    settings: &CameraSettings,
    rng: &mut R,
    cloud: &mut PointCloud,
) {
    let wanted = select::salient_minimum(points);
    if settings.selection == Selection::Salient && salient.len() < wanted {
        for sight in salient.iter().cycle().take(wanted.saturating_sub(salient.len())) {
            sight.measure(settings, rng, cloud);
        }
    }
}

/// When fewer than N points are in view, the pixels are measured again.
fn fill<R: Rng>(
    sights: &[Sight],
    points: usize,
    settings: &CameraSettings,
    rng: &mut R,
    cloud: &mut PointCloud,
) {
    let seen = cloud.len();
    if seen > 0 && seen < points {
        // Bounded: a sight at the crop's edge may be cut off again and again.
        for sight in sights.iter().cycle().take(8 * points) {
            if cloud.len() >= points {
                break;
            }
            sight.measure(settings, rng, cloud);
        }
        for index in 0..points.saturating_sub(cloud.len()) {
            cloud.points.push(cloud.points[index % seen]);
            cloud.colors.push(cloud.colors[index % seen]);
        }
    }
}
