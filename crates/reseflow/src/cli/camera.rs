//! The options that say how the camera's frames are made.

use clap::Args;
use reseflow_sim::CameraSettings;

use crate::config::{Override, parse};
use crate::error::bad_input;

/// `--camera`
#[derive(Debug, Clone, Args)]
pub struct CameraArgs {
    /// A setting of the camera, as often as needed: points (of each cloud), selection (salient or farthest), depth_noise_m,
    /// drop_fraction (of the pixels), crop_below_m (over the table's top; -1 keeps the table), mask_gripper (true or false),
    /// second_view_rad (where about the table a second camera stands)
    #[arg(long = "camera", value_name = "KEY=VALUE", value_parser = setting)]
    settings: Vec<Override>,
}

fn setting(text: &str) -> Result<Override, String> {
    Override::read(text, "--camera", "points=64")
}

impl CameraArgs {
    /// The camera: each task's own where nothing is said.
    ///
    /// # Errors
    /// Bad input: an unknown key, or a value of the wrong type or out of its range.
    pub fn settings(&self) -> anyhow::Result<CameraSettings> {
        let camera: CameraSettings = parse("", "--camera", &self.settings)?;
        camera.validate().map_err(|fault| bad_input(format!("--camera: {fault}")))?;
        Ok(camera)
    }
}
