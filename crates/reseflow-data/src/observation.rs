//! What a policy is shown: one frame, and the last few of them.

use std::collections::VecDeque;

use reseflow_lie::SE3;

use crate::PointCloud;

/// One frame: what the camera sees and where the gripper is.
#[derive(Debug, Clone, PartialEq)]
pub struct Observation {
    /// The camera's points, world frame.
    pub cloud: PointCloud,
    /// The gripper's reached (not commanded) pose.
    pub world_from_gripper: SE3,
    /// The gripper's reached opening, 0 closed to 1 open.
    pub gripper_opening: f64,
}

/// The last `horizon` frames of an episode and how many action steps have gone by.
///
/// Before the second frame exists, the first stands in for its predecessors, so a history is always full.
#[derive(Debug, Clone)]
pub struct ObservationHistory {
    frames: VecDeque<Observation>,
    horizon: usize,
    elapsed_steps: usize,
}

impl ObservationHistory {
    /// A history that starts with `first`, repeated `horizon` times (at least once).
    pub fn new(first: Observation, horizon: usize) -> Self {
        let horizon = horizon.max(1);
        Self { frames: std::iter::repeat_n(first, horizon).collect(), horizon, elapsed_steps: 0 }
    }

    /// Rebuilds the history that a policy would have had at action step `step` of a recorded episode.
    pub fn at_step(observations: &[Observation], step: usize, horizon: usize) -> Self {
        let horizon = horizon.max(1);
        let frames = (0..horizon).rev().map(|back| observations[step.saturating_sub(back)].clone()).collect();
        Self { frames, horizon, elapsed_steps: step }
    }

    /// Appends the frame seen after one more action step and drops the oldest.
    pub fn push(&mut self, next: Observation) {
        if self.frames.len() == self.horizon {
            self.frames.pop_front();
        }
        self.frames.push_back(next);
        self.elapsed_steps += 1;
    }

    /// The frames, oldest first; always exactly `horizon` of them.
    pub fn frames(&self) -> impl ExactSizeIterator<Item = &Observation> {
        self.frames.iter()
    }

    /// The newest frame.
    pub fn latest(&self) -> &Observation {
        &self.frames[self.frames.len() - 1]
    }

    /// Action steps executed since the episode began.
    pub fn elapsed_steps(&self) -> usize {
        self.elapsed_steps
    }
}
