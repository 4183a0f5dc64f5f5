//! A brush in the gripper: a stiff handle that ends in springy bristles.
//!
//! The handle is a body of its own, set into the palm by a fixed joint, with the fingers closed around it. The bristles
//! have no mass: over their free length, a ray along the handle finds the surface that they are pressed against, and
//! 200 N per metre of compression push back along that surface's normal, with friction against the tip's sliding. The
//! surface's body gets the opposite force. A compression beyond the bristles' length is the stiff handle's business.

use glamx::Vec3;
use nalgebra::Vector3;
use parry3d::query::Ray;
use rapier3d::prelude::{
    CoefficientCombineRule, ColliderBuilder, FixedJointBuilder, MassProperties, PhysicsWorld, QueryFilter,
    RigidBodyBuilder, RigidBodyHandle,
};
use reseflow_data::{Contact, Shape};

use crate::camera::Surface;
use crate::convert::vector3;
use crate::world::gripper::{MAX_GAP_M, TIP_BEYOND_ORIGIN_M};
use crate::world::{Object, Role, World};

/// How stiff the bristles are, newtons per metre.
pub(crate) const STIFFNESS_N_PER_M: f64 = 200.0;
/// How long the bristles are when nothing presses them, metres.
pub(crate) const BRISTLES_M: f64 = 0.015;
/// Where the bristles end on the gripper's z axis, metres, when nothing presses them.
pub(crate) const TIP_Z_M: f64 = TIP_BEYOND_ORIGIN_M + 0.067;

/// Where the handle begins on the gripper's z axis: at the palm.
const HANDLE_FROM_Z_M: f64 = TIP_BEYOND_ORIGIN_M - 0.078;
/// Half of the handle's thickness, metres; along y the pads lie against it.
const HANDLE_HALF_M: f64 = 0.007;
/// The fingers' distance from the handle at the start, metres.
const START_GAP_M: f64 = 1e-4;
const MASS_KG: f64 = 0.03;
const SLIDING_FRICTION: f64 = 0.3;
/// Below this speed of the tip the friction is proportional to it, m/s.
const CREEP_M_S: f64 = 0.02;

/// A touch of the bristles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Touch {
    /// The touched object, `None` for the table.
    pub(crate) object: Option<Object>,
    /// Where: in the object's frame, or in the world's for the table, metres.
    pub(crate) point_m: Vector3<f64>,
    /// How far the bristles are compressed, metres.
    pub(crate) compression_m: f64,
    world_point: Vec3,
    /// Out of the touched surface.
    normal: Vec3,
    body: RigidBodyHandle,
}

/// A brush and what it touched.
#[derive(Debug)]
pub(crate) struct Brush {
    body: RigidBodyHandle,
    /// Bodies that the bristles do not meet: the robot's own.
    own: [RigidBodyHandle; 4],
    touches: Vec<Touch>,
    compressions_m: Vec<f64>,
    unfinished: Vec<Touch>,
    latest: Option<Touch>,
}

impl Brush {
    /// What the bristles touch now.
    fn touch(&self, physics: &PhysicsWorld, objects: &[RigidBodyHandle]) -> Option<Touch> {
        let handle = physics.bodies[self.body].position();
        let direction = handle.rotation * Vec3::Z;
        let root = handle.transform_point(Vec3::Z * (TIP_Z_M - BRISTLES_M) as f32);
        let strange = |_, collider: &rapier3d::prelude::Collider| {
            collider.parent().is_none_or(|body| !self.own.contains(&body))
        };
        let filter = QueryFilter { predicate: Some(&strange), ..QueryFilter::default() };
        let ray = Ray::new(root, direction);
        let (collider, hit) = physics.cast_ray_and_get_normal(&ray, BRISTLES_M as f32, true, filter)?;
        let body = physics.colliders[collider].parent()?;
        let object = objects.iter().position(|&object| object == body).map(Object);
        let world_point = ray.point_at(hit.time_of_impact);
        let in_body = physics.bodies[body].position().inverse_transform_point(world_point);
        // A root that has sunk in has no surface before it; the bristles push straight back.
        let normal = if hit.normal.length_squared() > 0.5 { hit.normal } else { -direction };
        Some(Touch {
            object,
            point_m: vector3(if object.is_some() { in_body } else { world_point }),
            compression_m: BRISTLES_M - f64::from(hit.time_of_impact),
            world_point,
            normal,
            body,
        })
    }

    /// Adds the bristles' forces for one physics step.
    pub(super) fn add_forces(&mut self, physics: &mut PhysicsWorld, objects: &[RigidBodyHandle]) {
        for &body in objects.iter().chain([&self.body]) {
            physics.bodies[body].reset_forces(false);
            physics.bodies[body].reset_torques(false);
        }
        let Some(touch) = self.touch(physics, objects) else { return };
        let press = (STIFFNESS_N_PER_M * touch.compression_m) as f32;
        let at = touch.world_point;
        let velocity = physics.bodies[self.body].velocity_at_point(at)
            - physics.bodies[touch.body].velocity_at_point(at);
        let sliding = velocity - touch.normal * velocity.dot(touch.normal);
        let speed = sliding.length().max(CREEP_M_S as f32);
        let force = touch.normal * press - sliding * (SLIDING_FRICTION as f32 * press / speed);
        physics.bodies[self.body].add_force_at_point(force, at, true);
        physics.bodies[touch.body].add_force_at_point(-force, at, true);
        self.unfinished.push(touch);
    }

