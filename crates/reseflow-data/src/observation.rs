//! What a policy is shown: one frame, and the last few of them.

use std::collections::VecDeque;

use reseflow_lie::SE3;

use crate::PointCloud;

/// Fingers that are open further than this hold nothing.
const FREE_OPENING: f64 = 0.9;

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

impl Observation {
    /// Whether the fingers are open, so that the gripper holds nothing.
    pub fn is_free(&self) -> bool {
        self.gripper_opening > FREE_OPENING
    }
}

/// The last frame up to `step` of a recorded episode in which the gripper was free; the first where it never was.
pub(crate) fn grasp_step(observations: &[Observation], step: usize) -> usize {
    observations[..=step].iter().rposition(Observation::is_free).unwrap_or(0)
}

/// The last `horizon` frames of an episode, how many action steps have gone by, and where the gripper took hold.
///
/// Before the second frame exists, the first stands in for its predecessors, so a history is always full.
#[derive(Debug, Clone)]
pub struct ObservationHistory {
    frames: VecDeque<Observation>,
    horizon: usize,
    elapsed_steps: usize,
    world_from_grasp: SE3,
}

impl ObservationHistory {
    /// A history that starts with `first`, repeated `horizon` times (at least once).
    pub fn new(first: Observation, horizon: usize) -> Self {
        let (horizon, world_from_grasp) = (horizon.max(1), first.world_from_gripper);
        let frames = std::iter::repeat_n(first, horizon).collect();
        Self { frames, horizon, elapsed_steps: 0, world_from_grasp }
    }

    /// Rebuilds the history that a policy would have had at action step `step` of a recorded episode.
    pub fn at_step(observations: &[Observation], step: usize, horizon: usize) -> Self {
        let horizon = horizon.max(1);
        let frames = (0..horizon).rev().map(|back| observations[step.saturating_sub(back)].clone()).collect();
        let world_from_grasp = observations[grasp_step(observations, step)].world_from_gripper;
        Self { frames, horizon, elapsed_steps: step, world_from_grasp }
    }

    /// The same history seen otherwise: each frame as `frame` has it, and the poses of earlier frames as `pose` has them.
    pub fn map(&self, frame: impl Fn(&Observation) -> Observation, pose: impl Fn(&SE3) -> SE3) -> Self {
        Self {
            frames: self.frames.iter().map(frame).collect(),
            world_from_grasp: pose(&self.world_from_grasp),
            ..*self
        }
    }

    /// Appends the frame seen after one more action step and drops the oldest.
    pub fn push(&mut self, next: Observation) {
        if self.frames.len() == self.horizon {
            self.frames.pop_front();
        }
        if next.is_free() {
            self.world_from_grasp = next.world_from_gripper;
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

    /// Where the gripper was when it took hold of what it holds: its pose in the last frame in which its fingers were open. Now
    /// where they are; in the first frame where they never were.
    pub fn world_from_grasp(&self) -> SE3 {
        self.world_from_grasp
    }

    /// Action steps executed since the episode began.
    pub fn elapsed_steps(&self) -> usize {
        self.elapsed_steps
    }
}
