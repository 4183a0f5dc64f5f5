//! What the setups of all tasks draw alike: offsets, sizes, the gripper's start, colours, the camera.
//!
//! `wide` draws lie outside the distributions of train, validation and test.

use rand::{Rng, RngExt};
use reseflow_lie::SE3;

use crate::camera::{Camera, ViewSpread};
use crate::color::rgb_from_hsv;

/// Half of the square in which objects lie, metres.
const CENTER_HALF_M: f64 = 0.15;
/// The same for wide draws, which lie outside the smaller square.
const WIDE_CENTER_HALF_M: f64 = 0.22;

/// Where an object lies about its nominal place, metres: within ± 0.15 m; wide: outside that and within ± 0.22 m.
pub(super) fn center_offset<R: Rng>(wide: bool, rng: &mut R) -> [f64; 2] {
    let half = if wide { WIDE_CENTER_HALF_M } else { CENTER_HALF_M };
    loop {
        let center = [rng.random_range(-half..=half), rng.random_range(-half..=half)];
        if !wide || center[0].abs().max(center[1].abs()) > CENTER_HALF_M {
            return center;
        }
    }
}

/// An object's size over its nominal one: within ± 15 %; wide: 15 to 25 % off.
pub(super) fn size_factor<R: Rng>(wide: bool, rng: &mut R) -> f64 {
    if wide {
        let magnitude: f64 = rng.random_range(0.15..=0.25);
        1.0 + if rng.random::<bool>() { magnitude } else { -magnitude }
    } else {
        1.0 + rng.random_range(-0.15..=0.15)
    }
}

/// The gripper's start about `home`: σ = 0.15 rad and 4 cm; wide: 0.25 rad and 6 cm.
pub(super) fn gripper_start<R: Rng>(home: &SE3, wide: bool, rng: &mut R) -> SE3 {
    let (sigma_rad, sigma_m) = if wide { (0.25, 0.06) } else { (0.15, 0.04) };
    SE3::sample_gaussian(home, sigma_rad, sigma_m, rng)
}

/// A colour of an object's body: coloured, but not so that it stands out.
pub(super) fn object_color<R: Rng>(rng: &mut R) -> [u8; 3] {
    color([0.20, 0.42], [0.45, 0.9], rng)
}

/// A colour that stands out.
pub(super) fn salient_color<R: Rng>(rng: &mut R) -> [u8; 3] {
    color([0.85, 1.0], [0.75, 1.0], rng)
}

/// A colour of the table: nearly grey.
pub(super) fn table_color<R: Rng>(rng: &mut R) -> [u8; 3] {
    color([0.02, 0.10], [0.55, 0.9], rng)
}

/// Any hue, with saturation and value from the given ranges.
pub(super) fn color<R: Rng>(saturation: [f64; 2], value: [f64; 2], rng: &mut R) -> [u8; 3] {
    let hue = rng.random::<f64>();
    let saturation = rng.random_range(saturation[0]..=saturation[1]);
    rgb_from_hsv(hue, saturation, rng.random_range(value[0]..=value[1]))
}

/// The camera: within 0.15 rad of the front; wide: 0.25 to 0.7 rad to either side.
pub(super) fn camera<R: Rng>(wide: bool, rng: &mut R) -> Camera {
    let spread = if wide {
        ViewSpread { azimuth_rad: [0.25, 0.7], elevation_rad: 0.2, distance_m: 0.1 }
    } else {
        ViewSpread { azimuth_rad: [0.0, 0.15], elevation_rad: 0.08, distance_m: 0.04 }
    };
    Camera::draw(&spread, rng)
}
