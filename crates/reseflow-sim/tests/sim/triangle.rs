//! The triangle's goals, and the coin that chooses between two of them.

use rayon::prelude::*;
use reseflow_data::{Action, Episode, Split};
use reseflow_lie::{SE3, Vector3, geodesic_distance};
use reseflow_sim::{GenerateRequest, Generated, Scripted, generate, task};

use crate::support::{key, run};

fn coin_tosses(episodes: usize) -> Generated {
    let task = task("coin_toss").unwrap();
    generate(task.as_ref(), &GenerateRequest::new(Split::Train, 5, episodes), &|| ()).unwrap()
}

/// The commands of the expert that did not act.
fn alternative(episode: &Episode) -> Vec<Action> {
    let poses = episode.alternative.as_ref().unwrap();
    let action = |(action, pose): (&Action, &SE3)| Action { world_from_gripper: *pose, ..*action };
    episode.actions.iter().zip(poses).map(action).collect()
}

/// How far the gripper turns about the vertical from the grasp to the end, radians.
fn turn_of(actions: &[Action]) -> f64 {
    let [grasp, end] = [actions[2], actions[9]].map(|action| action.world_from_gripper.rotation);
    (end * grasp.inverse()).log().dot(&Vector3::z())
}

#[test]
fn every_goal_is_reached_by_its_expert_only() {
    let goals = [("triangle", 90.0_f64), ("triangle_60", 60.0), ("triangle_120", 120.0)];
    for (name, degrees) in goals {
        let task_of_goal = task(name).unwrap();
        let key_of = |task: &str| key(task, Split::Test, 3, 1);
        let outcome = run(task_of_goal.as_ref(), &key_of(name), None).outcome;
        assert!(outcome.success && (outcome.measure - degrees.to_radians()).abs() < 0.1, "{outcome:?}");
        for (other, _) in goals.iter().filter(|(other, _)| *other != name) {
            // The same scene (its key's task is this one), another goal's judge.
            let record = run(task_of_goal.as_ref(), &key_of(name), None);
            let mut replay = Scripted::new("replay", record.episode.actions);
            let judged = run(task(other).unwrap().as_ref(), &key_of(name), Some(&mut replay)).outcome;
            assert!(!judged.success, "{name}'s expert, judged by {other}: {judged:?}");
        }
    }
}

#[test]
fn both_trajectories_of_a_coin_toss_succeed_and_differ_after_the_grasp() {
    let made = coin_tosses(16);
    let task = task("coin_toss").unwrap();
    made.episodes.par_iter().zip(&made.keys).for_each(|(episode, key)| {
        let other = alternative(episode);
        assert!((turn_of(&episode.actions) + turn_of(&other)).abs() < 1e-9);
        assert!((turn_of(&other).abs() - std::f64::consts::FRAC_PI_2).abs() < 1e-9);
        for (step, (a, b)) in episode.actions.iter().zip(&other).enumerate() {
            let apart = geodesic_distance(&a.world_from_gripper, &b.world_from_gripper).d_geo();
            assert_eq!(apart > 0.3, step > 2, "step {step}: {apart}");
        }
        let outcome = run(task.as_ref(), key, Some(&mut Scripted::new("other", other))).outcome;
        assert!(outcome.success, "{outcome:?}");
    });
    let left = made.episodes.iter().filter(|episode| turn_of(&episode.actions) > 0.0).count();
    // Sixteen fair coins all but never fall alike.
    assert!((1..16).contains(&left));
}

#[test]
fn between_the_two_trajectories_of_a_coin_toss_lies_no_success() {
    let made = coin_tosses(4);
    let task = task("coin_toss").unwrap();
    for (episode, key) in made.episodes.iter().zip(&made.keys) {
        let middle = episode.actions.iter().zip(alternative(episode)).map(|(a, b)| a.interpolate(&b, 0.5));
        let mut policy = Scripted::new("middle", middle.collect());
        assert!(!run(task.as_ref(), key, Some(&mut policy)).outcome.success);
    }
}

#[test]
fn only_a_coin_toss_has_a_second_trajectory() {
    for name in ["door", "triangle", "triangle_60", "triangle_120"] {
        let scene = task(name).unwrap().reset(&key(name, Split::Train, 1, 0)).unwrap();
        assert!(scene.alternative().is_none());
    }
}
