//! Painting: a spring presses the brush, paint stays where it was pressed, and the camera sees it.

use rayon::prelude::*;
use reseflow_data::{
    Action, Contact, EpisodeKey, EpisodeObserver, Halt, PointCloud, Scene, Split, Task, Tick,
};
use reseflow_lie::{SE3, SO3, Vector3};
use reseflow_sim::{PaintingSetup, PaintingTask, Scripted, is_salient};

use crate::support::{key, run, run_observed};

fn name(index: u64) -> EpisodeKey {
    key("painting", Split::Test, 23, index)
}

fn setup(index: u64) -> PaintingSetup {
    PaintingSetup::draw(&name(index)).unwrap()
}

/// A level board in the middle of the table, looking along the world's x axis.
fn level() -> PaintingSetup {
    PaintingSetup { tilt_rad: 0.0, yaw_rad: 0.0, center_m: [0.0, 0.0], ..setup(0) }
}

/// What is known of every tick.
#[derive(Default)]
struct Record {
    contacts: Vec<Contact>,
    /// The brush's force on the board, tick by tick, 0 where they do not touch.
    forces_n: Vec<f64>,
    measures: Vec<f64>,
    board_moved_m: f64,
    board_start: Option<SE3>,
}

fn board(scene: &dyn Scene) -> SE3 {
    scene.bodies().iter().find(|body| body.name == "stroke").unwrap().world_from_body
}

impl EpisodeObserver for Record {
    fn on_tick(&mut self, tick: &Tick, scene: &mut dyn Scene) {
        let brush = tick.contacts.iter().find(|c| c.body_a == "board" && c.body_b == "gripper_brush");
        self.forces_n.push(brush.map_or(0.0, |contact| contact.force_n));
        self.contacts.extend(tick.contacts.iter().cloned());
        self.measures.push(tick.measure);
        let now = board(scene);
        let start = *self.board_start.get_or_insert(now);
        self.board_moved_m = self.board_moved_m.max((now.translation - start.translation).norm());
    }
}

#[test]
fn the_expert_presses_within_the_range_and_nothing_sinks_in() {
    let task = PaintingTask::default();
    let records: Vec<Record> = (0..12_u64)
        .into_par_iter()
        .map(|index| {
            let mut record = Record::default();
            assert!(run_observed(&task, &name(index), None, None, &mut record).outcome.success);
            record
        })
        .collect();
    let mut depths_m = Vec::new();
    for record in &records {
        let touching: Vec<usize> = (0..100).filter(|&tick| record.forces_n[tick] > 0.0).collect();
        // Six action steps on the stroke, a part of the two around them.
        assert!((60..80).contains(&touching.len()), "{} ticks of touch", touching.len());
        let pressed = touching.iter().filter(|&&tick| (0.2..=2.0).contains(&record.forces_n[tick])).count();
        assert!(pressed * 100 >= touching.len() * 95, "{pressed} of {}", touching.len());
        assert!(record.measures[..touching[0]].iter().all(|&covered| covered == 0.0), "paint without touch");
        assert!(record.measures.windows(2).all(|pair| pair[1] >= pair[0]), "paint does not go away");
        assert!(record.board_moved_m < 1e-3, "the brush drags the board by {} m", record.board_moved_m);
        depths_m.extend(record.contacts.iter().map(|contact| contact.depth_m));
    }
    depths_m.sort_by(f64::total_cmp);
    let p99 = depths_m[depths_m.len() * 99 / 100];
    assert!(depths_m.len() > 3000 && p99 < 1e-3, "{} contacts, 99th percentile {p99} m", depths_m.len());
}

/// Goes straight from the start to `target` and stays there; the last tick.
fn press(scene: &mut dyn Scene, start: &SE3, target: &SE3) -> Tick {
    let from = Action { world_from_gripper: *start, opening: 0.0 };
    let to = Action { world_from_gripper: *target, opening: 0.0 };
    let commands = (1..=60).map(|tick| from.interpolate(&to, f64::from(tick.min(40)) / 40.0));
    commands.map(|command| scene.tick(&command).unwrap()).last().unwrap()
}

