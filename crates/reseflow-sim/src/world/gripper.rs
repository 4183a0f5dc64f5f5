//! The two-finger gripper: its geometry, its mass, and the forces that move its fingers.
//!
//! Each finger slides on a prismatic joint along the gripper's y axis. Two clamped spring-dampers act on the fingers'
//! mean distance (the opening) and on their difference (which stays zero: the fingers are kept centred); the palm takes
//! the reaction. Opening 0 asks for more than an object between the pads lets happen, so the grip force saturates.

use glamx::Vec3;
use nalgebra::{Matrix3, Vector3};
use rapier3d::prelude::{
    ColliderBuilder, MassProperties, PhysicsWorld, PrismaticJointBuilder, RigidBodyBuilder, RigidBodyHandle,
};
use reseflow_data::Shape;
use reseflow_lie::{SE3, SO3};

use crate::convert::pose_from_se3;
use crate::world::settings::PhysicsSettings;

/// The gap between the pads at opening 1, metres.
pub const MAX_GAP_M: f64 = 0.10;
/// How far the pads reach beyond the gripper's origin along z, metres.
pub const TIP_BEYOND_ORIGIN_M: f64 = 0.008;

/// Half of each edge of a finger, metres.
const FINGER_HALF_M: [f64; 3] = [0.010, 0.005, 0.039];
/// Half of each edge of the palm, metres.
const PALM_HALF_M: [f64; 3] = [0.022, 0.068, 0.025];
/// Where the palm's centre lies on the gripper's z axis, metres.
const PALM_CENTER_Z_M: f64 = TIP_BEYOND_ORIGIN_M - 2.0 * FINGER_HALF_M[2] - PALM_HALF_M[2];
/// Where a finger's centre lies on the gripper's z axis, metres.
const FINGER_CENTER_Z_M: f64 = TIP_BEYOND_ORIGIN_M - FINGER_HALF_M[2];
const PALM_MASS_KG: f64 = 0.8;
const FINGER_MASS_KG: f64 = 0.2;
/// The natural frequency of the critically damped fingers, rad/s.
const FINGER_RATE_RAD_S: f64 = 70.0;

/// The orientation that approaches along `approach` and closes along `close`: orthogonal directions of unit length.
pub(crate) fn orientation(approach: &Vector3<f64>, close: &Vector3<f64>) -> SO3 {
    let along = close.cross(approach);
    // Columns orthonormal where the arguments are.
    SO3::from_matrix(&Matrix3::from_columns(&[along, *close, *approach])).unwrap_or_else(|_| SO3::identity())
}

/// The bodies of the gripper.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Gripper {
    /// The palm; its frame is the gripper's frame.
    pub(crate) palm: RigidBodyHandle,
    /// The fingers on the sides of +y and −y; the origin of each is the centre of its pad's face.
    pub(crate) fingers: [RigidBodyHandle; 2],
}

/// What the carriage must know about the mass that it moves.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MovedMass {
    /// Palm and fingers together, kilograms.
    pub(crate) mass_kg: f64,
    /// Their common centre of mass on the gripper's z axis, metres.
    pub(crate) center_z_m: f64,
    /// Their moments of inertia about that centre and the gripper's axes, kg m², with the fingers half open.
    pub(crate) inertia: [f64; 3],
}

/// Moments of inertia of a box about its centre.
fn box_inertia(mass: f64, half: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = half.map(|h| h * h);
    [y + z, x + z, x + y].map(|sum| mass / 3.0 * sum)
}

