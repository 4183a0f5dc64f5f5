//! A running door scene: its measure, its judge, and the watch over motion without touch.

use nalgebra::Vector3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use reseflow_data::{
    Action, Contact, EpisodeKey, Halt, Observation, Outcome, Policy, Scene, SceneBody, Tick,
};
use reseflow_lie::SO3;

use super::setup::{DoorSetup, HingeSide};
use super::{DoorTask, POINTS, cabinet, expert};
use crate::scripted::Scripted;
use crate::tabletop::Tabletop;
use crate::world::{Object, World};

const GOAL_RAD: f64 = 50.0 * std::f64::consts::PI / 180.0;
/// The door may drift by so much in all while nothing touches it.
const UNTOUCHED_LIMIT_RAD: f64 = 0.05;
/// A pushed door has come to rest when it moves by less than this in a tick.
const AT_REST_RAD: f64 = 1e-4;

/// A running scene.
pub(super) struct DoorScene {
    table: Tabletop,
    setup: DoorSetup,
    door: Object,
    closed: SO3,
    /// Whether the gripper touched the door at the end of the last tick.
    touched: bool,
    /// How far the door has moved in ticks that began and ended without touch, radians.
    untouched_rad: f64,
    /// Set by a push from outside, until the door has come to rest.
    pushed: bool,
}

impl DoorScene {
    pub(super) fn new(task: &DoorTask, setup: DoorSetup, key: &EpisodeKey) -> Self {
        let mut world = World::new(task.physics, &setup.world_from_gripper, setup.table_color);
        let door = cabinet::insert(&mut world, &setup);
        let closed = world.world_from_object(door).rotation;
        let table = Tabletop::new(world, setup.camera.clone(), task.camera, key.clone(), POINTS);
        Self { table, setup, door, closed, touched: false, untouched_rad: 0.0, pushed: false }
    }

    fn opened_rad(&self) -> f64 {
        opened_rad(&self.table.world, self.door, &self.closed, self.setup.hinge)
    }
}

/// How far the door is open.
fn opened_rad(world: &World, door: Object, closed: &SO3, hinge: HingeSide) -> f64 {
    let turned = closed.inverse() * world.world_from_object(door).rotation;
    hinge.sign() * turned.log().z
}

/// Whether the gripper touches the door.
fn gripper_touches_door(contacts: &[Contact]) -> bool {
    // The names of a contact are sorted.
    contacts.iter().any(|contact| contact.body_a == "door" && contact.body_b.starts_with("gripper"))
}

impl Scene for DoorScene {
    fn observe(&mut self) -> Observation {
        self.table.observe()
    }

    fn tick(&mut self, command: &Action) -> Result<Tick, Halt> {
        let before = self.opened_rad();
        let (door, closed, hinge) = (self.door, self.closed, self.setup.hinge);
        let tick = self.table.tick(command, |world| opened_rad(world, door, &closed, hinge))?;
        let moved = (tick.measure - before).abs();
        let touches = gripper_touches_door(&tick.contacts);
        self.pushed &= moved > AT_REST_RAD;
        if !(self.touched || touches || self.pushed) {
            self.untouched_rad += moved;
        }
        self.touched = touches;
        Ok(tick)
    }

    fn bodies(&self) -> Vec<SceneBody> {
        self.table.bodies()
    }

    fn judge(&mut self) -> Outcome {
        let halt = self.table.hold_still();
        let measure = self.opened_rad();
        let reached = measure >= GOAL_RAD && self.untouched_rad <= UNTOUCHED_LIMIT_RAD;
        Outcome { success: halt.is_none() && reached, measure, measure_name: "opened_rad".to_owned(), halt }
    }

    fn expert(&self) -> Box<dyn Policy> {
        Box::new(Scripted::new("expert", expert::commands(&self.setup)))
    }

    fn disturb(&mut self, seed: u64) {
        // Up to about 2 rad/s, which the hinge's friction stops within a few degrees.
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let impulse: f64 = rng.random_range(0.005..=0.012);
        self.table.world.push(self.door, Vector3::zeros(), self.setup.hinge.sign() * impulse);
        self.pushed = true;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use reseflow_data::Split;

    #[test]
    fn a_door_that_opens_untouched_is_no_success() {
        let key = EpisodeKey { task: "door".to_owned(), split: Split::Train, seed: 1, index: 0, attempt: 0 };
        let setup = DoorSetup::draw(&key).unwrap();
        let still = Action { world_from_gripper: setup.world_from_gripper, opening: 1.0 };
        let mut scene = DoorScene::new(&DoorTask::default(), setup, &key);
        let impulse = 0.1 * scene.setup.hinge.sign();
        scene.table.world.push(scene.door, Vector3::zeros(), impulse);
        for _ in 0..40 {
            scene.tick(&still).unwrap();
        }
        let outcome = scene.judge();
        assert!(outcome.measure > GOAL_RAD, "opened to {} rad only", outcome.measure);
        assert!(!outcome.success);
    }
}
