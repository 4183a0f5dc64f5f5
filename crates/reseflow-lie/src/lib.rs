//! The Lie groups SO(3) and SE(3) in f64: exponentials, logarithms, Jacobians, geodesics, sampling and means.
//!
//! | symbol | here | meaning |
//! |---|---|---|
//! | R ∈ SO(3) | [`SO3`] | rotation, a unit quaternion inside |
//! | X ∈ SE(3) | [`SE3`] | pose `target_from_source`, rotation then translation |
//! | ξ_b = (X⁻¹ Ẋ)^∨ | [`BodyTwist`] | unchanged by a change of world frame X ↦ gX |
//! | ξ_s = (Ẋ X⁻¹)^∨ = Ad_X ξ_b | [`SpatialTwist`] | a second type; there is no implicit conversion |
//! | D_geo | [`geodesic_distance`] | the distance the ReSeFlow paper reports |
//!
//! A twist is (ω, ρ), angular first. Units are radian and metre. Conventions of the Jacobians: Barfoot, *State
//! Estimation for Robotics*, chapter 7 (reordered to angular first); Solà, Deray, Atchuthan, *A micro Lie theory*.
//!
//! ```
//! use reseflow_lie::{SE3, BodyTwist, Vector3};
//!
//! let world_from_gripper = SE3::exp(&BodyTwist::new(Vector3::new(0.1, 0.2, 0.3), Vector3::new(1.0, 0.0, 0.0)));
//! let world_from_goal = world_from_gripper.plus(&BodyTwist::new(Vector3::z(), Vector3::x()));
//! let gripper_to_goal = world_from_gripper.body_twist_to(&world_from_goal);
//! assert!((gripper_to_goal.angular - Vector3::z()).norm() < 1e-12);
//! ```

mod coefficients;
mod error;
mod geodesic;
mod gram_schmidt;
mod mean;
mod metric;
mod products;
mod sampling;
mod se3;
mod se3_jacobian;
mod so3;
mod so3_jacobian;
mod twist;

pub use nalgebra::{self, Matrix3, Matrix4, Matrix6, Vector3, Vector6};

pub use error::LieError;
pub use metric::{GeodesicDistance, geodesic_distance};
pub use se3::SE3;
pub use so3::SO3;
pub use twist::{BodyTwist, SpatialTwist};
