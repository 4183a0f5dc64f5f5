//! A depth camera over the table: a pinhole model that casts rays, so hidden surfaces stay hidden.
//!
//! A frame is made in three steps: a depth image of each view ([`depth`]), masks and noise ([`frame`]), and the choice of
//! N points by their visible colour ([`select`]). Colours are those of the surfaces without shading, with sensor noise: light is
//! no part of the tasks.

mod depth;
mod farthest;
mod frame;
mod outline;
mod rays;
mod select;
mod settings;
mod surface;

use nalgebra::{Matrix3, Vector3};
use rand::{Rng, RngExt};
use reseflow_lie::{SE3, SO3};

use crate::color::saturation_and_value;

pub(crate) use frame::observe;
pub use select::Selection;
pub use settings::CameraSettings;
pub(crate) use surface::Surface;

/// Where colours count as salient: printed marks stand out, wood, metal and the table do not.
const SALIENT_SATURATION: f64 = 0.55;
const SALIENT_VALUE: f64 = 0.35;

/// Whether a colour stands out: well saturated and not dark.
pub fn is_salient(rgb: [u8; 3]) -> bool {
    let (saturation, value) = saturation_and_value(rgb);
    saturation >= SALIENT_SATURATION && value >= SALIENT_VALUE
}

/// A pinhole camera. Its frame has z along the view, x to the right and y down in the image.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    /// Where the camera is.
    pub world_from_camera: SE3,
    /// Focal length, pixels.
    pub focal_px: f64,
    /// Principal point (column, row), pixels.
    pub center_px: [f64; 2],
    /// Columns and rows.
    pub size_px: [usize; 2],
}

/// How far viewpoints scatter about the nominal one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ViewSpread {
    pub(crate) azimuth_rad: [f64; 2],
    pub(crate) elevation_rad: f64,
    pub(crate) distance_m: f64,
}

impl Camera {
    /// A camera at `eye` that looks at `target`, with +z of the world up in the image, metres.
    ///
    /// `vertical_view_rad` is the full angle of view from the top to the bottom row.
    pub fn looking_at(
        eye: [f64; 3],
        target: [f64; 3],
        vertical_view_rad: f64,
        size_px: [usize; 2],
    ) -> Camera {
        let forward = (Vector3::from(target) - Vector3::from(eye)).normalize();
        let level = forward.cross(&Vector3::z());
        // Looking straight down, "up in the image" is undefined; then it is the world's y.
        let right = if level.norm() > 1e-9 { level.normalize() } else { Vector3::x() };
        let down = forward.cross(&right);
        let rotation = SO3::from_matrix(&Matrix3::from_columns(&[right, down, forward]))
            .unwrap_or_else(|_| SO3::identity());
        let [columns, rows] = size_px.map(|count| count as f64);
        Camera {
            world_from_camera: SE3::new(rotation, Vector3::from(eye)),
            focal_px: 0.5 * rows / (0.5 * vertical_view_rad).tan(),
            center_px: [0.5 * columns, 0.5 * rows],
            size_px,
        }
    }

    /// A camera of the tasks: 320 × 240 pixels, about 0.85 m away, looking down at the table's middle by about 50°.
    pub(crate) fn draw<R: Rng>(spread: &ViewSpread, rng: &mut R) -> Camera {
        let mut within = |half: f64| rng.random_range(-1.0..=1.0) * half;
        let side = within(1.0).signum();
        let azimuth_size = 0.5 * (spread.azimuth_rad[0] + spread.azimuth_rad[1])
            + within(0.5 * (spread.azimuth_rad[1] - spread.azimuth_rad[0]));
        let azimuth = side * azimuth_size;
        let elevation = 50.0_f64.to_radians() + within(spread.elevation_rad);
        let distance = 0.85 + within(spread.distance_m);
        let eye = [
            distance * elevation.cos() * azimuth.cos(),
            distance * elevation.cos() * azimuth.sin(),
            distance * elevation.sin(),
        ];
        let target = [within(0.01), within(0.01), within(0.01)];
        let mut camera = Camera::looking_at(eye, target, 44.0_f64.to_radians(), [320, 240]);
        camera.focal_px *= 1.0 + within(0.03);
        camera.center_px[0] += within(2.0);
        camera.center_px[1] += within(2.0);
        camera
    }

    /// This camera carried about the vertical through the table's middle, radians, counter-clockwise seen from above.
    pub(crate) fn turned_about_table(&self, angle_rad: f64) -> Camera {
        let turn = SE3::new(SO3::exp(&(Vector3::z() * angle_rad)), Vector3::zeros());
        Camera { world_from_camera: turn * self.world_from_camera, ..self.clone() }
    }
}
