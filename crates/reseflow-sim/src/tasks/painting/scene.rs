//! A running painting scene: the board, the brush, the wet paint, the judge.

use std::f64::consts::PI;

use nalgebra::Vector3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rapier3d::prelude::RigidBodyBuilder;
use reseflow_data::{
    Action, EpisodeKey, Halt, Observation, Outcome, Policy, Scene, SceneBody, TaskError, Tick,
};
use reseflow_lie::SE3;

use super::paint::WetPaint;
use super::setup::PaintingSetup;
use super::{NAME, POINTS, PaintingTask, board, expert};
use crate::expert::{Expert, Glance, Watch};
use crate::tabletop::Tabletop;
use crate::world::{Object, World};

/// Width of the printed stroke, metres.
const STROKE_WIDTH_M: f64 = 0.007;
/// Radius of the disc where it begins.
const BEGINNING_RADIUS_M: f64 = 0.010;
/// Radius of a dab of paint.
const DAB_RADIUS_M: f64 = 0.005;
/// Heights of the three over the face, so that each hides what is under it.
const STROKE_HEIGHT_M: f64 = 2e-4;
const BEGINNING_HEIGHT_M: f64 = 4e-4;
const PAINT_HEIGHT_M: f64 = 6e-4;
/// Places along the printed stroke at which its outline is drawn.
const OUTLINE_PLACES: usize = 60;

/// A running scene.
pub(super) struct PaintingScene {
    table: Tabletop,
    setup: PaintingSetup,
    board: Object,
    paint: WetPaint,
    watch: Watch,
}

impl PaintingScene {
    pub(super) fn new(
        task: &PaintingTask,
        setup: PaintingSetup,
        key: &EpisodeKey,
    ) -> Result<Self, TaskError> {
        let fault =
            |reason: &str| TaskError { task: NAME.to_owned(), index: key.index, reason: reason.to_owned() };
        let mut world = World::new(task.physics, &setup.world_from_gripper, setup.table_color);
        world.add_brush(setup.paint_color);

        let (world_from_board, half_m) = (setup.world_from_board(), setup.board_half_m);
        let corners = board::stand_corners(&world_from_board, half_m);
        let colliders = board::colliders(&corners, half_m)
            .ok_or_else(|| fault("expected a board of positive size, got one without volume"))?;
        let body = RigidBodyBuilder::dynamic().can_sleep(false);
        let board = world.add_object("board", &world_from_board, body, colliders);
        let (slab, slab_center_m) = board::board_shape(half_m);
        world.add_object_part_at("board", board, slab_center_m, slab, setup.board_color);
        world.add_object_part("stand", board, board::stand_shape(&corners), setup.stand_color);
        let places = setup.stroke.places(OUTLINE_PLACES);
        let ribbon = board::ribbon(&places, STROKE_WIDTH_M, STROKE_HEIGHT_M);
        world.add_object_part("stroke", board, ribbon, setup.stroke_color);
        let disc = board::discs(&[places[0].point_m], BEGINNING_RADIUS_M, 16, BEGINNING_HEIGHT_M);
        world.add_object_part("stroke_beginning", board, disc, setup.beginning_color);

        let points = task.camera.points.unwrap_or(POINTS);
        let table = Tabletop::new(world, setup.camera.clone(), task.camera, key.clone(), points);
        let paint = WetPaint::new(setup.stroke.clone());
        Ok(Self { table, setup, board, paint, watch: Watch::new(world_from_board) })
    }

    /// Lets the paint show that the brush has left since the last time.
    fn show_paint(&mut self) {
        let added = self.table.world.brush().is_some_and(|brush| self.paint.add(brush, self.board));
        if added {
            let shape = board::discs(self.paint.dabs_m(), DAB_RADIUS_M, 6, PAINT_HEIGHT_M);
            self.table.world.show_object_part("wet_paint", self.board, shape, self.setup.paint_color);
        }
    }
}

impl Scene for PaintingScene {
    fn observe(&mut self) -> Observation {
        self.table.observe()
    }

    fn tick(&mut self, command: &Action) -> Result<Tick, Halt> {
        let mut tick = self.table.tick(command, |_| 0.0)?;
        self.show_paint();
        tick.measure = self.paint.covered_share();
        let object = self.table.world.world_from_object(self.board);
        self.watch.set(Glance { object, ..self.watch.get() });
        Ok(tick)
    }

    fn bodies(&self) -> Vec<SceneBody> {
        self.table.bodies()
    }

    fn judge(&mut self) -> Outcome {
        let halt = self.table.hold_still();
        self.show_paint();
        let done = self.table.world.brush().is_some_and(|brush| self.paint.is_done(brush));
        Outcome {
            success: halt.is_none() && done,
            measure: self.paint.covered_share(),
            measure_name: "covered_share".to_owned(),
            halt,
        }
    }

    fn expert(&self) -> Box<dyn Policy> {
        let setup = self.setup.clone();
        Box::new(Expert::new(
            self.watch.clone(),
            expert::TOLERANCE,
            move |glance: &Glance, _: &SE3, steps| expert::script(&setup, &glance.object, steps),
        ))
    }

    fn disturb(&mut self, seed: u64) {
        // Away from the brush, to the back: friction stops the board after about three centimetres.
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let direction = self.setup.yaw_rad + PI + rng.random_range(-1.0..=1.0);
        let speed_m_s: f64 = rng.random_range(0.45..=0.52);
        let impulse = Vector3::new(direction.cos(), direction.sin(), 0.0) * (board::MASS_KG * speed_m_s);
        self.table.world.push(self.board, impulse, rng.random_range(-0.05..=0.05));
    }
}
