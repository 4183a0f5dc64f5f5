//! Random streams, histories and training windows.

use proptest::prelude::*;
use rand::RngExt;
use reseflow_data::{Disturbance, EpisodeKey, ObservationHistory, PADDING_WEIGHT, Split, Window};

use crate::samples;

fn key() -> EpisodeKey {
    EpisodeKey { task: "door".into(), split: Split::Train, seed: 1, index: 2, attempt: 3 }
}

fn draw(key: &EpisodeKey, purpose: &str) -> [u64; 4] {
    let mut rng = key.rng(purpose);
    std::array::from_fn(|_| rng.random())
}

#[test]
fn every_field_of_a_key_and_the_purpose_name_a_stream_of_their_own() {
    let streams = [
        draw(&key(), "scene"),
        draw(&key(), "camera"),
        draw(&EpisodeKey { task: "painting".into(), ..key() }, "scene"),
        draw(&EpisodeKey { split: Split::Validation, ..key() }, "scene"),
        draw(&EpisodeKey { split: Split::Test, ..key() }, "scene"),
        draw(&EpisodeKey { split: Split::Wide, ..key() }, "scene"),
        draw(&EpisodeKey { seed: 2, ..key() }, "scene"),
        draw(&EpisodeKey { index: 3, ..key() }, "scene"),
        draw(&EpisodeKey { attempt: 2, ..key() }, "scene"),
        // The same numbers in other places, and the same letters cut elsewhere.
        draw(&EpisodeKey { seed: 2, index: 1, ..key() }, "scene"),
        draw(&EpisodeKey { task: "doortrain".into(), ..key() }, "x"),
        draw(&EpisodeKey { task: "door".into(), ..key() }, "trainx"),
    ];
    for (i, left) in streams.iter().enumerate() {
        for (j, right) in streams.iter().enumerate() {
            assert_eq!(left == right, i == j, "streams {i} and {j}");
        }
    }
    assert_eq!(draw(&key(), "scene"), draw(&key().clone(), "scene"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn a_history_rebuilt_is_the_history_lived(seed: u64, steps in 1_usize..8, horizon in 0_usize..5) {
        let episode = samples::dataset(seed, 1, steps, 3).episodes.remove(0);
        let mut lived = ObservationHistory::new(episode.observations[0].clone(), horizon);
        for step in 0..steps {
            if step > 0 {
                lived.push(episode.observations[step].clone());
            }
            let rebuilt = ObservationHistory::at_step(&episode.observations, step, horizon);
            let window = Window { episode: 0, step };
            prop_assert_eq!(lived.frames().len(), horizon.max(1));
            prop_assert!(lived.frames().eq(rebuilt.frames()));
            prop_assert!(lived.frames().eq(window.frames(std::slice::from_ref(&episode), horizon)));
            prop_assert_eq!(lived.latest(), &episode.observations[step]);
            prop_assert_eq!(lived.elapsed_steps(), step);
            // Written out: where the gripper was when its fingers were last open.
            let seen = &episode.observations[..=step];
            let open = seen.iter().rfind(|frame| frame.gripper_opening > 0.9);
            let grasp = open.unwrap_or(&seen[0]).world_from_gripper;
            prop_assert_eq!(lived.world_from_grasp(), grasp);
            prop_assert_eq!(rebuilt.world_from_grasp(), grasp);
            prop_assert_eq!(seen[window.grasp_step(std::slice::from_ref(&episode))].world_from_gripper, grasp);
            prop_assert_eq!(rebuilt.elapsed_steps(), step);
            // Written out: the frame `back` steps ago, the first where there is none.
            for (place, frame) in lived.frames().enumerate() {
                let back = horizon.max(1) - 1 - place;
                prop_assert_eq!(frame, &episode.observations[step.max(back) - back]);
            }
        }
    }

    #[test]
    fn windows_repeat_the_last_action_past_the_end(seed: u64, e in 1_usize..4, steps in 1_usize..7, horizon in 1_usize..12) {
        let episodes = samples::dataset(seed, e, steps, 1).episodes;
        let windows = Window::all(&episodes);
        prop_assert_eq!(windows.len(), e * steps);
        for (at, window) in windows.iter().enumerate() {
            prop_assert_eq!((window.episode, window.step), (at / steps, at % steps));
            let targets: Vec<_> = window.targets(&episodes, horizon).collect();
            prop_assert_eq!(targets.len(), horizon);
            let recorded = horizon.min(steps - window.step);
            for (ahead, target) in targets.iter().enumerate() {
                let actions = &episodes[window.episode].actions;
                prop_assert_eq!(target.padded, ahead >= recorded);
                prop_assert_eq!(target.weight(), if target.padded { PADDING_WEIGHT } else { 1.0 });
                let expected = if ahead < recorded { &actions[window.step + ahead] } else { &actions[steps - 1] };
                prop_assert!(std::ptr::eq(target.action, expected), "windows must not copy");
            }
        }
    }
}

#[test]
fn windows_begin_where_a_disturbance_was_answered() {
    let mut episodes = samples::dataset(3, 2, 4, 2).episodes;
    episodes[0].disturbance = Some(Disturbance { before: 1, answered_from: 2 });
    let windows = Window::all(&episodes);
    let at: Vec<_> = windows.iter().map(|window| (window.episode, window.step)).collect();
    assert_eq!(at, [(0, 2), (0, 3), (1, 0), (1, 1), (1, 2), (1, 3)]);
}
