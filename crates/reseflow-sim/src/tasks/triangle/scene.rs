//! A running triangle scene: the prism, its measure, its judge.

use std::f64::consts::FRAC_PI_2;

use nalgebra::Vector3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rapier3d::prelude::{CoefficientCombineRule, ColliderBuilder, RigidBodyBuilder};
use reseflow_data::{
    Action, Contact, EpisodeKey, Halt, Observation, Outcome, Policy, Scene, SceneBody, TaskError, Tick,
};
use reseflow_lie::{SE3, SO3};

use super::setup::TriangleSetup;
use super::{POINTS, TriangleGoal, TriangleTask, expert};
use crate::convert::point3;
use crate::expert::{Expert, Glance, Script, Watch};
use crate::mesh::prism;
use crate::tabletop::{ACTION_STEPS, Tabletop};
use crate::world::{Object, World};

/// The prism's height, metres.
pub(super) const HEIGHT_M: f64 = 0.025;
pub(super) const DENSITY_KG_M3: f64 = 1200.0;
const FRICTION: f32 = 0.4;
/// The coloured corner takes up this share of the median through it.
const CORNER_SHARE: f64 = 0.45;

const GOAL_TOLERANCE_M: f64 = 0.03;
/// Held between the pads the prism tilts with the gripper; beyond this it counts as tipped over.
const TILT_LIMIT_RAD: f64 = 0.3;

/// A running scene.
pub(super) struct TriangleScene {
    table: Tabletop,
    setup: TriangleSetup,
    goal: TriangleGoal,
    /// The expert's turn, radians.
    turn_rad: f64,
    triangle: Object,
    /// Where it was when the task began: at the start, or where a shove has left it.
    start: SE3,
    /// Set by a shove, until the gripper touches the prism again.
    shoved: bool,
    watch: Watch,
}

impl TriangleScene {
    pub(super) fn new(
        task: &TriangleTask,
        setup: TriangleSetup,
        key: &EpisodeKey,
    ) -> Result<Self, TaskError> {
        let fault = |reason: &str| TaskError {
            task: task.goal.task_name().to_owned(),
            index: key.index,
            reason: reason.to_owned(),
        };
        let mut world = World::new(task.physics, &setup.world_from_gripper, setup.table_color);
        let radius = setup.circumradius_m();
        let half = 0.5 * setup.side_m;
        let corners = [[radius, 0.0], [-0.5 * radius, half], [-0.5 * radius, -half]];

        let start = SE3::new(
            SO3::exp(&(Vector3::z() * setup.yaw_rad)),
            Vector3::new(setup.center_m[0], setup.center_m[1], 0.5 * HEIGHT_M),
        );
        let hull: Vec<_> = [-0.5 * HEIGHT_M, 0.5 * HEIGHT_M]
            .into_iter()
            .flat_map(|z| corners.map(|[x, y]| point3(&[x, y, z])))
            .collect();
        let collider = ColliderBuilder::convex_hull(&hull)
            .ok_or_else(|| fault("expected a triangle of positive size, got one without volume"))?
            .density(DENSITY_KG_M3 as f32)
            .friction(FRICTION)
            .friction_combine_rule(CoefficientCombineRule::Max);
        let body = RigidBodyBuilder::dynamic().can_sleep(false);
        let triangle = world.add_object("triangle", &start, body, vec![collider.build()]);

        // The cut between the coloured corner and the rest, across the median.
        let cut_x = radius - CORNER_SHARE * 1.5 * radius;
        let cut_y = CORNER_SHARE * half;
        let (bottom, top) = (-0.5 * HEIGHT_M, 0.5 * HEIGHT_M);
        let corner = prism(&[corners[0], [cut_x, cut_y], [cut_x, -cut_y]], bottom, top);
        let rest = prism(&[[cut_x, cut_y], corners[1], corners[2], [cut_x, -cut_y]], bottom, top);
        world.add_object_part("triangle", triangle, rest, setup.body_color);
        world.add_object_part("triangle_corner", triangle, corner, setup.corner_color);

        let points = task.camera.points.unwrap_or(POINTS);
        let table = Tabletop::new(world, setup.camera.clone(), task.camera, key.clone(), points);
        Ok(Self {
            table,
            setup,
            goal: task.goal,
            turn_rad: task.goal.turn_rad(key),
            triangle,
            start,
            shoved: false,
            watch: Watch::new(start),
        })
    }
}

