//! Pictures of episodes while they run: five moments of each, drawn afterwards.

use image::RgbImage;
use rayon::prelude::*;
use reseflow_data::{EpisodeObserver, Observation, Outcome, Scene, SceneBody, TaskSpec, Tick};
use reseflow_sim::{overview_camera, render};

use crate::plot::{PlotError, Strip, StripRow, encode_png};

const SIZE_PX: (usize, usize) = (360, 270);
/// Pictures of an episode before its end.
const MOMENTS: usize = 4;

/// Remembers how scenes looked.
#[derive(Debug, Clone)]
pub struct PictureBook {
    name: String,
    every_steps: usize,
    end_nanos: i64,
    episodes: Vec<EpisodePictures>,
}

#[derive(Debug, Clone, Default)]
struct EpisodePictures {
    moments: Vec<Vec<SceneBody>>,
    caption: String,
}

impl PictureBook {
    /// An empty book on a task; `name` says who acts.
    pub fn new(name: &str, spec: &TaskSpec) -> Self {
        Self {
            name: name.to_owned(),
            every_steps: spec.action_steps.div_ceil(MOMENTS).max(1),
            end_nanos: (spec.action_steps * spec.ticks_per_action) as i64 * spec.tick_nanos,
            episodes: Vec::new(),
        }
    }

    /// Draws one row for each episode, as PNG.
    ///
    /// # Errors
    /// When there is nothing to draw or the drawing library fails.
    pub fn png(&self) -> Result<Vec<u8>, PlotError> {
        let row = |(index, episode): (usize, &EpisodePictures)| StripRow {
            label: format!("episode {index}, {}: {}", self.name, episode.caption),
            images: episode.moments.par_iter().filter_map(|bodies| picture(bodies)).collect(),
        };
        let strip = Strip { rows: self.episodes.iter().enumerate().map(row).collect() };
        encode_png(&strip.draw()?, "the episode strip")
    }

    fn remember(&mut self, scene: &dyn Scene) {
        if let Some(episode) = self.episodes.last_mut() {
            episode.moments.push(scene.bodies());
        }
    }
}

impl EpisodeObserver for PictureBook {
    fn on_observation(&mut self, step: usize, _observation: &Observation, scene: &dyn Scene) {
        if step == 0 {
            self.episodes.push(EpisodePictures::default());
        }
        if step.is_multiple_of(self.every_steps) {
            self.remember(scene);
        }
    }

    fn on_tick(&mut self, tick: &Tick, scene: &mut dyn Scene) {
        if tick.time_nanos == self.end_nanos {
            self.remember(scene);
        }
    }

    fn on_outcome(&mut self, outcome: &Outcome) {
        if let Some(episode) = self.episodes.last_mut() {
            let verdict = match (outcome.success, outcome.halt) {
                (true, _) => "success".to_owned(),
                (false, None) => "no success".to_owned(),
                (false, Some(halt)) => format!("ended early, {halt}"),
            };
            episode.caption = format!("{verdict} ({} {:.2})", outcome.measure_name, outcome.measure);
        }
    }
}

fn picture(bodies: &[SceneBody]) -> Option<RgbImage> {
    let drawn = render(bodies, &overview_camera(SIZE_PX.0, SIZE_PX.1));
    RgbImage::from_raw(drawn.width as u32, drawn.height as u32, drawn.pixels)
}
