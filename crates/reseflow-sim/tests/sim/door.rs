//! The door: what shows its hinge, what holds it, and what does not open it.

use reseflow_data::{Action, Contact, EpisodeObserver, Scene, Split, Tick};
use reseflow_lie::{SE3, SO3, Vector3};
use reseflow_sim::{DoorSetup, DoorTask, HingeSide, Scripted, is_salient};

use crate::support::{key, run, run_observed};

fn setup(index: u64) -> DoorSetup {
    DoorSetup::draw(&key("door", Split::Train, 1, index)).unwrap()
}

fn scene(setup: DoorSetup) -> Box<dyn Scene> {
    DoorTask::default().scene(setup, &key("door", Split::Train, 1, 0))
}

fn world_from_cabinet(setup: &DoorSetup) -> SE3 {
    let [x, y] = setup.center_m;
    SE3::new(SO3::exp(&(Vector3::z() * setup.yaw_rad)), Vector3::new(x, y, 0.0))
}

/// The mean, in the cabinet's frame, of the points whose colour `wanted` accepts, and how many they are.
fn mean_of(
    scene: &mut dyn Scene,
    world_from_cabinet: &SE3,
    wanted: impl Fn([u8; 3]) -> bool,
) -> (Vector3<f64>, usize) {
    let cloud = scene.observe().cloud;
    let chosen: Vec<Vector3<f64>> = cloud
        .points
        .iter()
        .zip(&cloud.colors)
        .filter(|(_, color)| wanted(**color))
        .map(|(point, _)| world_from_cabinet.inverse().act(&Vector3::from(point.map(f64::from))))
        .collect();
    (chosen.iter().sum::<Vector3<f64>>() / chosen.len().max(1) as f64, chosen.len())
}

#[test]
fn the_cloud_shows_the_handle_across_from_the_hinge() {
    let dark = |rgb: [u8; 3]| rgb.iter().all(|&level| level < 60);
    for index in 0..20 {
        let setup = setup(index);
        let hinge_at = if setup.hinge == HingeSide::Right { 1.0 } else { -1.0 };
        let (cabinet, mut scene) = (world_from_cabinet(&setup), scene(setup));
        let (handle, handle_points) = mean_of(scene.as_mut(), &cabinet, is_salient);
        assert!(handle_points >= 24 && handle.y * hinge_at < -0.05, "episode {index}: handle at {handle:?}");
        let (strip, strip_points) = mean_of(scene.as_mut(), &cabinet, dark);
        assert!(strip_points > 0 && strip.y * hinge_at > 0.05, "episode {index}: hinge at {strip:?}");
    }
}

#[test]
fn a_closed_door_does_not_give_way_to_a_push() {
    let task = DoorTask::default();
    for index in 0..4 {
        let key = key("door", Split::Test, 5, index);
        let mut actions = run(&task, &key, None).episode.actions;
        // On from the grasp, 6 cm into the door, with closed fingers.
        let mut into = actions[1];
        into.opening = 0.0;
        into.world_from_gripper.translation = into.world_from_gripper.act(&Vector3::new(0.0, 0.0, 0.06));
        actions[0].opening = 0.0;
        let press = vec![actions[0], into, into];
        let record = run(&task, &key, Some(&mut Scripted::new("press", press)));
        assert!(record.outcome.measure.abs() < 0.01 && !record.outcome.success, "{:?}", record.outcome);
    }
}

#[test]
fn without_a_grip_the_door_is_not_opened() {
    let task = DoorTask::default();
    for index in 0..6 {
        let key = key("door", Split::Test, 6, index);
        let mut actions = run(&task, &key, None).episode.actions;
        actions.iter_mut().for_each(|action| action.opening = 1.0);
        let outcome = run(&task, &key, Some(&mut Scripted::new("open", actions))).outcome;
        assert!(!outcome.success, "{outcome:?}");
    }
}

/// Every contact of the gripper.
#[derive(Default)]
struct Touches(Vec<Contact>);

impl EpisodeObserver for Touches {
    fn on_tick(&mut self, tick: &Tick, _scene: &mut dyn Scene) {
        self.0.extend(tick.contacts.iter().filter(|contact| contact.body_b.starts_with("gripper")).cloned());
    }
}

#[test]
fn the_expert_touches_nothing_but_the_door() {
    let task = DoorTask::default();
    for index in 0..10 {
        let mut touches = Touches::default();
        let key = key("door", Split::Test, 7, index);
        let outcome = run_observed(&task, &key, None, None, &mut touches).outcome;
        assert!(outcome.success);
        assert!(touches.0.len() > 100, "both fingers grip for more than 50 ticks");
        assert!(touches.0.iter().all(|contact| contact.body_a == "door"), "episode {index}");
        let hardest = touches.0.iter().map(|contact| contact.force_n).fold(0.0, f64::max);
        assert!(hardest < 2.0 * task.physics.grip_force_n, "{hardest} N");
    }
}

#[test]
fn a_gripper_that_starts_in_the_door_is_refused() {
    let mut setup = setup(2);
    let front = world_from_cabinet(&setup).act(&Vector3::new(0.5 * setup.size_m[2], 0.0, 0.1));
    setup.world_from_gripper.translation = front;
    let mut scene = scene(setup);
    let here = Action { world_from_gripper: scene.observe().world_from_gripper, opening: 1.0 };
    assert_eq!(scene.tick(&here).unwrap_err(), reseflow_data::Halt::StartsInCollision);
}
