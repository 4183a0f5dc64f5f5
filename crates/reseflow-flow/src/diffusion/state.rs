//! Trajectories as the diffusion sees them: relative to an anchor that moves with the scene.

use reseflow_data::{Action, ActionChunk, Observation};
use reseflow_lie::SE3;

use super::DiffusionFrame;

/// What a trajectory is diffused relative to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Anchor {
    /// The anchor's pose.
    pub world_from_anchor: SE3,
    /// The gripper's present opening.
    pub opening: f64,
}

/// One action relative to an anchor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AnchoredAction {
    /// X = anchor⁻¹ H.
    pub anchor_from_gripper: SE3,
    /// How much wider the gripper is to open than it does at present.
    pub opening: f64,
}

/// A trajectory relative to an anchor.
#[derive(Debug, Clone, PartialEq)]
pub struct AnchoredChunk(pub Vec<AnchoredAction>);

/// What takes a noisy action to a clean one, from the left: clean = Ĥ · noisy; the openings' difference is added.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeftFactor {
    /// Ĥ^{k→0}.
    pub clean_from_noisy: SE3,
    /// The clean opening minus the noisy one.
    pub opening: f64,
}

impl Anchor {
    /// The anchor of what was last observed.
    pub fn of(latest: &Observation, frame: DiffusionFrame) -> Self {
        let world_from_anchor = match frame {
            DiffusionFrame::Gripper => latest.world_from_gripper,
            DiffusionFrame::World => SE3::identity(),
        };
        Self { world_from_anchor, opening: latest.gripper_opening }
    }

    /// The trajectory seen from the anchor.
    pub fn see(&self, chunk: &ActionChunk) -> AnchoredChunk {
        let anchor_from_world = self.world_from_anchor.inverse();
        let see = |action: &Action| AnchoredAction {
            anchor_from_gripper: anchor_from_world * action.world_from_gripper,
            opening: action.opening - self.opening,
        };
        AnchoredChunk(chunk.iter().map(see).collect())
    }

    /// The trajectory in the world.
    pub fn place(&self, chunk: &AnchoredChunk) -> ActionChunk {
        let place = |action: &AnchoredAction| Action {
            world_from_gripper: self.world_from_anchor * action.anchor_from_gripper,
            opening: action.opening + self.opening,
        };
        ActionChunk(chunk.0.iter().map(place).collect())
    }
}

impl LeftFactor {
    /// The whole relative transform between two poses: what a network has to say of `noisy` so that it becomes `clean`.
    pub fn between(noisy: &AnchoredAction, clean: &AnchoredAction) -> Self {
        Self {
            clean_from_noisy: clean.anchor_from_gripper * noisy.anchor_from_gripper.inverse(),
            opening: clean.opening - noisy.opening,
        }
    }

    /// As [`Self::between`], in the world.
    pub fn between_actions(noisy: &Action, clean: &Action) -> Self {
        Self {
            clean_from_noisy: clean.world_from_gripper * noisy.world_from_gripper.inverse(),
            opening: clean.opening - noisy.opening,
        }
    }

    /// Ĥ X.
    pub fn apply(&self, noisy: &AnchoredAction) -> AnchoredAction {
        AnchoredAction {
            anchor_from_gripper: self.clean_from_noisy * noisy.anchor_from_gripper,
            opening: noisy.opening + self.opening,
        }
    }

    /// Ĥ H, in the world.
    pub fn apply_to_action(&self, noisy: &Action) -> Action {
        Action {
            world_from_gripper: self.clean_from_noisy * noisy.world_from_gripper,
            opening: noisy.opening + self.opening,
        }
    }

    /// Whether every number is finite.
    pub fn is_finite(&self) -> bool {
        self.clean_from_noisy.is_finite() && self.opening.is_finite()
    }
}
