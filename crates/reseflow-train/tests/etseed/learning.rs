//! Training learns, the same configuration learns the same to the last bit, and what is learned stays away from Log's cut.

use std::f64::consts::PI;

use reseflow_data::{Split, Window};
use reseflow_train::{AugmentConfig, EtSeedConfig, TrainConfig, TrainError};

use crate::support::{Shelf, demonstrations, histories, mean_d_geo, tiny_config, tiny_training};

#[test]
fn a_few_hundred_updates_learn_a_demonstration_by_heart_and_every_respacing_recalls_it() {
    let shelf = Shelf::new();
    let data = demonstrations(Split::Train, 1);
    let base = TrainConfig {
        first_window_share: 1.0,
        augment: AugmentConfig::NONE,
        weight_decay: 0.0,
        ..tiny_training(800)
    };
    // A learning rate of zero keeps the weights as they were drawn.
    let untrained = TrainConfig { updates: 1, learning_rate: 0.0, validate_every: 1, ..base.clone() };
    shelf.train("untrained", &tiny_config(), &untrained, &data, None).unwrap();
    let (summary, journal) = shelf.train("trained", &tiny_config(), &base, &data, None).unwrap();
    let losses: Vec<f64> = journal.updates.iter().map(|update| update.loss).collect();
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (first, last) = (mean(&losses[..5]), mean(&losses[losses.len() - 20..]));
    println!("{} parameters, loss {first:.4} to {last:.4}", summary.parameters);
    let mut scores = Vec::new();
    for steps in [1, 2, 10, 50, 100] {
        let score = |name: &str| {
            let drawn = shelf.policy(name).predict(&histories(&data, 0), &[0, 1, 2, 3, 4], steps).unwrap();
            mean_d_geo(&drawn, &data)
        };
        let (before, after) = (score("untrained"), score("trained"));
        println!("{steps} steps: D_geo {before:.4} to {after:.4}");
        scores.push((steps, before, after));
    }
    for (steps, before, after) in scores {
        let most = if steps < 10 { 0.2 } else { 0.1 };
        assert!(after * 5.0 <= before && after < most, "{steps} steps: from {before} to {after} only");
    }
    assert!(last * 5.0 <= first, "the loss went from {first} to {last} only");
}

/// Relative to the world's origin a gripper that points down is half a turn away, where Log jumps; relative to the gripper it is not.
#[test]
fn no_target_comes_near_the_cut_of_the_logarithm() {
    let data = demonstrations(Split::Train, 30);
    let (mut relative, mut absolute) = (0.0_f64, 0.0_f64);
    for window in Window::all(&data.episodes) {
        let seen = window.frames(&data.episodes, 1).next().unwrap();
        let gripper_from_world = seen.world_from_gripper.inverse();
        for target in window.targets(&data.episodes, 10) {
            let pose = target.action.world_from_gripper;
            relative = relative.max((gripper_from_world * pose).rotation.angle());
            absolute = absolute.max(pose.rotation.angle());
        }
    }
    println!("largest angle {relative:.2} rad from the gripper, {absolute:.2} rad from the world");
    assert!(relative < PI - 0.1, "{relative} rad, and half a turn is π");
    assert!(absolute > PI - 0.01, "control: in the world's frame they do, {absolute} rad");
}

#[test]
fn one_configuration_gives_one_checkpoint_and_another_seed_another() {
    let shelf = Shelf::new();
    let (data, held_out) = (demonstrations(Split::Train, 2), demonstrations(Split::Validation, 2));
    let config = tiny_config();
    let train = tiny_training(8);
    for (name, seed) in [("first", 1), ("second", 1), ("other", 2)] {
        let train = TrainConfig { seed, ..train.clone() };
        let (summary, journal) = shelf.train(name, &config, &train, &data, Some(&held_out)).unwrap();
        assert_eq!((journal.updates.len(), journal.validations.len(), summary.updates), (8, 1, 8));
        // The trainer scores the weights that it holds in memory, so the file must score the same to the last bit.
        let drawn = shelf.policy(name).predict(&histories(&held_out, 0), &[3407], 100).unwrap();
        assert_eq!(mean_d_geo(&drawn, &held_out), summary.validation.unwrap().d_geo);
    }
    let [first, second, other] = ["first", "second", "other"]
        .map(|name| std::fs::read(shelf.path(name).join("model.safetensors")).unwrap());
    assert!(first == second, "the weights differ");
    assert!(first != other, "the seed changes nothing");
}

#[test]
fn what_cannot_be_trained_is_refused_and_a_number_that_is_none_is_reported_with_its_windows() {
    let shelf = Shelf::new();
    let data = demonstrations(Split::Train, 1);
    let good = tiny_training(1);
    for (key, train) in [
        ("patience", TrainConfig { patience: 2, ..good.clone() }),
        ("updates", TrainConfig { updates: 0, ..good.clone() }),
    ] {
        let fault = shelf.train("never", &tiny_config(), &train, &data, None).unwrap_err().to_string();
        assert!(fault.contains(&format!("train.{key}")), "{fault}");
    }
    for (key, config) in [
        ("last_step_share", EtSeedConfig { last_step_share: -0.1, ..tiny_config() }),
        ("last_step_share", EtSeedConfig { last_step_share: 0.0, ..tiny_config() }),
        ("last_step_share", EtSeedConfig { last_step_share: 1.0, ..tiny_config() }),
        ("noisiest_share", EtSeedConfig { noisiest_share: 1.1, ..tiny_config() }),
    ] {
        let fault = shelf.train("never", &config, &good, &data, None).unwrap_err().to_string();
        assert!(fault.contains(&format!("baseline.{key}")), "{fault}");
    }
    let mut broken = data.clone();
    broken.episodes[0].actions[4].opening = f64::NAN;
    let train = TrainConfig { updates: 50, ..good };
    let fault = shelf.train("never", &tiny_config(), &train, &broken, None).unwrap_err();
    let TrainError::Batch { windows, .. } = &fault else { panic!("{fault}") };
    assert!(!windows.is_empty(), "{fault}");
    assert!(!shelf.path("never").exists());
}
