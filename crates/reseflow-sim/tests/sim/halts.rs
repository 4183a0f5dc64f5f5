//! Bad commands and impossible scenes end an episode with a named reason, never with a panic.

use rand::{Rng, RngExt};
use rayon::prelude::*;
use reseflow_data::{Action, Halt, Scene, SceneBody, Split, Task};
use reseflow_lie::{SE3, SO3, Vector3};
use reseflow_sim::{
    DoorSetup, DoorTask, PaintingSetup, PaintingTask, TriangleSetup, TriangleTask, task, tasks,
};

use crate::support::key;

fn setup() -> TriangleSetup {
    TriangleSetup::draw(&key("triangle", Split::Train, 1, 1))
}

fn scene(setup: TriangleSetup) -> Box<dyn Scene> {
    TriangleTask::default().scene(setup, &key("triangle", Split::Train, 1, 1)).unwrap()
}

fn command(scene: &mut dyn Scene) -> Action {
    Action { world_from_gripper: scene.observe().world_from_gripper, opening: 1.0 }
}

/// The reason for which `bad` is refused; checks that the scene stays as it was and never goes on.
fn refusal(bad: impl Fn(&mut Action)) -> Halt {
    let mut scene = scene(setup());
    let good = command(scene.as_mut());
    scene.tick(&good).unwrap();
    let (frame, bodies) = (scene.observe(), scene.bodies());
    let mut action = good;
    bad(&mut action);
    let reason = scene.tick(&action).unwrap_err();
    assert_eq!((scene.observe(), scene.bodies()), (frame, bodies));
    assert_eq!(scene.tick(&good).unwrap_err(), reason);
    let outcome = scene.judge();
    assert_eq!((outcome.success, outcome.halt), (false, Some(reason)));
    reason
}

#[test]
fn actions_that_are_not_finite_are_refused() {
    assert_eq!(refusal(|action| action.opening = f64::NAN), Halt::NonFiniteAction);
    assert_eq!(
        refusal(|action| action.world_from_gripper.translation.x = f64::INFINITY),
        Halt::NonFiniteAction
    );
}

#[test]
fn actions_outside_the_workspace_are_refused() {
    assert_eq!(refusal(|action| action.world_from_gripper.translation.z = 2.0), Halt::OutOfReach);
    assert_eq!(refusal(|action| action.world_from_gripper.translation.y = -0.9), Halt::OutOfReach);
}

#[test]
fn a_jump_loses_the_command() {
    let mut scene = scene(setup());
    let mut action = command(scene.as_mut());
    let turn = SO3::exp(&Vector3::new(3.0, 0.0, 0.0));
    // No carriage of 6 N m can turn over and back every twentieth of a second.
    let reason = (0..10).find_map(|_| {
        action.world_from_gripper.rotation = action.world_from_gripper.rotation * turn;
        scene.tick(&action).err()
    });
    assert_eq!(reason, Some(Halt::LostTracking));
}

#[test]
fn a_gripper_that_starts_in_the_table_or_the_triangle_is_refused() {
    let mut in_table = setup();
    in_table.world_from_gripper.translation.z = 0.0;
    let mut in_triangle = setup();
    let [x, y] = in_triangle.center_m;
    // One finger, 5 cm off the middle, stands in the prism.
    let aside = in_triangle.world_from_gripper.rotation.act(&Vector3::new(0.0, 0.05, 0.0));
    in_triangle.world_from_gripper.translation = Vector3::new(x - aside.x, y - aside.y, 0.03);
    for setup in [in_table, in_triangle] {
        let mut scene = scene(setup);
        let action = command(scene.as_mut());
        assert_eq!(scene.tick(&action).unwrap_err(), Halt::StartsInCollision);
    }
}

#[test]
fn a_gripper_that_starts_in_the_board_or_the_cabinet_is_refused() {
    let board = key("painting", Split::Train, 1, 1);
    let mut in_board = PaintingSetup::draw(&board).unwrap();
    in_board.world_from_gripper.translation = in_board.world_from_board().translation;
    let cabinet = key("door", Split::Train, 1, 1);
    let mut in_cabinet = DoorSetup::draw(&cabinet).unwrap();
    let [x, y] = in_cabinet.center_m;
    in_cabinet.world_from_gripper.translation = Vector3::new(x, y, in_cabinet.size_m[2] / 2.0);
    for mut scene in [
        PaintingTask::default().scene(in_board, &board).unwrap(),
        DoorTask::default().scene(in_cabinet, &cabinet),
    ] {
        let action = command(scene.as_mut());
        assert_eq!(scene.tick(&action).unwrap_err(), Halt::StartsInCollision);
        let outcome = scene.judge();
        assert_eq!((outcome.success, outcome.halt), (false, Some(Halt::StartsInCollision)));
    }
}