    /// Keeps the touches of a control tick that has ended well.
    pub(super) fn end_tick(&mut self, physics: &PhysicsWorld, objects: &[RigidBodyHandle]) {
        self.touches.append(&mut self.unfinished);
        self.latest = self.touch(physics, objects);
        self.compressions_m.push(self.latest.map_or(0.0, |touch| touch.compression_m));
    }

    /// The handle.
    pub(super) fn body(&self) -> RigidBodyHandle {
        self.body
    }

    /// Every touch so far, one for each physics step in which there was one.
    pub(crate) fn touches(&self) -> &[Touch] {
        &self.touches
    }

    /// The compression at the end of each control tick, metres, 0 where nothing is touched.
    pub(crate) fn compressions_m(&self) -> &[f64] {
        &self.compressions_m
    }
}

impl World {
    /// Sets a brush with bristles of the given colour into the palm and closes the fingers around its handle.
    ///
    /// To be called before [`World::finish_setup`], once.
    pub(crate) fn add_brush(&mut self, bristle_color: [u8; 3]) {
        let world_from_gripper = *self.physics.bodies[self.gripper.palm].position();
        let root_z = TIP_Z_M - BRISTLES_M;
        let center = Vec3::Z * (0.5 * (HANDLE_FROM_Z_M + root_z)) as f32;
        let half = [HANDLE_HALF_M, HANDLE_HALF_M, 0.5 * (root_z - HANDLE_FROM_Z_M)];
        let moment = |a: f64, b: f64| (MASS_KG / 3.0 * (a * a + b * b)) as f32;
        let inertia = Vec3::new(moment(half[1], half[2]), moment(half[0], half[2]), moment(half[0], half[1]));
        let body = self.physics.insert_body(
            RigidBodyBuilder::dynamic()
                .pose(world_from_gripper)
                .gravity_scale(0.0)
                .can_sleep(false)
                .ccd_enabled(true)
                .additional_mass_properties(MassProperties::new(center, MASS_KG as f32, inertia)),
        );
        let [x, y, z] = half.map(|h| h as f32);
        let collider = ColliderBuilder::cuboid(x, y, z)
            .translation(center)
            .density(0.0)
            .friction(SLIDING_FRICTION as f32)
            .friction_combine_rule(CoefficientCombineRule::Max);
        self.physics.insert_collider(collider, Some(body));
        let joint = FixedJointBuilder::new().contacts_enabled(false);
        self.physics.insert_impulse_joint(self.gripper.palm, body, joint.build());
        self.close_fingers(2.0 * (HANDLE_HALF_M + START_GAP_M));

        self.name_body(body, "gripper_brush");
        let at = |z: f64| glamx::Pose3::from_translation(Vec3::Z * z as f32);
        let handle = Shape::Box { half_extents_m: half };
        self.add_part("gripper_brush", Role::Gripper, body, at(f64::from(center.z)), handle, [150, 116, 78]);
        let bristles = Shape::Box { half_extents_m: [0.004, 0.004, 0.5 * BRISTLES_M] };
        let middle = at(TIP_Z_M - 0.5 * BRISTLES_M);
        self.add_part("gripper_bristles", Role::Gripper, body, middle, bristles, bristle_color);

        let [left, right] = self.gripper.fingers;
        self.brush = Some(Brush {
            body,
            own: [body, self.gripper.palm, left, right],
            touches: Vec::new(),
            compressions_m: Vec::new(),
            unfinished: Vec::new(),
            latest: None,
        });
        if let Some(snapshot) = self.take_snapshot() {
            self.snapshot = snapshot;
        }
        self.command.opening = self.snapshot.opening;
    }

    /// Places the fingers, before time runs, with a gap between the pads, metres.
    fn close_fingers(&mut self, gap_m: f64) {
        debug_assert!(gap_m <= MAX_GAP_M);
        let world_from_gripper = *self.physics.bodies[self.gripper.palm].position();
        for (finger, side) in self.gripper.fingers.into_iter().zip([0.5, -0.5]) {
            let offset = Vec3::Y * (side * gap_m) as f32;
            self.physics.bodies[finger].set_position(world_from_gripper.prepend_translation(offset), true);
        }
    }

    /// The brush, where there is one.
    pub(crate) fn brush(&self) -> Option<&Brush> {
        self.brush.as_ref()
    }

    /// The bristles' touch as a contact report. A spring does not sink in: its depth is 0.
    pub(super) fn brush_contact(&self, name_of: impl Fn(u128) -> String) -> Option<Contact> {
        let brush = self.brush.as_ref()?;
        let touch = brush.latest?;
        let name = |body: RigidBodyHandle| {
            let collider = self.physics.bodies[body].colliders().first()?;
            Some(name_of(self.physics.colliders[*collider].user_data))
        };
        let (mut body_a, mut body_b) = (name(brush.body)?, name(touch.body)?);
        if body_b < body_a {
            std::mem::swap(&mut body_a, &mut body_b);
        }
        let point_m = touch.world_point.to_array().map(f64::from);
        let force_n = STIFFNESS_N_PER_M * touch.compression_m;
        Some(Contact { body_a, body_b, point_m, force_n, depth_m: 0.0 })
    }

    /// Gives an object a visible piece, or a new shape to its piece of that name: what grows on it, as paint does.
    pub(crate) fn show_object_part(&mut self, name: &str, object: Object, shape: Shape, color: [u8; 3]) {
        match self.parts.iter_mut().find(|part| part.name == name) {
            Some(part) => {
                // Without a triangle there is nothing new to see.
                let Some(surface) = Surface::new(&shape) else { return };
                (part.shape, part.surface) = (shape, surface);
            }
            None => self.add_object_part(name, object, shape, color),
        }
    }
}
