//! The path from noise to data, and the chart in which solvers step along it; the opening moves in a line.
//!
//! - *screw*, the paper's geodesic in body form: H^t = H⁰ Exp(t log((H⁰)⁻¹ H¹)). Steps are H Exp(Θ).
//! - *product*, the geodesic of SO(3) × ℝ³ that D_geo measures: R^t = R⁰ Exp(t log(R⁰ᵀR¹)), p^t = p⁰ + t(p¹ − p⁰). Steps are
//!   (R Exp(θ), p + R ρ).

use reseflow_data::{Action, ActionChunk};
use reseflow_lie::nalgebra::Vector6;
use reseflow_lie::{BodyTwist, SE3, SO3};
use reseflow_lie_tensor::geodesic::Geodesic;
use serde::{Deserialize, Serialize};

use crate::{ActionVelocity, ChunkVelocity, FlowError};

/// Which geodesic joins noise and data.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Path {
    /// One screw motion: a constant body twist.
    #[default]
    Screw,
    /// Rotation and position apart: the origin moves in a line.
    Product,
}

impl Path {
    /// The state at flow time `t` ∈ \[0, 1\] between noise and data.
    ///
    /// # Errors
    /// [`FlowError::Mismatch`] where the horizons differ.
    pub fn at(self, noise: &ActionChunk, data: &ActionChunk, t: f64) -> Result<ActionChunk, FlowError> {
        let along =
            |(start, end): (&Action, &Action)| self.retract(start, &(self.displacement(start, end) * t));
        Ok(ActionChunk(pairs(noise, data)?.map(along).collect()))
    }

    /// The velocity of [`Path::at`] at flow time `t`, a body twist: what a flow is taught. Nothing is divided by 1 − t.
    ///
    /// # Errors
    /// [`FlowError::Mismatch`] where the horizons differ.
    pub fn velocity(
        self,
        noise: &ActionChunk,
        data: &ActionChunk,
        t: f64,
    ) -> Result<ChunkVelocity, FlowError> {
        let along = |(start, end): (&Action, &Action)| {
            let mut velocity = self.displacement(start, end);
            if self == Path::Product {
                // The direction of the line is fixed in the world, and the body has turned by t ω.
                let turned = SO3::exp(&(velocity.twist.angular * -t));
                velocity.twist.linear = turned.act(&velocity.twist.linear);
            }
            velocity
        };
        Ok(ChunkVelocity(pairs(noise, data)?.map(along).collect()))
    }

    /// Θ with `retract(from, Θ) = to`.
    pub(crate) fn displacement(self, from: &Action, to: &Action) -> ActionVelocity {
        let (start, end) = (&from.world_from_gripper, &to.world_from_gripper);
        let twist = match self {
            Path::Screw => start.body_twist_to(end),
            Path::Product => start.product_displacement_to(end),
        };
        ActionVelocity { twist, opening: to.opening - from.opening }
    }

    /// Where the chart's point Θ about `from` lies.
    pub(crate) fn retract(self, from: &Action, chart: &ActionVelocity) -> Action {
        let pose = &from.world_from_gripper;
        let world_from_gripper = match self {
            Path::Screw => pose.plus(&chart.twist),
            Path::Product => pose.plus_product(&chart.twist),
        };
        Action { world_from_gripper, opening: from.opening + chart.opening }
    }

    /// Θ̇ of an action that moves with the body velocity ξ at the chart's point Θ (the inverse of dexp).
    ///
    /// Screw: Θ̇ = J_r⁻¹(Θ) ξ. Product: θ̇ = J_r⁻¹(θ) ω, and ρ̇ = Exp(θ) v, since ṗ = R v.
    pub(crate) fn chart_rate(self, chart: &ActionVelocity, velocity: &ActionVelocity) -> ActionVelocity {
        let (at, twist) = (&chart.twist, &velocity.twist);
        let twist = match self {
            Path::Screw => {
                let rate: Vector6<f64> = SE3::right_jacobian_inverse(at) * twist.vector6();
                BodyTwist::from_vector6(&rate)
            }
            Path::Product => BodyTwist::new(
                SO3::right_jacobian_inverse(&at.angular) * twist.angular,
                SO3::exp(&at.angular).act(&twist.linear),
            ),
        };
        ActionVelocity { twist, opening: velocity.opening }
    }

    /// A velocity at `now` in the terms in which this path's own velocity is constant from `start` on.
    pub(crate) fn seen_from(self, start: &Action, now: &Action, velocity: &ActionVelocity) -> ActionVelocity {
        let mut seen = *velocity;
        if self == Path::Product {
            let start_from_now =
                start.world_from_gripper.rotation.inverse() * now.world_from_gripper.rotation;
            seen.twist.linear = start_from_now.act(&velocity.twist.linear);
        }
        seen
    }

    /// The same geodesic on tensors.
    pub(crate) fn geodesic(self) -> Geodesic {
        match self {
            Path::Screw => Geodesic::Screw,
            Path::Product => Geodesic::Product,
        }
    }
}

/// Corresponding actions of two chunks of one horizon.
pub(crate) fn pairs<'a>(
    first: &'a ActionChunk,
    second: &'a ActionChunk,
) -> Result<impl Iterator<Item = (&'a Action, &'a Action)>, FlowError> {
    if first.len() != second.len() {
        return Err(FlowError::Mismatch { what: "actions", expected: first.len(), got: second.len() });
    }
    Ok(first.iter().zip(second.iter()))
}
