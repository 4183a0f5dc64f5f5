//! The carriage: a clamped PD wrench that makes the palm follow its command.
//!
//! Critically damped in position and orientation with velocity feed-forward, F = m (ω² e + 2ω ė) and
//! τ = I (ω² θ + 2ω θ̇), clamped to what a small arm can do. It pushes on the common centre of mass of palm and
//! fingers, so an unhindered gripper follows without turning.

use nalgebra::Vector3;
use rapier3d::prelude::PhysicsWorld;
use reseflow_lie::{BodyTwist, SE3};

use crate::convert::{se3_from_pose, vec3, vector3};
use crate::world::gripper::{Gripper, moved_mass};
use crate::world::settings::PhysicsSettings;

/// Adds the carriage's wrench for one physics step: follow `target`, which moves with the body twist `rate` (per second).
///
/// The palm's forces must have been reset before.
pub(crate) fn add_wrench(
    physics: &mut PhysicsWorld,
    gripper: &Gripper,
    settings: &PhysicsSettings,
    target: &SE3,
    rate: &BodyTwist,
) {
    let mass = moved_mass();
    let center = Vector3::new(0.0, 0.0, mass.center_z_m);
    let palm = &mut physics.bodies[gripper.palm];
    let Some(world_from_palm) = se3_from_pose(palm.position()) else { return };
    let stiffness = settings.carriage_rate_rad_s * settings.carriage_rate_rad_s;
    let damping = 2.0 * settings.carriage_rate_rad_s;

    let reached_center = world_from_palm.act(&center);
    let target_velocity = target.rotation.act(&(rate.linear + rate.angular.cross(&center)));
    let reached_velocity = vector3(palm.velocity_at_point(vec3(&reached_center)));
    let acceleration =
        (target.act(&center) - reached_center) * stiffness + (target_velocity - reached_velocity) * damping;

    let palm_from_target = world_from_palm.rotation.inverse() * target.rotation;
    let reached_rate = world_from_palm.rotation.inverse().act(&vector3(palm.angvel()));
    let angular =
        palm_from_target.log() * stiffness + (palm_from_target.act(&rate.angular) - reached_rate) * damping;
    let torque = angular.component_mul(&Vector3::from(mass.inertia));

    let force = clamp_norm(acceleration * mass.mass_kg, settings.carriage_force_n);
    let torque = world_from_palm.rotation.act(&clamp_norm(torque, settings.carriage_torque_nm));
    palm.add_force_at_point(vec3(&force), vec3(&reached_center), true);
    palm.add_torque(vec3(&torque), true);
}

/// Shortens `vector` to at most `limit`.
fn clamp_norm(vector: Vector3<f64>, limit: f64) -> Vector3<f64> {
    let norm = vector.norm();
    if norm > limit { vector * (limit / norm) } else { vector }
}
