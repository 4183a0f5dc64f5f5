//! A running triangle scene: the prism, its measure, its judge.

use std::f64::consts::TAU;

use nalgebra::Vector3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rapier3d::prelude::{CoefficientCombineRule, ColliderBuilder, RigidBodyBuilder};
use reseflow_data::{
    Action, EpisodeKey, Halt, Observation, Outcome, Policy, Scene, SceneBody, TaskError, Tick,
};
use reseflow_lie::{SE3, SO3};

use super::setup::TriangleSetup;
use super::{POINTS, TriangleGoal, TriangleTask, expert};
use crate::convert::point3;
use crate::mesh::prism;
use crate::scripted::Scripted;
use crate::tabletop::Tabletop;
use crate::world::{Object, World};

/// The prism's height, metres.
pub(super) const HEIGHT_M: f64 = 0.025;
const DENSITY_KG_M3: f32 = 1200.0;
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
    start: SE3,
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
            .density(DENSITY_KG_M3)
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

        let table = Tabletop::new(world, setup.camera.clone(), task.camera, key.clone(), POINTS);
        Ok(Self { table, setup, goal: task.goal, turn_rad: task.goal.turn_rad(key), triangle, start })
    }
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
        self.table.tick(command, |world| turned_rad(world, triangle, &start, goal))
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
        Box::new(Scripted::new("expert", expert::commands(&self.setup, self.turn_rad)))
    }

    fn alternative(&self) -> Option<Vec<SE3>> {
        let turn_rad = self.goal.other_turn_rad(self.turn_rad)?;
        let commands = expert::commands(&self.setup, turn_rad);
        Some(commands.into_iter().map(|command| command.world_from_gripper).collect())
    }

    fn disturb(&mut self, seed: u64) {
        // At most about 0.3 m/s and 3 rad/s for a free prism of some 70 g: it slides by a centimetre.
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let direction: f64 = rng.random_range(0.0..TAU);
        let impulse = Vector3::new(direction.cos(), direction.sin(), 0.0) * rng.random_range(0.010..=0.020);
        self.table.world.push(self.triangle, impulse, rng.random_range(-4e-5..=4e-5));
    }
}