impl TriangleScene {
    /// What writes the script of an expert that turns by `turn_rad`.
    fn writer(&self, turn_rad: f64) -> impl Fn(&Glance, &SE3, usize) -> Option<Script> + use<> {
        let radius_m = self.setup.circumradius_m();
        move |glance, world_from_gripper, steps| {
            expert::script(glance, world_from_gripper, steps, radius_m, turn_rad)
        }
    }
}

/// Whether the gripper touches the prism.
fn gripper_touches_triangle(contacts: &[Contact]) -> bool {
    // The names of a contact are sorted.
    contacts.iter().any(|contact| contact.body_a.starts_with("gripper") && contact.body_b == "triangle")
}

/// How far the prism's yaw is from its start, radians, on the goal's branch.
fn turned_rad(world: &World, triangle: Object, start: &SE3, goal: TriangleGoal) -> f64 {
    let now = world.world_from_object(triangle);
    let corner = start.rotation.inverse().act(&now.rotation.act(&Vector3::x()));
    goal.branch(corner.y.atan2(corner.x))
}

impl Scene for TriangleScene {
    fn observe(&mut self) -> Observation {
        self.table.observe()
    }

    fn tick(&mut self, command: &Action) -> Result<Tick, Halt> {
        let (triangle, start, goal) = (self.triangle, self.start, self.goal);
        let tick = self.table.tick(command, |world| turned_rad(world, triangle, &start, goal))?;
        let object = self.table.world.world_from_object(triangle);
        self.shoved &= !gripper_touches_triangle(&tick.contacts);
        if self.shoved {
            self.start = object;
        }
        self.watch.set(Glance { start: self.start, object });
        Ok(tick)
    }

    fn bodies(&self) -> Vec<SceneBody> {
        self.table.bodies()
    }

    fn judge(&mut self) -> Outcome {
        let halt = self.table.hold_still();
        let measure = turned_rad(&self.table.world, self.triangle, &self.start, self.goal);
        let now = self.table.world.world_from_object(self.triangle);
        // A prism that stands on a side face has not been turned, whatever its yaw.
        let tilt_rad = now.rotation.act(&Vector3::z()).angle(&Vector3::z());
        let off_m = (now.translation - self.start.translation).norm();
        let reached =
            self.goal.is_reached(measure) && off_m <= GOAL_TOLERANCE_M && tilt_rad <= TILT_LIMIT_RAD;
        Outcome { success: halt.is_none() && reached, measure, measure_name: "turned_rad".to_owned(), halt }
    }

    fn expert(&self) -> Box<dyn Policy> {
        Box::new(Expert::new(self.watch.clone(), expert::TOLERANCE, self.writer(self.turn_rad)))
    }

    fn alternative(&self) -> Option<Vec<SE3>> {
        let turn_rad = self.goal.other_turn_rad(self.turn_rad)?;
        let script = self.writer(turn_rad)(&self.watch.get(), &self.setup.world_from_gripper, ACTION_STEPS)?;
        Some(script.actions.into_iter().map(|command| command.world_from_gripper).collect())
    }

    fn disturb(&mut self, seed: u64) {
        // Out from between the fingers, along the pads, towards the table's middle: friction stops it after about 8 cm.
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let aside = SO3::exp(&(Vector3::z() * FRAC_PI_2)).act(&self.start.rotation.act(&Vector3::x()));
        let inwards = if aside.dot(&self.start.translation) > 0.0 { -aside } else { aside };
        let direction = SO3::exp(&(Vector3::z() * rng.random_range(-0.3..=0.3))).act(&inwards);
        let speed_m_s: f64 = rng.random_range(0.78..=0.86);
        let mass_kg = self.setup.mass_kg();
        let yaw_impulse_nm_s = rng.random_range(-4e-4..=4e-4) * mass_kg;
        self.table.world.push(self.triangle, direction * (mass_kg * speed_m_s), yaw_impulse_nm_s);
        self.shoved = true;
    }
}
