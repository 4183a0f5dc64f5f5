//! Training windows: what the policy would have seen at a step, and the actions it should then have planned.
//!
//! Windows hold indices only; clouds stay where they are.

use crate::observation::grasp_step;
use crate::{Action, Episode, Observation};

/// The weight of a target that repeats the last action past the episode's end.
pub const PADDING_WEIGHT: f64 = 0.1;

/// One training example: a step of a recorded episode.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Window {
    /// The episode's index.
    pub episode: usize,
    /// The action step s at which the policy plans.
    pub step: usize,
}

/// One of a window's L targets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Target<'a> {
    /// The recorded action.
    pub action: &'a Action,
    /// Whether the episode is over and `action` is its last, repeated.
    pub padded: bool,
}

impl Target<'_> {
    /// The weight of this target in the loss: 1, or [`PADDING_WEIGHT`].
    pub fn weight(&self) -> f64 {
        if self.padded { PADDING_WEIGHT } else { 1.0 }
    }
}

impl Window {
    /// The windows of all episodes, in order: of all steps, but for those before a disturbance was answered.
    pub fn all(episodes: &[Episode]) -> Vec<Window> {
        let steps = |(episode, recorded): (usize, &Episode)| {
            (recorded.first_step()..recorded.actions.len()).map(move |step| Window { episode, step })
        };
        episodes.iter().enumerate().flat_map(steps).collect()
    }

    /// The `horizon` (at least one) frames that end with this step, oldest first; the first frame stands in for its predecessors.
    ///
    /// # Panics
    /// When the window is not one of `episodes`.
    pub fn frames<'a>(
        &self,
        episodes: &'a [Episode],
        horizon: usize,
    ) -> impl ExactSizeIterator<Item = &'a Observation> + use<'a> {
        let (observations, step) = (&episodes[self.episode].observations, self.step);
        (0..horizon.max(1)).rev().map(move |back| &observations[step.saturating_sub(back)])
    }

    /// The step at which the gripper took hold: the last one up to this in whose frame its fingers are open, the first where they never
    /// are. See [`ObservationHistory::world_from_grasp`](crate::ObservationHistory::world_from_grasp).
    ///
    /// # Panics
    /// When the window is not one of `episodes`.
    pub fn grasp_step(&self, episodes: &[Episode]) -> usize {
        grasp_step(&episodes[self.episode].observations, self.step)
    }

    /// The `horizon` actions from this step on; past the end the last one repeats.
    ///
    /// # Panics
    /// When the window is not one of `episodes`.
    pub fn targets<'a>(
        &self,
        episodes: &'a [Episode],
        horizon: usize,
    ) -> impl ExactSizeIterator<Item = Target<'a>> + use<'a> {
        let (actions, step) = (&episodes[self.episode].actions, self.step);
        let last = actions.len() - 1;
        (step..step + horizon).map(move |at| Target { action: &actions[at.min(last)], padded: at > last })
    }
}
