//! Velocities of actions along the flow, and the one norm by which states, velocities and errors are compared: radians, metres
//! over ℓ and openings, summed in squares.

use std::ops::{Add, Mul, Sub};

use reseflow_lie::BodyTwist;

use crate::LENGTH_SCALE_M;

/// How an action moves per unit of flow time, and equally a displacement of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ActionVelocity {
    /// ξ_b, the body twist of the pose.
    pub twist: BodyTwist,
    /// The rate of the opening.
    pub opening: f64,
}

impl ActionVelocity {
    /// Standing still.
    pub fn zero() -> ActionVelocity {
        ActionVelocity { twist: BodyTwist::zero(), opening: 0.0 }
    }

    /// ‖ω‖² + ‖ρ‖²/ℓ² + ȯ², unchanged by a change of world frame.
    pub fn squared_norm(&self) -> f64 {
        let linear = self.twist.linear.norm_squared() / (LENGTH_SCALE_M * LENGTH_SCALE_M);
        self.twist.angular.norm_squared() + linear + self.opening * self.opening
    }

    /// Whether every component is finite.
    pub fn is_finite(&self) -> bool {
        self.twist.is_finite() && self.opening.is_finite()
    }
}

impl Add for ActionVelocity {
    type Output = ActionVelocity;
    fn add(self, other: ActionVelocity) -> ActionVelocity {
        ActionVelocity { twist: self.twist + other.twist, opening: self.opening + other.opening }
    }
}

impl Sub for ActionVelocity {
    type Output = ActionVelocity;
    fn sub(self, other: ActionVelocity) -> ActionVelocity {
        ActionVelocity { twist: self.twist - other.twist, opening: self.opening - other.opening }
    }
}

impl Mul<f64> for ActionVelocity {
    type Output = ActionVelocity;
    fn mul(self, scale: f64) -> ActionVelocity {
        ActionVelocity { twist: self.twist * scale, opening: self.opening * scale }
    }
}

/// The velocities of a chunk's L actions.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ChunkVelocity(pub Vec<ActionVelocity>);
