//! What every registered task must satisfy, written once (after dm_control's suite tests).

use rayon::prelude::*;
use reseflow_data::{
    Episode, IgnoreEvents, ObservationHistory, Policy, RolloutConfig, Scene, Split, Task, rollout,
};
use reseflow_lie::{SE3, geodesic_distance};
use reseflow_sim::{GenerateRequest, Generated, Scripted, Still, generate, is_salient, task, tasks};

use crate::support::{digest, key, run};

fn every_task(law: impl Fn(&dyn Task)) {
    assert!(!tasks().is_empty());
    for name in tasks() {
        law(task(name).unwrap().as_ref());
    }
}

fn demonstrations(task: &dyn Task, split: Split, episodes: usize) -> Generated {
    generate(task, &GenerateRequest::new(split, 3407, episodes), &|| ()).unwrap()
}

/// The D̄_geo of predicting, for every episode, the mean of the commands relative to the gripper's first pose.
fn mean_trajectory_error(episodes: &[Episode]) -> f64 {
    let start = |episode: &Episode| episode.observations[0].world_from_gripper;
    let steps = episodes[0].actions.len();
    let errors = (0..steps).map(|step| {
        let relative: Vec<SE3> = episodes
            .iter()
            .map(|episode| start(episode).inverse() * episode.actions[step].world_from_gripper)
            .collect();
        let mean = SE3::frechet_mean(&relative, &vec![1.0; relative.len()]).unwrap();
        relative.iter().map(|pose| geodesic_distance(&mean, pose).d_geo()).sum::<f64>()
            / relative.len() as f64
    });
    errors.sum::<f64>() / steps as f64
}

#[test]
fn the_registry_knows_its_names_and_no_others() {
    every_task(|task| assert!(tasks().contains(&task.spec().name.as_str())));
    assert!(task("juggling").is_none());
}

#[test]
fn clouds_have_the_papers_sizes() {
    for (name, points) in [("door", 128), ("painting", 256), ("triangle", 100)] {
        assert_eq!(task(name).unwrap().spec().points, points);
    }
}

#[test]
fn the_specification_holds_in_every_frame() {
    every_task(|task| {
        let spec = task.spec();
        assert_eq!((spec.action_steps, spec.ticks_per_action, spec.tick_nanos), (10, 10, 50_000_000));
        for split in [Split::Train, Split::Validation, Split::Test, Split::Wide] {
            let made = demonstrations(task, split, 1);
            assert_eq!((made.episodes.len(), made.keys.len()), (1, 1));
            for episode in &made.episodes {
                assert_eq!((episode.observations.len(), episode.actions.len()), (10, 10));
                for frame in &episode.observations {
                    assert_eq!(
                        (frame.cloud.points.len(), frame.cloud.colors.len()),
                        (spec.points, spec.points)
                    );
                    assert!(frame.cloud.points.iter().flatten().all(|x| x.is_finite() && x.abs() < 1.0));
                    assert!((0.0..=1.0).contains(&frame.gripper_opening));
                }
                assert!(episode.actions.iter().all(|action| (0.0..=1.0).contains(&action.opening)));
            }
        }
    });
}

#[test]
fn the_first_frame_shows_what_the_task_is_about() {
    every_task(|task| {
        for index in 0..30 {
            let frame = task.reset(&key(&task.spec().name, Split::Train, 5, index)).unwrap().observe();
            let salient = frame.cloud.colors.iter().filter(|&&rgb| is_salient(rgb)).count();
            assert!(
                (24..=task.spec().points / 2).contains(&salient),
                "episode {index}: {salient} salient points"
            );
        }
    });
}

#[test]
fn starts_vary_and_no_observation_is_constant() {
    every_task(|task| {
        let frames: Vec<_> = (0..8)
            .map(|index| task.reset(&key(&task.spec().name, Split::Train, 5, index)).unwrap().observe())
            .collect();
        for (index, frame) in frames.iter().enumerate() {
            for other in &frames[..index] {
                assert_ne!(frame.cloud.points, other.cloud.points);
                assert_ne!(frame.cloud.colors, other.cloud.colors);
                assert_ne!(frame.world_from_gripper, other.world_from_gripper);
            }
        }
        let episode = &demonstrations(task, Split::Train, 1).episodes[0];
        for pair in episode.observations.windows(2) {
            assert_ne!(
                pair[0].cloud.points, pair[1].cloud.points,
                "the noise, at least, is new in each frame"
            );
            assert_ne!(pair[0].world_from_gripper, pair[1].world_from_gripper);
        }
        assert!(episode.observations.iter().any(|frame| frame.gripper_opening < 0.9));
    });
}

