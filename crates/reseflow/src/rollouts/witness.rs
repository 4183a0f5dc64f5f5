//! Who watches the first episodes of a series: a log, a picture book, both or nobody.

use std::path::Path;

use reseflow_data::{DataError, EpisodeObserver, McapLog, Observation, Outcome, Plan, Scene, Tick};

use super::PictureBook;

/// Watches the first episodes, the log as many as it was told to and the picture book likewise.
#[derive(Default)]
pub struct Witness {
    log: Option<(McapLog, usize)>,
    pictures: Option<(PictureBook, usize)>,
    begun: usize,
}

impl Witness {
    /// With a log of the first `episodes` episodes that is to become `path`.
    ///
    /// # Errors
    /// When the file cannot be created.
    pub fn with_log(mut self, path: &Path, episodes: usize) -> Result<Self, DataError> {
        self.log = Some((McapLog::create(path)?, episodes));
        Ok(self)
    }

    /// With pictures of the first `episodes` episodes.
    pub fn with_pictures(mut self, pictures: PictureBook, episodes: usize) -> Self {
        self.pictures = Some((pictures, episodes));
        self
    }

    /// How many episodes must be shown to it.
    pub fn episodes(&self) -> usize {
        let of_log = self.log.as_ref().map_or(0, |(_, episodes)| *episodes);
        let of_pictures = self.pictures.as_ref().map_or(0, |(_, episodes)| *episodes);
        of_log.max(of_pictures)
    }

    /// Completes the log and hands out the pictures.
    ///
    /// # Errors
    /// What went wrong while logging.
    pub fn finish(self) -> Result<Option<PictureBook>, DataError> {
        if let Some((log, _)) = self.log {
            log.finish()?;
        }
        Ok(self.pictures.map(|(pictures, _)| pictures))
    }

    fn tell(&mut self, mut event: impl FnMut(&mut dyn EpisodeObserver)) {
        if let Some((log, episodes)) = &mut self.log
            && self.begun <= *episodes
        {
            event(log);
        }
        if let Some((pictures, episodes)) = &mut self.pictures
            && self.begun <= *episodes
        {
            event(pictures);
        }
    }
}

impl EpisodeObserver for Witness {
    fn on_observation(&mut self, step: usize, observation: &Observation, scene: &dyn Scene) {
        if step == 0 {
            self.begun += 1;
        }
        self.tell(|observer| observer.on_observation(step, observation, scene));
    }

    fn on_plan(&mut self, step: usize, plan: &Plan) {
        self.tell(|observer| observer.on_plan(step, plan));
    }

    fn on_tick(&mut self, tick: &Tick, scene: &mut dyn Scene) {
        self.tell(|observer| observer.on_tick(tick, scene));
    }

    fn on_outcome(&mut self, outcome: &Outcome) {
        self.tell(|observer| observer.on_outcome(outcome));
    }
}
