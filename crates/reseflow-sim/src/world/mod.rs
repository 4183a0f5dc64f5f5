//! The physical world: table, gripper, what a task puts there, and one control tick of time.

pub(crate) mod brush;
mod carriage;
mod contacts;
pub mod gripper;
pub(crate) mod hinge;
pub(crate) mod settings;

use glamx::{Pose3, Vec3};
use nalgebra::Vector3;
use rapier3d::prelude::{
    CoefficientCombineRule, Collider, ColliderBuilder, PhysicsWorld, RigidBodyBuilder, RigidBodyHandle,
};
use reseflow_data::{Action, Contact, Halt, SceneBody, Shape};
use reseflow_lie::SE3;

use crate::camera::Surface;
use crate::convert::{pose_from_se3, se3_from_pose, vec3};
use brush::Brush;
use gripper::Gripper;
use settings::PhysicsSettings;

/// Half of the table's width and depth, metres. Its top is the plane z = 0.
pub(crate) const TABLE_HALF_M: f64 = 0.45;
const TABLE_HALF_THICKNESS_M: f64 = 0.02;
const TABLE_FRICTION: f32 = 0.4;
/// Commands must lie in this box, metres.
const REACH_LOW_M: [f64; 3] = [-0.5, -0.5, -0.03];
const REACH_HIGH_M: [f64; 3] = [0.5, 0.5, 0.7];
/// A gripper further from its command than this has lost it (something holds it, or the command jumped).
const LOST_M: f64 = 0.15;
const LOST_RAD: f64 = 1.0;
/// At the start the gripper may not overlap anything by more than this.
const START_OVERLAP_M: f64 = 5e-4;

/// What a part of the world belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Role {
    /// The table.
    Table,
    /// The robot's own body.
    Gripper,
    /// Anything that a task brings.
    Object,
}

/// A visible rigid piece.
pub(crate) struct Part {
    pub(crate) name: String,
    pub(crate) role: Role,
    pub(crate) shape: Shape,
    pub(crate) surface: Surface,
    pub(crate) color: [u8; 3],
    body: RigidBodyHandle,
    body_from_part: Pose3,
}

/// A body that a task put on the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Object(usize);

/// What can be seen and measured of the world at the end of a good tick.
#[derive(Debug, Clone)]
struct Snapshot {
    world_from_gripper: SE3,
    opening: f64,
    world_from_part: Vec<Pose3>,
    world_from_object: Vec<SE3>,
}

/// The physical world.
pub(crate) struct World {
    physics: PhysicsWorld,
    settings: PhysicsSettings,
    gripper: Gripper,
    brush: Option<Brush>,
    parts: Vec<Part>,
    body_names: Vec<String>,
    objects: Vec<RigidBodyHandle>,
    snapshot: Snapshot,
    command: Action,
    starts_in_collision: bool,
}

impl World {
    /// A table and a gripper, open, at `world_from_gripper`.
    pub(crate) fn new(settings: PhysicsSettings, world_from_gripper: &SE3, table_color: [u8; 3]) -> World {
        let mut physics = PhysicsWorld::new();
        physics.gravity = Vec3::new(0.0, 0.0, -9.81);
        physics.integration_parameters = settings.integration_parameters();
        let gripper = gripper::insert(&mut physics, &settings, world_from_gripper);
        let command = Action { world_from_gripper: *world_from_gripper, opening: 1.0 };
        let snapshot = Snapshot {
            world_from_gripper: *world_from_gripper,
            opening: 1.0,
            world_from_part: Vec::new(),
            world_from_object: Vec::new(),
        };
        let mut world = World {
            physics,
            settings,
            gripper,
            brush: None,
            parts: Vec::new(),
            body_names: Vec::new(),
            objects: Vec::new(),
            snapshot,
            command,
            starts_in_collision: false,
        };
        world.add_table(table_color);
        for (name, body, shape, center) in gripper::drawn_parts(&gripper) {
            world.name_body(body, name);
            let color = if name == "gripper_palm" { [70, 74, 82] } else { [150, 154, 160] };
            world.add_part(name, Role::Gripper, body, Pose3::from_translation(center), shape, color);
        }
        world
    }

    fn add_table(&mut self, color: [u8; 3]) {
        let half = [TABLE_HALF_M, TABLE_HALF_M, TABLE_HALF_THICKNESS_M];
        let collider = ColliderBuilder::cuboid(half[0] as f32, half[1] as f32, half[2] as f32)
            .friction(TABLE_FRICTION)
            .friction_combine_rule(CoefficientCombineRule::Max);
        let pose = Pose3::from_translation(Vec3::new(0.0, 0.0, -TABLE_HALF_THICKNESS_M as f32));
        let (body, _) = self.physics.insert(RigidBodyBuilder::fixed().pose(pose).build(), collider.build());
        self.name_body(body, "table");
        self.add_part(
            "table",
            Role::Table,
            body,
            Pose3::IDENTITY,
            Shape::Box { half_extents_m: half },
            color,
        );
    }

