//! Draws an episode: a strip of frames, and the first cloud from above and from the camera's side.
//!
//! `cargo run -p reseflow-sim --example picture -- OUTPUT_FOLDER [TASK] [INDEX]`

use std::error::Error;
use std::path::PathBuf;

use image::{Rgb, RgbImage};
use reseflow_data::{
    EpisodeKey, EpisodeObserver, Observation, PointCloud, RolloutConfig, Scene, SceneBody, Split, Tick,
    rollout,
};
use reseflow_sim::{overview_camera, render, task};

const WIDTH: u32 = 400;
const HEIGHT: u32 = 300;

/// Keeps how the scene looks at the end of each action step, and every cloud.
#[derive(Default)]
struct Album {
    frames: Vec<Vec<SceneBody>>,
    clouds: Vec<PointCloud>,
    ticks: usize,
}

impl EpisodeObserver for Album {
    fn on_observation(&mut self, _step: usize, observation: &Observation, scene: &dyn Scene) {
        self.clouds.push(observation.cloud.clone());
        if self.frames.is_empty() {
            self.frames.push(scene.bodies());
        }
    }

    fn on_tick(&mut self, _tick: &Tick, scene: &mut dyn Scene) {
        self.ticks += 1;
        if self.ticks.is_multiple_of(10) {
            self.frames.push(scene.bodies());
        }
    }
}

/// Frames side by side, four in a row.
fn strip(frames: &[Vec<SceneBody>]) -> RgbImage {
    let camera = overview_camera(frames.iter().flatten(), WIDTH as usize, HEIGHT as usize);
    let columns = 4.min(frames.len()) as u32;
    let rows = (frames.len() as u32).div_ceil(columns.max(1));
    let mut sheet = RgbImage::from_pixel(columns * WIDTH, rows * HEIGHT, Rgb([255; 3]));
    for (index, frame) in frames.iter().enumerate() {
        let (x, y) = (index as u32 % columns * WIDTH, index as u32 / columns * HEIGHT);
        if let Some(picture) = RgbImage::from_raw(WIDTH, HEIGHT, render(frame, &camera).pixels) {
            image::imageops::replace(&mut sheet, &picture, i64::from(x), i64::from(y));
        }
    }
    sheet
}

/// A cloud from above (left) and from the side (right), 5 pixels a centimetre about its mean.
fn cloud_plot(cloud: &PointCloud) -> RgbImage {
    let (size, scale) = (400_i64, 2500.0);
    let mut plot = RgbImage::from_pixel(2 * size as u32, size as u32, Rgb([24, 26, 30]));
    let count = cloud.len().max(1) as f32;
    let mean = [0, 1, 2].map(|axis| cloud.points.iter().map(|p| p[axis]).sum::<f32>() / count);
    for (point, color) in cloud.points.iter().zip(&cloud.colors) {
        for (panel, vertical) in [(0, 1), (1, 2)] {
            let x = size / 2 + ((point[0] - mean[0]) * scale) as i64 + panel * size;
            let y = size / 2 - ((point[vertical] - mean[vertical]) * scale) as i64;
            for (dx, dy) in (-3..=3).flat_map(|dx| (-3..=3).map(move |dy| (dx, dy))) {
                let (x, y) = (x + dx, y + dy);
                if (0..2 * size).contains(&x) && (0..size).contains(&y) {
                    plot.put_pixel(x as u32, y as u32, Rgb(*color));
                }
            }
        }
    }
    plot
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let folder = PathBuf::from(arguments.next().ok_or("expected an output folder")?);
    let name = arguments.next().unwrap_or_else(|| "triangle".to_owned());
    let index = arguments.next().map_or(Ok(0), |text| text.parse())?;
    let task = task(&name).ok_or("no such task")?;
    let spec = task.spec();
    let key = EpisodeKey { task: name, split: Split::Train, seed: 0, index, attempt: 0 };
    let mut scene = task.reset(&key)?;
    let mut expert = scene.expert();
    let config = RolloutConfig {
        observation_horizon: 1,
        n_action_steps: spec.action_steps,
        disturb_before: None,
        policy_seed: 0,
    };
    let mut album = Album::default();
    rollout(scene.as_mut(), &spec, expert.as_mut(), &config, &mut album)?;
    std::fs::create_dir_all(&folder)?;
    strip(&album.frames).save(folder.join("strip.png"))?;
    for (step, cloud) in album.clouds.iter().enumerate().step_by(4) {
        cloud_plot(cloud).save(folder.join(format!("cloud_{step}.png")))?;
    }
    Ok(())
}
