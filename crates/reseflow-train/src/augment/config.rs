//! Which augmentations there are, and how strong.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use crate::TrainError;

/// How a training window is changed each time it is drawn. Zero, or `false`, switches a change off.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AugmentConfig {
    /// Standard deviation of the jitter of cloud points, metres.
    pub jitter_m: f64,
    /// Largest share of a cloud's points that are left out; the share itself is drawn for each cloud, from 0 up to this.
    pub drop_points: f64,
    /// Standard deviation of the logarithm of the scene's size: cloud, gripper and actions grow or shrink about the centroid.
    pub scale_std: f64,
    /// Largest turn of all colours about the grey axis, as a share of the whole circle; the turn is drawn uniformly from both sides.
    pub hue_shift: f64,
    /// Standard deviation of the gripper's turn about each of its axes, radian; the actions stay where they are. The gripper is moved
    /// only where an episode begins and while its fingers are to stay open, and never such that it closes across the next action,
    /// where an expert might take the other half-turn; unless the half-turn that closes along the motion is taught, which is the same
    /// wherever the gripper stands ([`reseflow_net::DecoderConfig::nearest_half_turn`]).
    pub gripper_std_rad: f64,
    /// Standard deviation of the gripper's shift along each of its axes, metres; the actions stay where they are.
    pub gripper_std_m: f64,
    /// Largest turn of the gripper about its approach axis, radian, on top of the other turns; drawn uniformly from both sides.
    pub gripper_yaw_rad: f64,
    /// Standard deviation of a bend of the scene within the plane across the approach axis: by how much, 0.15 m from the middle,
    /// things are turned (in radian) and stretched. For tasks that follow a drawn curve.
    pub bend_std: f64,
    /// Standard deviation of the angle, radian, by which each of two swirls turns the surroundings of one of the scene's points, in the same
    /// plane: they make hooks and waves of straight lines. For tasks that follow a drawn curve with the gripper closing along it.
    pub swirl_std_rad: f64,
    /// Share of windows whose drawn line runs along another curve of the same length, any smooth one that keeps clear of itself, and is
    /// not bent. What is far from the line is shifted with it, and where the half-turn that closes along the motion is taught it is turned
    /// about the line's middle as well, by any angle: it goes with the gripper, and a few demonstrations could be told by it. For tasks
    /// that follow a drawn curve, for a network that sees one frame and no grasp, and for noise about the gripper: others are refused
    /// ([`crate::ModelConfig::validate_training`]). Demonstrations with shoves are never redrawn.
    pub redraw_share: f64,
    /// Share of windows that are seen in a mirror: the plane across the gripper's x axis, in which it is its own mirror image.
    pub mirror_share: f64,
    /// Whether the mirror stands upright, as near as that allows to the gripper's other such plane, across the way in which it closes: what
    /// is up stays up. For a network that sees which way that is ([`reseflow_net::Symmetry`]), and refused by an experiment's configuration
    /// beside another, to which both mirrors show the same up to a half-turn.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub mirror_upright: bool,
    /// Share of windows in which gripper and actions are turned by π about the approach axis: the gripper's other symmetry.
    pub half_turn_share: f64,
    /// Whether the whole scene is turned at random about the cloud's centroid: cloud, gripper, noise and actions. It teaches an
    /// equivariant network nothing, as its loss stays what it is; it is for one without any symmetry ([`reseflow_net::Symmetry::None`]), and
    /// an experiment's configuration refuses it beside another.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub scene_rotation: bool,
}

impl Default for AugmentConfig {
    fn default() -> Self {
        Self { jitter_m: 0.001, ..Self::NONE }
    }
}

impl AugmentConfig {
    /// No augmentation at all.
    pub const NONE: Self = Self {
        jitter_m: 0.0,
        drop_points: 0.0,
        scale_std: 0.0,
        hue_shift: 0.0,
        gripper_std_rad: 0.0,
        gripper_std_m: 0.0,
        gripper_yaw_rad: 0.0,
        bend_std: 0.0,
        swirl_std_rad: 0.0,
        redraw_share: 0.0,
        mirror_share: 0.0,
        mirror_upright: false,
        half_turn_share: 0.0,
        scene_rotation: false,
    };

    /// Whether anything warps the plane across the approach axis.
    pub(super) fn warps(&self) -> bool {
        self.bend_std > 0.0 || self.swirl_std_rad > 0.0 || self.redraw_share > 0.0
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`TrainError::Config`] naming the first that is out of range.
    pub fn validate(&self) -> Result<(), TrainError> {
        for (key, value, high) in [
            ("jitter_m", self.jitter_m, 1.0),
            ("drop_points", self.drop_points, 0.5),
            ("scale_std", self.scale_std, 0.5),
            ("hue_shift", self.hue_shift, 0.5),
            ("gripper_std_rad", self.gripper_std_rad, 1.0),
            ("gripper_std_m", self.gripper_std_m, 1.0),
            ("gripper_yaw_rad", self.gripper_yaw_rad, PI),
            ("bend_std", self.bend_std, 0.5),
            ("swirl_std_rad", self.swirl_std_rad, PI),
            ("redraw_share", self.redraw_share, 1.0),
            ("mirror_share", self.mirror_share, 1.0),
            ("half_turn_share", self.half_turn_share, 1.0),
        ] {
            if !(0.0..=high).contains(&value) {
                return Err(TrainError::Config(format!(
                    "train.augment.{key} must lie in 0 to {high}, got {value}"
                )));
            }
        }
        Ok(())
    }
}