/// The mass that the carriage moves.
pub(crate) fn moved_mass() -> MovedMass {
    let mass_kg = PALM_MASS_KG + 2.0 * FINGER_MASS_KG;
    let center_z_m = (PALM_MASS_KG * PALM_CENTER_Z_M + 2.0 * FINGER_MASS_KG * FINGER_CENTER_Z_M) / mass_kg;
    let mut inertia = [0.0; 3];
    let offset_y = 0.25 * MAX_GAP_M + FINGER_HALF_M[1];
    let parts = [
        (PALM_MASS_KG, PALM_HALF_M, 0.0, PALM_CENTER_Z_M),
        (FINGER_MASS_KG, FINGER_HALF_M, offset_y, FINGER_CENTER_Z_M),
        (FINGER_MASS_KG, FINGER_HALF_M, -offset_y, FINGER_CENTER_Z_M),
    ];
    for (mass, half, y, z) in parts {
        let own = box_inertia(mass, half);
        let (yy, zz) = (y * y, (z - center_z_m) * (z - center_z_m));
        for (axis, steiner) in [yy + zz, zz, yy].into_iter().enumerate() {
            inertia[axis] += own[axis] + mass * steiner;
        }
    }
    MovedMass { mass_kg, center_z_m, inertia }
}

/// What the gripper looks like: name, body, shape, where its centre lies in that body.
pub(crate) fn drawn_parts(gripper: &Gripper) -> [(&'static str, RigidBodyHandle, Shape, Vec3); 3] {
    let [y, z] = [FINGER_HALF_M[1] as f32, FINGER_CENTER_Z_M as f32];
    let finger = || Shape::Box { half_extents_m: FINGER_HALF_M };
    [
        (
            "gripper_palm",
            gripper.palm,
            Shape::Box { half_extents_m: PALM_HALF_M },
            Vec3::new(0.0, 0.0, PALM_CENTER_Z_M as f32),
        ),
        ("gripper_finger_left", gripper.fingers[0], finger(), Vec3::new(0.0, y, z)),
        ("gripper_finger_right", gripper.fingers[1], finger(), Vec3::new(0.0, -y, z)),
    ]
}

/// The corners of palm and open fingers, gripper frame, metres: what must be clear of everything at a start.
pub(crate) fn corners() -> impl Iterator<Item = Vector3<f64>> {
    let finger_y = 0.5 * MAX_GAP_M + FINGER_HALF_M[1];
    let boxes = [
        (0.0, PALM_CENTER_Z_M, PALM_HALF_M),
        (finger_y, FINGER_CENTER_Z_M, FINGER_HALF_M),
        (-finger_y, FINGER_CENTER_Z_M, FINGER_HALF_M),
    ];
    let signs = |corner: usize| [0, 1, 2].map(|axis| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 });
    boxes.into_iter().flat_map(move |(y, z, half)| {
        (0..8).map(move |corner| {
            let sign = signs(corner);
            Vector3::new(sign[0] * half[0], y + sign[1] * half[1], z + sign[2] * half[2])
        })
    })
}

/// Builds a gripper, open, at `world_from_gripper`.
pub(crate) fn insert(
    physics: &mut PhysicsWorld,
    settings: &PhysicsSettings,
    world_from_gripper: &SE3,
) -> Gripper {
    let world_from_palm = pose_from_se3(world_from_gripper);
    let palm =
        physics.insert_body(floating_body(world_from_palm, PALM_MASS_KG, PALM_HALF_M, PALM_CENTER_Z_M, 0.0));
    let fingers = [1.0_f32, -1.0].map(|side| {
        let offset = Vec3::Y * (side * 0.5 * MAX_GAP_M as f32);
        let world_from_finger = world_from_palm.prepend_translation(offset);
        let center_y = f64::from(side) * FINGER_HALF_M[1];
        let finger = physics.insert_body(floating_body(
            world_from_finger,
            FINGER_MASS_KG,
            FINGER_HALF_M,
            FINGER_CENTER_Z_M,
            center_y,
        ));
        let joint = PrismaticJointBuilder::new(Vec3::Y * side)
            .limits([0.0, 0.5 * MAX_GAP_M as f32 + 0.002])
            .contacts_enabled(false);
        physics.insert_impulse_joint(palm, finger, joint.build());
        finger
    });
    let gripper = Gripper { palm, fingers };
    for (_, body, shape, center) in drawn_parts(&gripper) {
        if let Shape::Box { half_extents_m: [x, y, z] } = shape {
            let collider = ColliderBuilder::cuboid(x as f32, y as f32, z as f32)
                .translation(center)
                .density(0.0)
                .friction(settings.pad_friction as f32)
                .friction_combine_rule(rapier3d::prelude::CoefficientCombineRule::Max);
            physics.insert_collider(collider.build(), Some(body));
        }
    }
    gripper
}