    /// Puts a body on the table. An object that falls off or leaves the table ends the episode.
    pub(crate) fn add_object(
        &mut self,
        name: &str,
        world_from_object: &SE3,
        body: RigidBodyBuilder,
        colliders: Vec<Collider>,
    ) -> Object {
        let handle = self.physics.insert_body(body.pose(pose_from_se3(world_from_object)).build());
        for collider in colliders {
            self.physics.insert_collider(collider, Some(handle));
        }
        self.name_body(handle, name);
        self.objects.push(handle);
        self.snapshot.world_from_object.push(*world_from_object);
        Object(self.objects.len() - 1)
    }

    /// Gives a body a visible piece, whose frame is the body's.
    pub(crate) fn add_object_part(&mut self, name: &str, object: Object, shape: Shape, color: [u8; 3]) {
        self.add_object_part_at(name, object, Vector3::zeros(), shape, color);
    }

    /// Gives a body a visible piece that stands at `center_m` in the body's frame, axes alike.
    pub(crate) fn add_object_part_at(
        &mut self,
        name: &str,
        object: Object,
        center_m: Vector3<f64>,
        shape: Shape,
        color: [u8; 3],
    ) {
        let body_from_part = Pose3::from_translation(vec3(&center_m));
        self.add_part(name, Role::Object, self.objects[object.0], body_from_part, shape, color);
    }

    fn add_part(
        &mut self,
        name: &str,
        role: Role,
        body: RigidBodyHandle,
        body_from_part: Pose3,
        shape: Shape,
        color: [u8; 3],
    ) {
        // A mesh that no ray can be cast at (no triangle) cannot be seen either.
        let Some(surface) = Surface::new(&shape) else { return };
        self.snapshot.world_from_part.push(*self.physics.bodies[body].position() * body_from_part);
        self.parts.push(Part { name: name.to_owned(), role, shape, surface, color, body, body_from_part });
    }

    fn name_body(&mut self, body: RigidBodyHandle, name: &str) {
        let index = self.body_names.len() as u128;
        self.body_names.push(name.to_owned());
        for &collider in self.physics.bodies[body].colliders() {
            self.physics.colliders[collider].user_data = index;
        }
    }

    /// To be called when everything is in place: notes whether the gripper overlaps anything.
    pub(crate) fn finish_setup(&mut self) {
        // A step without time finds contacts and moves nothing.
        let dt = std::mem::replace(&mut self.physics.integration_parameters.dt, 0.0);
        self.physics.step();
        self.physics.integration_parameters.dt = dt;
        self.starts_in_collision = self.contacts().iter().any(|contact| {
            let gripper = contact.body_a.starts_with("gripper") || contact.body_b.starts_with("gripper");
            gripper && contact.depth_m > START_OVERLAP_M
        });
    }

    /// Follows `command` for one control tick.
    ///
    /// # Errors
    /// A named reason why the world cannot go on; what can be seen of it stays as it was.
    pub(crate) fn tick(&mut self, command: &Action) -> Result<(), Halt> {
        self.check(command)?;
        let start = self.command;
        let tick_secs = settings::TICK_NANOS as f64 * 1e-9;
        let rate = start.world_from_gripper.body_twist_to(&command.world_from_gripper) * (1.0 / tick_secs);
        let opening_rate = (command.opening - start.opening) / tick_secs;
        for substep in 0..self.settings.substeps {
            // Where the command is now, at the start of the substep: what the reached pose is compared with.
            let now = start.interpolate(command, substep as f64 / self.settings.substeps as f64);
            let palm = &mut self.physics.bodies[self.gripper.palm];
            palm.reset_forces(false);
            palm.reset_torques(false);
            carriage::add_wrench(
                &mut self.physics,
                &self.gripper,
                &self.settings,
                &now.world_from_gripper,
                &rate,
            );
            gripper::add_finger_forces(
                &mut self.physics,
                &self.gripper,
                &self.settings,
                now.opening,
                opening_rate,
            );
            if let Some(brush) = &mut self.brush {
                brush.add_forces(&mut self.physics, &self.objects);
            }
            self.physics.step();
        }
        let snapshot = self.take_snapshot().ok_or(Halt::Diverged)?;
        if snapshot.world_from_object.iter().any(left_the_table) {
            return Err(Halt::ObjectLost);
        }
        self.snapshot = snapshot;
        self.command = *command;
        if let Some(brush) = &mut self.brush {
            brush.end_tick(&self.physics, &self.objects);
        }
        Ok(())
    }

