//! The physics is honest: contact moves the object, nothing sinks in, halving the step changes little.

use rayon::prelude::*;
use reseflow_data::{Action, Contact, EpisodeObserver, Scene, Split, Task, Tick};
use reseflow_lie::{SE3, Vector3};
use reseflow_sim::{
    CameraSettings, PhysicsSettings, Scripted, TriangleSetup, TriangleTask, configured_task, task, tasks,
};

use crate::support::{key, run, run_observed};

/// Every contact, and how far the gripper lagged behind its command at the end of each action step.
#[derive(Default)]
struct Record {
    contacts: Vec<Contact>,
    lag_m: Vec<f64>,
    measure_before_touch: f64,
    touched: bool,
    ticks: usize,
}

fn is_of_gripper(contact: &Contact) -> bool {
    [&contact.body_a, &contact.body_b].iter().any(|name| name.starts_with("gripper"))
}

impl EpisodeObserver for Record {
    fn on_tick(&mut self, tick: &Tick, _scene: &mut dyn Scene) {
        self.ticks += 1;
        self.touched |= tick.contacts.iter().any(|contact| contact.force_n > 0.0 && is_of_gripper(contact));
        if !self.touched {
            self.measure_before_touch = self.measure_before_touch.max(tick.measure.abs());
        }
        self.contacts.extend(tick.contacts.iter().cloned());
        if self.ticks.is_multiple_of(10) {
            let offset = tick.world_from_gripper.translation - tick.command.world_from_gripper.translation;
            self.lag_m.push(offset.norm());
        }
    }
}

fn expert_record(task: &dyn Task, index: u64) -> Record {
    let mut record = Record::default();
    let key = key(&task.spec().name, Split::Test, 6, index);
    let outcome = run_observed(task, &key, None, None, &mut record).outcome;
    assert!(outcome.success);
    record
}

#[test]
fn objects_move_by_contact_only_and_hardly_sink_in() {
    for name in tasks() {
        let task = task(name).unwrap();
        let records: Vec<Record> =
            (0..8_u64).into_par_iter().map(|index| expert_record(task.as_ref(), index)).collect();
        let mut depths: Vec<f64> = Vec::new();
        for record in &records {
            let moved = record.measure_before_touch;
            assert!(record.touched && moved < 1e-3, "{name}: measure {moved} before any touch");
            // What rests on the table, and springs, hardly sink in at all: they do not count.
            let sunk_in = |contact: &&Contact| contact.depth_m > 0.0 && is_of_gripper(contact);
            depths.extend(record.contacts.iter().filter(sunk_in).map(|contact| contact.depth_m));
        }
        depths.sort_by(f64::total_cmp);
        let p99 = depths[depths.len() * 99 / 100];
        assert!(
            depths.len() > 300 && p99 < 1e-3,
            "{name}: {} contacts, 99th percentile {p99} m",
            depths.len()
        );
    }
}

#[test]
fn the_gripper_keeps_up_with_its_command() {
    for name in ["door", "triangle"] {
        let task = task(name).unwrap();
        for index in 0..4 {
            let lag = expert_record(task.as_ref(), index).lag_m.into_iter().fold(0.0, f64::max);
            assert!(lag < 1.5e-3, "{name}: {lag} m behind at the end of a step");
        }
    }
}

#[test]
fn both_pads_grip_with_the_grip_force() {
    let task = TriangleTask::default();
    let record = expert_record(&task, 1);
    for finger in ["gripper_finger_left", "gripper_finger_right"] {
        let forces: Vec<f64> = record
            .contacts
            .iter()
            .filter(|contact| contact.body_a == finger && contact.body_b == "triangle")
            .map(|contact| contact.force_n)
            .collect();
        let last = &forces[forces.len() - 10..];
        let mean = last.iter().sum::<f64>() / last.len() as f64;
        assert!((mean - task.physics.grip_force_n).abs() < 1.0, "{finger} presses with {mean} N");
    }
}

#[test]
fn halving_the_step_changes_no_success_and_little_else() {
    let coarse = PhysicsSettings::default();
    let fine = PhysicsSettings { substeps: 2 * coarse.substeps, ..coarse };
    assert!((fine.dt_secs() - 0.5 * coarse.dt_secs()).abs() < 1e-15);
    for name in tasks() {
        let task = |physics| configured_task(name, physics, CameraSettings::default()).unwrap();
        let (coarse, fine) = (task(coarse), task(fine));
        (0..5_u64).into_par_iter().for_each(|index| {
            let key = key(name, Split::Test, 8, index);
            let (a, b) = (run(coarse.as_ref(), &key, None).outcome, run(fine.as_ref(), &key, None).outcome);
            assert_eq!(a.success, b.success);
            assert!(
                (a.measure / b.measure - 1.0).abs() < 0.05,
                "{name}: {} against {}",
                a.measure,
                b.measure
            );
        });
    }
}

#[test]
fn without_a_grip_the_triangle_is_not_turned() {
    // The same path with the fingers left open: the negative control of the expert.
    let task = TriangleTask::default();
    let key = key("triangle", Split::Test, 6, 2);
    let mut actions = run(&task, &key, None).episode.actions;
    actions.iter_mut().for_each(|action| action.opening = 1.0);
    assert!(!run(&task, &key, Some(&mut Scripted::new("open", actions))).outcome.success);
}

#[test]
fn a_weak_carriage_is_stopped_by_the_table() {
    let task = task("triangle").unwrap();
    let key = key("triangle", Split::Test, 6, 3);
    let setup = TriangleSetup::draw(&key);
    let mut low = setup.world_from_gripper;
    low.translation =
        Vector3::new(-setup.center_m[0].signum() * 0.2, -setup.center_m[1].signum() * 0.2, -0.02);
    let down = SE3::new(low.rotation, low.translation);
    let press = Action { world_from_gripper: down, opening: 1.0 };
    let record = run(task.as_ref(), &key, Some(&mut Scripted::new("press", vec![press; 10])));
    let reached = record.episode.observations[9].world_from_gripper.translation.z;
    assert!(record.outcome.halt.is_none() && reached > -0.005, "pressed to {reached} m");
}
