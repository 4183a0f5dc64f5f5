//! The physics is honest: contact moves the object, nothing sinks in, halving the step changes little.

use rayon::prelude::*;
use reseflow_data::{Action, Contact, EpisodeObserver, Scene, Split, Task, Tick};
use reseflow_lie::{SE3, Vector3};
use reseflow_sim::{Scripted, TriangleSetup, TriangleTask, task};

use crate::support::{key, run, run_observed};

/// Every contact, and how far the gripper lagged behind its command at the end of each action step.
#[derive(Default)]
struct Record {
    contacts: Vec<Contact>,
    lag_m: Vec<f64>,
    turned_before_contact: f64,
    touched: bool,
    ticks: usize,
}

impl EpisodeObserver for Record {
    fn on_tick(&mut self, tick: &Tick, _scene: &mut dyn Scene) {
        self.ticks += 1;
        let of_gripper = |contact: &&Contact| {
            contact.body_a.starts_with("gripper") && contact.body_b == "triangle" && contact.force_n > 0.0
        };
        self.touched |= tick.contacts.iter().any(|contact| of_gripper(&contact));
        if !self.touched {
            self.turned_before_contact = self.turned_before_contact.max(tick.measure.abs());
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
    let outcome =
        run_observed(task, &key("triangle", Split::Test, 6, index), None, None, &mut record).outcome;
    assert!(outcome.success);
    record
}

#[test]
fn the_triangle_moves_by_contact_only_and_hardly_sinks_in() {
    let task = TriangleTask::default();
    let records: Vec<Record> = (0..40_u64).into_par_iter().map(|index| expert_record(&task, index)).collect();
    let mut depths: Vec<f64> = Vec::new();
    for record in &records {
        assert!(record.touched);
        assert!(
            record.turned_before_contact < 1e-3,
            "turned by {} rad untouched",
            record.turned_before_contact
        );
        depths.extend(record.contacts.iter().map(|contact| contact.depth_m));
        let lag = record.lag_m.iter().copied().fold(0.0, f64::max);
        assert!(lag < 1.5e-3, "the gripper lags {lag} m behind at the end of a step");
    }
    depths.sort_by(f64::total_cmp);
    let p99 = depths[depths.len() * 99 / 100];
    assert!(depths.len() > 4000 && p99 < 1e-3, "{} contacts, 99th percentile {p99} m", depths.len());
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
    let coarse = TriangleTask::default();
    let mut fine = coarse;
    fine.physics.substeps *= 2;
    assert!((fine.physics.dt_secs() - 0.5 * coarse.physics.dt_secs()).abs() < 1e-15);
    for index in 0..20 {
        let key = key("triangle", Split::Test, 8, index);
        let (a, b) = (run(&coarse, &key, None).outcome, run(&fine, &key, None).outcome);
        assert_eq!(a.success, b.success);
        assert!((a.measure / b.measure - 1.0).abs() < 0.05, "{} against {}", a.measure, b.measure);
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