#[test]
fn the_bristles_are_a_spring_that_the_carriage_feels() {
    let task = PaintingTask::default();
    let down = SO3::exp(&Vector3::new(std::f64::consts::PI, 0.0, 0.0));
    let pressed = |below_m: f64| {
        let mut scene = task.scene(level(), &name(0)).unwrap();
        // The face is 3 cm high, the brush's tip 75 mm from the gripper's origin.
        let target = SE3::new(down, Vector3::new(0.02, -0.03, 0.03 + 0.075 - below_m));
        let last = press(scene.as_mut(), &level().world_from_gripper, &target);
        let brush = last.contacts.iter().find(|contact| contact.body_b == "gripper_brush").unwrap();
        assert!((brush.point_m[2] - 0.03).abs() < 1e-4);
        (brush.force_n, last.world_from_gripper.translation.z - target.translation.z)
    };
    for below_m in [0.003, 0.009] {
        let (force_n, lifted_m) = pressed(below_m);
        assert!((force_n - 200.0 * (below_m - lifted_m)).abs() < 0.02, "{force_n} N at {below_m} m");
        // The carriage is a spring too, of mass times rate squared.
        assert!((lifted_m - force_n / (1.2 * 60.0 * 60.0)).abs() < 5e-5, "lifted by {lifted_m} m");
    }
}

/// The outcome when the expert's path is moved by `offset_m` in the board's frame.
fn moved_path(index: u64, offset_m: Vector3<f64>) -> (bool, f64) {
    let task = PaintingTask::default();
    let world_from_board = setup(index).world_from_board();
    let mut actions = run(&task, &name(index), None).episode.actions;
    for action in &mut actions {
        action.world_from_gripper.translation += world_from_board.rotation.act(&offset_m);
    }
    let outcome = run(&task, &name(index), Some(&mut Scripted::new("moved", actions))).outcome;
    assert_eq!(outcome.halt, None);
    (outcome.success, outcome.measure)
}

#[test]
fn paths_off_the_stroke_or_off_the_board_do_not_succeed() {
    for index in 0..3 {
        let (success, covered) = moved_path(index, Vector3::new(0.0, 0.0, 0.008));
        assert!(!success && covered == 0.0, "painted in the air: {covered}");
        let (success, covered) = moved_path(index, Vector3::new(0.0, 0.0, -0.008));
        assert!(!success && covered < 0.5, "pressed too hard: {covered}");
        // A stroke along the offset stays covered for a part, but no stroke of the library is a circle about it.
        let aside = [Vector3::new(0.025, 0.0, 0.0), Vector3::new(0.0, 0.025, 0.0)];
        assert!(aside.iter().any(|offset| !moved_path(index, *offset).0), "25 mm aside");
        assert!(moved_path(index, Vector3::new(0.004, 0.003, 0.001)).0, "5 mm aside is near enough");
    }
}

/// How many salient points are mostly red, green or blue.
fn salient_counts(cloud: &PointCloud) -> [usize; 3] {
    let mut counts = [0; 3];
    for color in cloud.colors.iter().filter(|&&color| is_salient(color)) {
        counts[(0..3).max_by_key(|&channel| color[channel]).unwrap()] += 1;
    }
    counts
}

#[test]
fn the_camera_sees_the_stroke_where_it_begins_and_wet_paint() {
    let task = PaintingTask::default();
    for index in 0..10 {
        let setup = setup(index);
        let board_from_world = setup.world_from_board().inverse();
        let observations = run(&task, &name(index), None).episode.observations;
        let first = &observations[0].cloud;
        let [red, green, blue] = salient_counts(first);
        assert!(
            red == 0 && green >= 5 && blue >= 50,
            "episode {index}: {red} red, {green} green, {blue} blue"
        );
        let [begin_x, begin_y] = setup.stroke.points_m(2)[0];
        let mut ends_seen = [false; 2];
        for (point, color) in first.points.iter().zip(&first.colors).filter(|(_, color)| is_salient(**color))
        {
            let at = board_from_world.act(&Vector3::from(point.map(f64::from)));
            assert!(at.z.abs() < 0.008, "depth noise only");
            let to_stroke = setup.stroke.distance_m([at.x, at.y]);
            let is_beginning = color[1] > color[2];
            let to_beginning = (at.x - begin_x).hypot(at.y - begin_y);
            // Drawn 7 mm wide, the disc with 10 mm radius; depth noise of 1 mm slants along the view.
            assert!(to_stroke < if is_beginning { 0.014 } else { 0.008 });
            assert!(!is_beginning || to_beginning < 0.014, "{to_beginning} m from the beginning");
            let [end_x, end_y] = setup.stroke.points_m(2)[1];
            ends_seen[0] |= is_beginning;
            ends_seen[1] |= (at.x - end_x).hypot(at.y - end_y) < 0.02;
        }
        assert_eq!(ends_seen, [true; 2]);
        // At the last frame the whole stroke is painted; the gripper hides a part.
        let [red, _, _] = salient_counts(&observations[9].cloud);
        assert!(red >= 24, "episode {index}: {red} points of paint");
    }
}