#[test]
fn splits_seeds_and_attempts_draw_different_scenes() {
    every_task(|task| {
        let name = task.spec().name;
        let mut keys = [
            key(&name, Split::Train, 1, 0),
            key(&name, Split::Test, 1, 0),
            key(&name, Split::Train, 2, 0),
            key(&name, Split::Train, 1, 1),
            key(&name, Split::Train, 1, 0),
        ];
        keys[4].attempt = 1;
        let mut digests: Vec<u64> =
            keys.iter().map(|key| digest(&task.reset(key).unwrap().observe())).collect();
        digests.sort_unstable();
        digests.dedup();
        assert_eq!(digests.len(), 5);
    });
}

#[test]
fn the_expert_succeeds() {
    // An expert of 99 % solves fewer than 22 of 24 once in 600 runs; the full figures are the example `figures`.
    every_task(|task| {
        let name = task.spec().name;
        let succeeds = |split, index| run(task, &key(&name, split, 17, index), None).outcome.success;
        let solved = (0..24_u64)
            .into_par_iter()
            .filter(|&index| succeeds(if index < 14 { Split::Test } else { Split::Wide }, index))
            .count();
        assert!(solved >= 22, "{name}: {solved} of 24");
    });
}

#[test]
fn stored_actions_succeed_when_replayed_and_their_mean_is_a_poor_guess() {
    // As above: 99 % solve fewer than 10 of 12 once in 5000 runs.
    every_task(|task| {
        let made = demonstrations(task, Split::Train, 12);
        let solved = made
            .episodes
            .par_iter()
            .zip(&made.keys)
            .filter(|(episode, key)| {
                let mut replay = Scripted::new("replay", episode.actions.clone());
                run(task, key, Some(&mut replay)).outcome.success
            })
            .count();
        assert!(solved >= 10, "{}: {solved} of 12", task.spec().name);
        let error = mean_trajectory_error(&made.episodes);
        assert!(error >= 0.4, "{}: the mean trajectory is off by {error} only", task.spec().name);
    });
}

#[test]
fn standing_still_solves_nothing_and_moves_nothing() {
    every_task(|task| {
        for index in 0..6 {
            let record = run(task, &key(&task.spec().name, Split::Test, 2, index), Some(&mut Still));
            assert!(!record.outcome.success && record.outcome.halt.is_none());
            assert!(record.outcome.measure.abs() < 1e-3, "{}", record.outcome.measure);
        }
    });
}

#[test]
fn a_disturbance_spoils_the_replay_and_planning_again_survives_it() {
    every_task(|task| {
        let spec = task.spec();
        let episodes = if spec.name == "triangle" { 20 } else { 6 };
        let solved = |policy: &(dyn Fn(&dyn Scene, &ObservationHistory) -> Box<dyn Policy> + Sync)| {
            let succeeds = |&index: &u64| {
                let mut scene = task.reset(&key(&spec.name, Split::Test, 4, index)).unwrap();
                let first = ObservationHistory::new(scene.observe(), 1);
                let mut policy = policy(scene.as_ref(), &first);
                let config = RolloutConfig {
                    observation_horizon: 1,
                    n_action_steps: 1,
                    disturb_before: Some(spec.action_steps),
                    policy_seed: index,
                };
                let record =
                    rollout(scene.as_mut(), &spec, policy.as_mut(), &config, &mut IgnoreEvents).unwrap();
                assert_eq!(record.outcome.halt, None);
                record.outcome.success
            };
            (0..episodes).into_par_iter().filter(succeeds).count() as u64
        };
        // What the expert would do undisturbed: its first plan, whatever happens.
        let replayed = solved(&|scene, first| {
            let plan = scene.expert().plan(first).unwrap();
            Box::new(Scripted::new("replay", plan.actions.0))
        });
        let planned = solved(&|scene, _| scene.expert());
        assert!(
            replayed * 4 <= episodes && planned * 10 >= episodes * 9,
            "{}: of {episodes} the replay solves {replayed}, the expert that plans again {planned}",
            spec.name
        );
    });
}

#[test]
fn an_undisturbed_expert_that_plans_again_gives_the_same_commands() {
    every_task(|task| {
        let spec = task.spec();
        for index in 0..2 {
            let key = key(&spec.name, Split::Test, 18, index);
            let mut scene = task.reset(&key).unwrap();
            let mut expert = scene.expert();
            let config = RolloutConfig {
                observation_horizon: 1,
                n_action_steps: 1,
                disturb_before: None,
                policy_seed: 0,
            };
            let again = rollout(scene.as_mut(), &spec, expert.as_mut(), &config, &mut IgnoreEvents).unwrap();
            assert_eq!(again.episode.actions, run(task, &key, None).episode.actions);
        }
    });
}