#[test]
fn a_gripper_tipped_over_is_refused_where_it_starts_and_loses_its_command_where_it_is_told_to() {
    let on_its_side = SO3::exp(&Vector3::new(1.6, 0.0, 0.0));
    let mut tipped = setup();
    tipped.world_from_gripper.rotation = tipped.world_from_gripper.rotation * on_its_side;
    tipped.world_from_gripper.translation.z = 0.02;
    let mut scene = self::scene(tipped);
    let action = command(scene.as_mut());
    assert_eq!(scene.tick(&action).unwrap_err(), Halt::StartsInCollision);

    // Told to lie down at the height of a grasp, the palm meets the table.
    let mut scene = self::scene(setup());
    let mut action = command(scene.as_mut());
    action.world_from_gripper.rotation = action.world_from_gripper.rotation * on_its_side;
    action.world_from_gripper.translation.z = 0.005;
    let reason = (0..100).find_map(|_| scene.tick(&action).err());
    assert_eq!(reason, Some(Halt::LostTracking));
}

#[test]
fn a_triangle_beyond_the_edge_is_lost() {
    let mut setup = setup();
    setup.center_m = [0.46, 0.0];
    let mut scene = scene(setup);
    let action = command(scene.as_mut());
    assert_eq!(scene.tick(&action).unwrap_err(), Halt::ObjectLost);
}

#[test]
fn a_triangle_without_size_is_a_fault_of_the_setup() {
    let mut setup = setup();
    setup.side_m = 0.0;
    let fault = TriangleTask::default().scene(setup, &key("triangle", Split::Train, 1, 1)).err().unwrap();
    assert!(fault.to_string().contains("without volume"), "{fault}");
}

/// A command that no sane policy gives: anywhere near the table, an opening beyond its range, now and then a NaN.
fn wild_action(rng: &mut impl Rng) -> Action {
    let home =
        SE3::new(SO3::exp(&Vector3::new(std::f64::consts::PI, 0.0, 0.0)), Vector3::new(0.0, 0.0, 0.12));
    let (spread_rad, spread_m) = (rng.random_range(0.0..1.0), rng.random_range(0.0..0.15));
    let mut action = Action {
        world_from_gripper: SE3::sample_gaussian(&home, spread_rad, spread_m, rng),
        opening: rng.random_range(-0.5..=1.5),
    };
    match rng.random_range(0..40) {
        0 => action.opening = f64::NAN,
        1 => action.world_from_gripper.translation.z = f64::NEG_INFINITY,
        _ => {}
    }
    action
}

/// Where everything is that a task brought.
fn object_places(scene: &dyn Scene) -> Vec<Vector3<f64>> {
    let is_object = |body: &&SceneBody| {
        !(body.name.starts_with("gripper") || body.name == "table" || body.name == "wet_paint")
    };
    scene.bodies().iter().filter(is_object).map(|body| body.world_from_body.translation).collect()
}

/// A short episode of wild commands: how it ended, how far an object moved within a tick, and whether the scene kept its
/// word about ending.
fn wild_episode(task: &dyn Task, index: u64) -> (Option<Halt>, f64) {
    let key = key(&task.spec().name, Split::Test, 9, index);
    let mut rng = key.rng("wild actions");
    let mut scene = task.reset(&key).unwrap();
    let first = scene.observe();
    let mut command = Action { world_from_gripper: first.world_from_gripper, opening: first.gripper_opening };
    let (mut halt, mut farthest_m) = (None, 0.0_f64);
    let mut places = object_places(scene.as_ref());
    for _ in 0..3 {
        let target = wild_action(&mut rng);
        for tick in 1..=8 {
            let now = command.interpolate(&target, f64::from(tick) / 8.0);
            match scene.tick(&now) {
                Ok(tick) => assert!(halt.is_none() && tick.measure.is_finite()),
                Err(reason) => assert_eq!(*halt.get_or_insert(reason), reason),
            }
            let now = object_places(scene.as_ref());
            let moved = places.iter().zip(&now).map(|(before, now)| (now - before).norm());
            farthest_m = moved.fold(farthest_m, f64::max);
            places = now;
        }
        command = target;
    }
    let outcome = scene.judge();
    assert!(outcome.measure.is_finite() && !(outcome.success && outcome.halt.is_some()));
    assert!(halt.is_none() || outcome.halt == halt);
    assert!(scene.observe().cloud.points.iter().flatten().all(|x| x.is_finite()));
    (outcome.halt, farthest_m)
}

#[test]
fn a_thousand_wild_episodes_end_in_an_outcome_each() {
    let per_task = 1000_u64.div_ceil(tasks().len() as u64);
    for name in tasks() {
        let task = task(name).unwrap();
        let (halts, moved_m): (Vec<Option<Halt>>, Vec<f64>) =
            (0..per_task).into_par_iter().map(|index| wild_episode(task.as_ref(), index)).unzip();
        // The fingers themselves reach 2 m/s; what pushes bodies apart that have sunk in may add nothing to it.
        let fastest = moved_m.into_iter().fold(0.0, f64::max) / (task.spec().tick_nanos as f64 * 1e-9);
        assert!((0.3..2.5).contains(&fastest), "{name}: an object moves with {fastest} m/s");
        let count = |halt: Option<Halt>| halts.iter().filter(|got| **got == halt).count();
        assert!(count(None) > 10, "{name}: only {} wild episodes were not halted", count(None));
        for reason in [Halt::NonFiniteAction, Halt::OutOfReach] {
            assert!(count(Some(reason)) > 2, "{name}: {reason} came {} times", count(Some(reason)));
        }
        assert_eq!(count(Some(Halt::Diverged)), 0, "{name}: the engine diverged");
    }
}