#[test]
fn a_gripper_that_starts_in_the_board_is_refused() {
    let task = PaintingTask::default();
    let face_m = 0.03;
    // The brush's handle, the fingers, the palm under the face.
    for origin_height_m in [face_m + 0.055, face_m, -0.02] {
        let mut setup = level();
        setup.world_from_gripper = SE3::new(
            SO3::exp(&Vector3::new(std::f64::consts::PI, 0.0, 0.0)),
            Vector3::new(0.0, 0.0, origin_height_m),
        );
        let stay = Action { world_from_gripper: setup.world_from_gripper, opening: 0.0 };
        let mut scene = task.scene(setup, &name(0)).unwrap();
        assert_eq!(scene.tick(&stay).unwrap_err(), Halt::StartsInCollision);
        let outcome = scene.judge();
        assert_eq!((outcome.success, outcome.halt), (false, Some(Halt::StartsInCollision)));
    }
    // The tip alone may touch: bristles give way.
    let mut setup = level();
    setup.world_from_gripper.rotation = SO3::exp(&Vector3::new(std::f64::consts::PI, 0.0, 0.0));
    setup.world_from_gripper.translation = Vector3::new(0.0, 0.0, face_m + 0.07);
    let stay = Action { world_from_gripper: setup.world_from_gripper, opening: 0.0 };
    assert!(task.scene(setup, &name(0)).unwrap().tick(&stay).is_ok());
}

#[test]
fn a_board_without_size_is_a_fault_of_the_setup() {
    let setup = PaintingSetup { board_half_m: 0.0, ..level() };
    let fault = PaintingTask::default().scene(setup, &name(0)).err().unwrap();
    assert!(fault.to_string().contains("without volume"), "{fault}");
}

#[test]
fn a_shoved_board_slides_and_takes_its_stroke_along() {
    let task = PaintingTask::default();
    for index in 0..4 {
        let mut scene = task.reset(&name(index)).unwrap();
        let stay = Action { world_from_gripper: setup(index).world_from_gripper, opening: 0.0 };
        let before = board(scene.as_ref());
        scene.tick(&stay).unwrap();
        assert!((board(scene.as_ref()).translation - before.translation).norm() < 1e-4, "it stands still");
        scene.disturb(index);
        (0..15).for_each(|_| drop(scene.tick(&stay).unwrap()));
        let slid = before.inverse() * board(scene.as_ref());
        assert!((0.015..0.05).contains(&slid.translation.norm()), "slid by {} m", slid.translation.norm());
        assert!(slid.rotation.angle() < 0.2, "turned by {} rad", slid.rotation.angle());
        let resting = board(scene.as_ref());
        scene.tick(&stay).unwrap();
        assert!((board(scene.as_ref()).translation - resting.translation).norm() < 1e-4, "friction stops it");
    }
}

#[test]
fn a_stroke_may_be_painted_from_either_end() {
    let task = PaintingTask::default();
    for index in 0..3 {
        let mut actions = run(&task, &name(index), None).episode.actions;
        actions.reverse();
        let outcome = run(&task, &name(index), Some(&mut Scripted::new("backwards", actions))).outcome;
        assert!(outcome.success, "episode {index}: {outcome:?}");
    }
}