/// A body that no gravity pulls at, with the mass of a box.
fn floating_body(
    pose: glamx::Pose3,
    mass: f64,
    half: [f64; 3],
    center_z: f64,
    center_y: f64,
) -> rapier3d::prelude::RigidBody {
    let inertia = box_inertia(mass, half).map(|moment| moment as f32);
    let center = Vec3::new(0.0, center_y as f32, center_z as f32);
    RigidBodyBuilder::dynamic()
        .pose(pose)
        .gravity_scale(0.0)
        .can_sleep(false)
        .ccd_enabled(true)
        .additional_mass_properties(MassProperties::new(center, mass as f32, Vec3::from_array(inertia)))
        .build()
}

/// The distances of the two pads from the gripper's mid-plane, metres, and their rates, m/s.
fn finger_state(physics: &PhysicsWorld, gripper: &Gripper) -> [(f64, f64); 2] {
    let palm = &physics.bodies[gripper.palm];
    let axis = palm.rotation() * Vec3::Y;
    [(0, 1.0_f32), (1, -1.0)].map(|(index, side)| {
        let finger = &physics.bodies[gripper.fingers[index]];
        let offset = finger.translation() - palm.translation();
        let relative =
            finger.velocity_at_point(finger.translation()) - palm.velocity_at_point(finger.translation());
        (f64::from(side * axis.dot(offset)), f64::from(side * axis.dot(relative)))
    })
}

/// The reached opening: the gap between the pads over [`MAX_GAP_M`].
pub(crate) fn opening(physics: &PhysicsWorld, gripper: &Gripper) -> f64 {
    let [(left, _), (right, _)] = finger_state(physics, gripper);
    ((left + right) / MAX_GAP_M).clamp(0.0, 1.0)
}

/// Adds the finger forces for one physics step: follow `opening`, which changes at `opening_rate` per second.
pub(crate) fn add_finger_forces(
    physics: &mut PhysicsWorld,
    gripper: &Gripper,
    settings: &PhysicsSettings,
    opening: f64,
    opening_rate: f64,
) {
    let [(left, left_rate), (right, right_rate)] = finger_state(physics, gripper);
    let stiffness = FINGER_MASS_KG * FINGER_RATE_RAD_S * FINGER_RATE_RAD_S;
    let damping = 2.0 * FINGER_MASS_KG * FINGER_RATE_RAD_S;
    let limit = settings.grip_force_n;
    let mean_error = 0.5 * (opening * MAX_GAP_M - (left + right));
    let mean_rate_error = 0.5 * (opening_rate * MAX_GAP_M - (left_rate + right_rate));
    let open = (stiffness * mean_error + damping * mean_rate_error).clamp(-limit, limit);
    let difference = 0.5 * (stiffness * (left - right) + damping * (left_rate - right_rate));
    let center = (-difference).clamp(-limit, limit);

    let axis = physics.bodies[gripper.palm].rotation() * Vec3::Y;
    for (index, outward) in [(0, open + center), (1, center - open)] {
        let force = axis * outward as f32;
        let finger = &mut physics.bodies[gripper.fingers[index]];
        let at = finger.center_of_mass();
        finger.reset_forces(false);
        finger.reset_torques(false);
        finger.add_force(force, true);
        physics.bodies[gripper.palm].add_force_at_point(-force, at, true);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_orientation_has_its_axes_where_it_says() {
        let (approach, close) = (-Vector3::z(), Vector3::new(0.7_f64.cos(), 0.7_f64.sin(), 0.0));
        let rotation = orientation(&approach, &close);
        assert!((rotation.act(&Vector3::y()) - close).norm() < 1e-12);
        assert!((rotation.act(&Vector3::z()) - approach).norm() < 1e-12);
    }
}