    /// Whether `command` can be followed from here.
    fn check(&self, command: &Action) -> Result<(), Halt> {
        if !(command.opening.is_finite() && command.world_from_gripper.is_finite()) {
            return Err(Halt::NonFiniteAction);
        }
        if self.starts_in_collision {
            return Err(Halt::StartsInCollision);
        }
        let position = command.world_from_gripper.translation;
        if (0..3).any(|axis| !(REACH_LOW_M[axis]..=REACH_HIGH_M[axis]).contains(&position[axis])) {
            return Err(Halt::OutOfReach);
        }
        let error =
            self.snapshot.world_from_gripper.product_displacement_to(&self.command.world_from_gripper);
        if error.linear.norm() > LOST_M || error.angular.norm() > LOST_RAD {
            return Err(Halt::LostTracking);
        }
        Ok(())
    }

    /// `None` where the engine left something that is no pose.
    fn take_snapshot(&self) -> Option<Snapshot> {
        let world_from_gripper = se3_from_pose(self.physics.bodies[self.gripper.palm].position())?;
        let world_from_part: Vec<Pose3> = self
            .parts
            .iter()
            .map(|part| *self.physics.bodies[part.body].position() * part.body_from_part)
            .collect();
        let world_from_object = self
            .objects
            .iter()
            .map(|&object| se3_from_pose(self.physics.bodies[object].position()))
            .collect::<Option<Vec<SE3>>>()?;
        let finite = world_from_part.iter().all(Pose3::is_finite);
        let opening = gripper::opening(&self.physics, &self.gripper);
        finite.then_some(Snapshot { world_from_gripper, opening, world_from_part, world_from_object })
    }

    /// Pushes an object with an impulse through its centre of mass, N s, and one about the vertical, N m s.
    pub(crate) fn push(&mut self, object: Object, impulse_n_s: Vector3<f64>, yaw_impulse_nm_s: f64) {
        let body = &mut self.physics.bodies[self.objects[object.0]];
        body.apply_impulse(vec3(&impulse_n_s), true);
        body.apply_torque_impulse(Vec3::Z * yaw_impulse_nm_s as f32, true);
    }

    /// Knocks the gripper: impulses that give all of it, and what it carries, a velocity in its own frame, m/s.
    pub(crate) fn knock(&mut self, velocity_m_s: Vector3<f64>) {
        let velocity = *self.physics.bodies[self.gripper.palm].rotation() * vec3(&velocity_m_s);
        for body in self.robot_bodies() {
            let body = &mut self.physics.bodies[body];
            body.apply_impulse(velocity * body.mass(), true);
        }
    }

    /// Palm, fingers, and the brush where there is one.
    fn robot_bodies(&self) -> impl Iterator<Item = RigidBodyHandle> + use<> {
        let [left, right] = self.gripper.fingers;
        [self.gripper.palm, left, right].into_iter().chain(self.brush.as_ref().map(Brush::body))
    }

    /// What touches what.
    pub(crate) fn contacts(&self) -> Vec<Contact> {
        let name_of = |index: u128| self.body_names.get(index as usize).cloned().unwrap_or_default();
        let mut contacts = contacts::report(&self.physics, name_of);
        contacts.extend(self.brush_contact(name_of));
        contacts
    }

    /// An object's pose.
    pub(crate) fn world_from_object(&self, object: Object) -> SE3 {
        self.snapshot.world_from_object[object.0]
    }

    /// The gripper's reached pose.
    pub(crate) fn world_from_gripper(&self) -> SE3 {
        self.snapshot.world_from_gripper
    }

    /// The gripper's reached opening.
    pub(crate) fn opening(&self) -> f64 {
        self.snapshot.opening
    }

    /// The command in force.
    pub(crate) fn command(&self) -> Action {
        self.command
    }

    /// The visible pieces and where they are.
    pub(crate) fn parts(&self) -> impl Iterator<Item = (&Part, &Pose3)> {
        self.parts.iter().zip(&self.snapshot.world_from_part)
    }

    /// Everything that can be drawn.
    pub(crate) fn bodies(&self) -> Vec<SceneBody> {
        let drawn = |(part, pose): (&Part, &Pose3)| {
            Some(SceneBody {
                name: part.name.clone(),
                shape: part.shape.clone(),
                color: part.color,
                world_from_body: se3_from_pose(pose)?,
            })
        };
        self.parts().filter_map(drawn).collect()
    }
}

/// Whether an object's origin is beyond the table's edge or under its top.
fn left_the_table(world_from_object: &SE3) -> bool {
    let at = world_from_object.translation;
    at.x.abs() > TABLE_HALF_M || at.y.abs() > TABLE_HALF_M || at.z < -TABLE_HALF_THICKNESS_M
}
