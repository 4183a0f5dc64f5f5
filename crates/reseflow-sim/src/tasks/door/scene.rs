//! A running door scene: its measure, its judge, and the watch over motion without touch.

use nalgebra::Vector3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use reseflow_data::{
    Action, Contact, EpisodeKey, Halt, Observation, Outcome, Policy, Scene, SceneBody, Tick,
};
use reseflow_lie::{SE3, SO3};

use super::setup::{DoorSetup, HingeSide};
use super::{DoorTask, POINTS, cabinet, expert};
use crate::expert::{Expert, Glance, Watch};
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
    watch: Watch,
}

impl DoorScene {
    pub(super) fn new(task: &DoorTask, setup: DoorSetup, key: &EpisodeKey) -> Self {
        let mut world = World::new(task.physics, &setup.world_from_gripper, setup.table_color);
        let door = cabinet::insert(&mut world, &setup);
        let start = world.world_from_object(door);
        let points = task.camera.points.unwrap_or(POINTS);
        let table = Tabletop::new(world, setup.camera.clone(), task.camera, key.clone(), points);
        Self {
            table,
            setup,
            door,
            closed: start.rotation,
            touched: false,
            untouched_rad: 0.0,
            pushed: false,
            watch: Watch::new(start),
        }
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
        let object = self.table.world.world_from_object(door);
        self.watch.set(Glance { object, ..self.watch.get() });
        Ok(tick)
    }

    fn bodies(&self) -> Vec<SceneBody> {
        self.table.bodies()
    }

    fn judge(&mut self) -> Outcome {
        let before = self.opened_rad();
        let halt = self.table.hold_still();
        let measure = self.opened_rad();
        let touches = gripper_touches_door(&self.table.world.contacts());
        if !(self.touched || touches || self.pushed) {
            self.untouched_rad += (measure - before).abs();
        }
        let reached = measure >= GOAL_RAD && self.untouched_rad <= UNTOUCHED_LIMIT_RAD;
        Outcome { success: halt.is_none() && reached, measure, measure_name: "opened_rad".to_owned(), halt }
    }

    fn expert(&self) -> Box<dyn Policy> {
        let setup = self.setup.clone();
        let closed = self.closed;
        Box::new(Expert::new(
            self.watch.clone(),
            expert::TOLERANCE,
            move |glance: &Glance, _: &SE3, steps| {
                let turned = closed.inverse() * glance.object.rotation;
                expert::script(&setup, setup.hinge.sign() * turned.log().z, steps)
            },
        ))
    }

    fn disturb(&mut self, seed: u64) {
        // Back off the handle, faster than the pads' friction and the carriage's force can stop within the finger tips.
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let speed_m_s: f64 = rng.random_range(2.5..=2.7);
        self.table.world.knock(Vector3::z() * -speed_m_s);
        self.pushed = true;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use reseflow_data::Split;

    fn scene(index: u64) -> (DoorScene, Action) {
        let key = EpisodeKey { task: "door".to_owned(), split: Split::Train, seed: 1, index, attempt: 0 };
        let setup = DoorSetup::draw(&key).unwrap();
        let still = Action { world_from_gripper: setup.world_from_gripper, opening: 1.0 };
        (DoorScene::new(&DoorTask::default(), setup, &key), still)
    }

    fn push(scene: &mut DoorScene, impulse_nm_s: f64) {
        let opening = scene.setup.hinge.sign() * impulse_nm_s;
        scene.table.world.push(scene.door, Vector3::zeros(), opening);
    }

    #[test]
    fn a_door_that_opens_untouched_is_no_success() {
        // In its own time, or while it is being judged.
        for ticks in [40, 0] {
            let (mut scene, still) = scene(0);
            push(&mut scene, 0.1);
            for _ in 0..ticks {
                scene.tick(&still).unwrap();
            }
            let outcome = scene.judge();
            assert!(outcome.measure > GOAL_RAD, "opened to {} rad only", outcome.measure);
            assert!(!outcome.success);
        }
    }

    #[test]
    fn a_pushed_door_stays_where_its_friction_leaves_it() {
        for index in 0..6 {
            let (mut scene, still) = scene(index);
            let wait = |scene: &mut DoorScene, ticks: usize| -> Vec<f64> {
                (0..ticks).map(|_| scene.tick(&still).unwrap().measure).collect()
            };
            assert!(wait(&mut scene, 5).iter().all(|angle| angle.abs() < 1e-4));
            push(&mut scene, 0.007 + 0.001 * index as f64);
            let angles = wait(&mut scene, 40);
            assert!(angles[9] > 0.01, "opened by {} rad only", angles[9]);
            assert!((angles[39] - angles[9]).abs() < 1e-3, "from {} to {} rad", angles[9], angles[39]);
        }
    }
}
