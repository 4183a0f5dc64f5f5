//! Pictures of episodes: five moments of each side by side, and the first one as a film, drawn afterwards.

use image::RgbImage;
use rayon::prelude::*;
use reseflow_data::{EpisodeObserver, Observation, Outcome, Scene, SceneBody, TaskSpec, Tick};
use reseflow_sim::{overview_camera, render};

use crate::plot::{PlotError, Strip, StripRow, encode_gif, encode_png};

const SIZE_PX: (usize, usize) = (360, 270);
/// Pictures of an episode before its end.
const MOMENTS: usize = 4;
/// Control ticks between the frames of a film.
const TICKS_PER_FRAME: usize = 4;

/// Remembers how scenes looked.
#[derive(Debug, Clone)]
pub struct PictureBook {
    name: String,
    every_steps: usize,
    frame_millis: u32,
    episodes: Vec<EpisodePictures>,
    /// Every few ticks of the first episode, and how many ticks it has had.
    film: Vec<Vec<SceneBody>>,
    film_ticks: usize,
}

#[derive(Debug, Clone, Default)]
struct EpisodePictures {
    moments: Vec<Vec<SceneBody>>,
    /// After the last control tick so far: however the episode ends, its end is in the picture.
    latest: Option<Vec<SceneBody>>,
    caption: String,
}

impl PictureBook {
    /// An empty book on a task; `name` says who acts.
    pub fn new(name: &str, spec: &TaskSpec) -> Self {
        Self {
            name: name.to_owned(),
            every_steps: spec.action_steps.div_ceil(MOMENTS).max(1),
            frame_millis: u32::try_from(spec.tick_nanos / 1_000_000 * TICKS_PER_FRAME as i64).unwrap_or(200),
            episodes: Vec::new(),
            film: Vec::new(),
            film_ticks: 0,
        }
    }

    /// Draws one row for each episode, as PNG.
    ///
    /// # Errors
    /// When there is nothing to draw or the drawing library fails.
    pub fn png(&self) -> Result<Vec<u8>, PlotError> {
        let row = |(index, episode): (usize, &EpisodePictures)| StripRow {
            label: format!("episode {index}, {}: {}", self.name, episode.caption),
            images: pictures(&episode.moments),
        };
        let strip = Strip { rows: self.episodes.iter().enumerate().map(row).collect() };
        encode_png(&strip.draw()?, "the episode strip")
    }

    /// Draws the first episode as an endless GIF, as fast as it was.
    ///
    /// # Errors
    /// When there is nothing to draw or the encoder fails.
    pub fn gif(&self) -> Result<Vec<u8>, PlotError> {
        encode_gif(pictures(&self.film), self.frame_millis)
    }
}

impl EpisodeObserver for PictureBook {
    fn on_observation(&mut self, step: usize, _observation: &Observation, scene: &dyn Scene) {
        if step == 0 {
            self.episodes.push(EpisodePictures::default());
            if self.episodes.len() == 1 {
                self.film.push(scene.bodies());
            }
        }
        if let Some(episode) = self.episodes.last_mut()
            && step.is_multiple_of(self.every_steps)
        {
            episode.moments.push(scene.bodies());
        }
    }

    fn on_tick(&mut self, _tick: &Tick, scene: &mut dyn Scene) {
        if let Some(episode) = self.episodes.last_mut() {
            episode.latest = Some(scene.bodies());
        }
        if self.episodes.len() == 1 {
            self.film_ticks += 1;
            if self.film_ticks.is_multiple_of(TICKS_PER_FRAME) {
                self.film.push(scene.bodies());
            }
        }
    }

    fn on_outcome(&mut self, outcome: &Outcome) {
        if let Some(episode) = self.episodes.last_mut() {
            episode.moments.extend(episode.latest.take());
            let verdict = match (outcome.success, outcome.halt) {
                (true, _) => "success".to_owned(),
                (false, None) => "no success".to_owned(),
                (false, Some(halt)) => format!("ended early, {halt}"),
            };
            episode.caption = format!("{verdict} ({} {:.2})", outcome.measure_name, outcome.measure);
        }
    }
}

/// Draws moments of one episode, all from one viewpoint.
fn pictures(moments: &[Vec<SceneBody>]) -> Vec<RgbImage> {
    let camera = overview_camera(moments.iter().flatten(), SIZE_PX.0, SIZE_PX.1);
    let picture = |bodies: &Vec<SceneBody>| {
        let drawn = render(bodies, &camera);
        RgbImage::from_raw(drawn.width as u32, drawn.height as u32, drawn.pixels)
    };
    moments.par_iter().filter_map(picture).collect()
}
