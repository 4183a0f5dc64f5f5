//! Where noise trajectories come from. Every prior moves with the gripper and the cloud, so that the whole sampler is equivariant
//! draw by draw; a prior fixed to the world would not be.

mod gripper;
mod haar;

use rand::Rng;
use reseflow_data::{ActionChunk, Observation};
use reseflow_lie::{SE3, Vector3};
use serde::{Deserialize, Serialize};

use crate::FlowError;

pub use gripper::GripperPrior;
pub use haar::HaarPrior;

/// The noise Π₀. In a configuration the key `kind` tells which, `gripper` where it is left out.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Keys", into = "Keys")]
pub enum Prior {
    /// About the gripper's pose.
    Gripper(GripperPrior),
    /// Rotations of any kind, positions about the cloud.
    Haar(HaarPrior),
}

impl Default for Prior {
    fn default() -> Self {
        Self::Gripper(GripperPrior::default())
    }
}

/// What of a scene a prior looks at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PriorFrame {
    /// The gripper now.
    pub world_from_gripper: SE3,
    /// Its opening now.
    pub opening: f64,
    /// The cloud's centroid in the world, metres.
    pub centroid_m: Vector3<f64>,
}

impl PriorFrame {
    /// What the latest observation shows; a cloud without points is taken to lie at the gripper.
    pub fn of(latest: &Observation) -> PriorFrame {
        let points = &latest.cloud.points;
        let sum = points
            .iter()
            .fold(Vector3::zeros(), |sum, point| sum + Vector3::from_fn(|axis, _| f64::from(point[axis])));
        let centroid_m = match points.len() {
            0 => latest.world_from_gripper.translation,
            count => sum / count as f64,
        };
        let (world_from_gripper, opening) = (latest.world_from_gripper, latest.gripper_opening);
        PriorFrame { world_from_gripper, opening, centroid_m }
    }
}

impl Prior {
    /// Checks the standard deviations.
    ///
    /// # Errors
    /// [`FlowError::Config`] naming the first that is negative or not finite.
    pub fn validate(&self) -> Result<(), FlowError> {
        match self {
            Self::Gripper(prior) => prior.validate(),
            Self::Haar(prior) => prior.validate(),
        }
    }

    /// Draws `horizon` noisy actions, independent of each other.
    pub fn sample<R: Rng + ?Sized>(&self, frame: &PriorFrame, horizon: usize, rng: &mut R) -> ActionChunk {
        match self {
            Self::Gripper(prior) => prior.sample(&frame.world_from_gripper, frame.opening, horizon, rng),
            Self::Haar(prior) => prior.sample(frame, horizon, rng),
        }
    }
}

/// Refuses standard deviations that are none.
fn check_deviations(deviations: &[(&str, f64)]) -> Result<(), FlowError> {
    match deviations.iter().find(|(_, value)| !value.is_finite() || *value < 0.0) {
        Some((key, value)) => {
            Err(FlowError::Config(format!("prior.{key} must be a number of at least 0, got {value}")))
        }
        None => Ok(()),
    }
}

/// The names of the priors.
#[derive(Clone, Copy, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Kind {
    #[default]
    Gripper,
    Haar,
}

/// A prior as a configuration writes it.
#[derive(Clone, Copy, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Keys {
    #[serde(default)]
    kind: Kind,
    #[serde(skip_serializing_if = "Option::is_none")]
    sigma_rotation_rad: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    sigma_translation_m: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    sigma_opening: Option<f64>,
}

impl TryFrom<Keys> for Prior {
    type Error = String;

    fn try_from(keys: Keys) -> Result<Self, String> {
        match keys.kind {
            Kind::Gripper => {
                let default = GripperPrior::default();
                Ok(Self::Gripper(GripperPrior {
                    sigma_rotation_rad: keys.sigma_rotation_rad.unwrap_or(default.sigma_rotation_rad),
                    sigma_translation_m: keys.sigma_translation_m.unwrap_or(default.sigma_translation_m),
                    sigma_opening: keys.sigma_opening.unwrap_or(default.sigma_opening),
                }))
            }
            Kind::Haar if keys.sigma_rotation_rad.is_some() => Err("sigma_rotation_rad belongs to \
                 kind = \"gripper\": with \"haar\" every rotation is equally likely"
                .to_owned()),
            Kind::Haar => {
                let default = HaarPrior::default();
                Ok(Self::Haar(HaarPrior {
                    sigma_translation_m: keys.sigma_translation_m.unwrap_or(default.sigma_translation_m),
                    sigma_opening: keys.sigma_opening.unwrap_or(default.sigma_opening),
                }))
            }
        }
    }
}

impl From<Prior> for Keys {
    fn from(prior: Prior) -> Keys {
        match prior {
            Prior::Gripper(GripperPrior { sigma_rotation_rad, sigma_translation_m, sigma_opening }) => Keys {
                kind: Kind::Gripper,
                sigma_rotation_rad: Some(sigma_rotation_rad),
                sigma_translation_m: Some(sigma_translation_m),
                sigma_opening: Some(sigma_opening),
            },
            Prior::Haar(HaarPrior { sigma_translation_m, sigma_opening }) => Keys {
                kind: Kind::Haar,
                sigma_rotation_rad: None,
                sigma_translation_m: Some(sigma_translation_m),
                sigma_opening: Some(sigma_opening),
            },
        }
    }
}
