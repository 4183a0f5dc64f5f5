//! The settings of the camera, as the program's options and configurations know them.

use serde::{Deserialize, Serialize};

use super::Selection;
use crate::error::{SimError, expect};

/// The most points that a cloud may have: a frame has 76 800 pixels, and farthest-point sampling takes its time.
const MOST_POINTS: usize = 10_000;

/// How frames are made from what the camera sees.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CameraSettings {
    /// Points N of a cloud, 1 to 10 000; `None` takes the task's own number.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub points: Option<usize>,
    /// How the N points are chosen.
    pub selection: Selection,
    /// Standard deviation of the depth along each ray, metres, 0 to 1.
    pub depth_noise_m: f64,
    /// The fraction of pixels that return no depth, 0 to 1.
    pub drop_fraction: f64,
    /// Points below this height over the table's top are cropped, metres, and so is the table itself, noise or not, where the
    /// height is positive; −1 crops nothing.
    pub crop_below_m: f64,
    /// Whether the robot's own body is cut out (its pose is known). It hides what is behind it all the same.
    pub mask_gripper: bool,
    /// A second camera's view, merged with the first: the same camera carried about the vertical through the table's
    /// middle by this angle, radians.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub second_view_rad: Option<f64>,
}

impl Default for CameraSettings {
    fn default() -> Self {
        Self {
            points: None,
            selection: Selection::Salient,
            depth_noise_m: 0.001,
            drop_fraction: 0.0,
            crop_below_m: 0.004,
            mask_gripper: true,
            second_view_rad: None,
        }
    }
}

impl CameraSettings {
    /// Checks that a camera can be so.
    ///
    /// # Errors
    /// [`SimError::Setting`]: the first setting that is out of its range.
    pub fn validate(&self) -> Result<(), SimError> {
        if let Some(points) = self.points {
            let in_range = (1..=MOST_POINTS).contains(&points);
            expect(in_range, "points", points, format!("1 to {MOST_POINTS}"))?;
        }
        for (key, value) in [("depth_noise_m", self.depth_noise_m), ("drop_fraction", self.drop_fraction)] {
            expect((0.0..=1.0).contains(&value), key, value, "0 to 1")?;
        }
        expect((-1.0..=1.0).contains(&self.crop_below_m), "crop_below_m", self.crop_below_m, "-1 to 1")?;
        let angle_rad = self.second_view_rad.unwrap_or_default();
        expect(angle_rad.is_finite(), "second_view_rad", angle_rad, "a finite number")
    }

    /// Whether this is the camera that every task has unless told otherwise.
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }
}
