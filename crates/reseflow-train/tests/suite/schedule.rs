//! What is kept, when training ends, what an update is made of, and what is said when it fails.

use reseflow_data::Split;
use reseflow_train::{AugmentConfig, Keep, TrainConfig};

use crate::support::{Shelf, contents, demonstrations, histories, mean_d_geo, tiny_training};

#[test]
fn the_weights_of_the_best_validation_and_the_last_ones_are_both_kept() {
    let shelf = Shelf::new();
    let data = demonstrations(Split::Train, 2);
    // Steps this large and no averaging: the policy wanders about, and the best one is not the last.
    let wild =
        TrainConfig { learning_rate: 0.3, warmup: 0, ema_decay: 0.0, validate_every: 1, ..tiny_training(8) };
    let score = |name: &str| {
        let drawn = shelf.policy(name).predict(&histories(&data, 0), &[3407], 1).unwrap();
        mean_d_geo(&drawn, &data)
    };
    // Where such steps lead is chance; the first seed whose last policy is not its best one shows what is to be shown.
    let mut trainings = (1..=8).map(|seed| {
        let wild = TrainConfig { seed, ..wild.clone() };
        let (last, journal) = shelf.train("last", &wild, &data, Some(&data)).unwrap();
        (wild, last, journal)
    });
    let (wild, last, journal) = trainings
        .find(|(_, last, _)| last.best.unwrap().update < last.validation.unwrap().update)
        .unwrap_or_else(|| panic!("every training ended with its best policy, so this shows nothing"));
    let config = TrainConfig { keep: Keep::Best, ..wild };
    let (best, _) = shelf.train("best", &config, &data, Some(&data)).unwrap();
    println!("{:?}", journal.validations.iter().map(|seen| seen.d_geo).collect::<Vec<_>>());
    let lowest = journal.validations.iter().map(|seen| seen.d_geo).fold(f64::INFINITY, f64::min);
    assert_eq!(best.best.unwrap().d_geo, lowest);
    assert_eq!(score("best"), lowest);
    assert_eq!(score("last"), last.validation.unwrap().d_geo);
    assert!(lowest < score("last"));

    // Each has the other's weights beside its own.
    let [best, last] = ["best", "last"].map(|name| contents(&shelf.path(name)));
    assert!(best["last.safetensors"] == last["model.safetensors"]);
    assert!(last["best.safetensors"] == best["model.safetensors"]);
    assert!(!best.contains_key("best.safetensors") && !last.contains_key("last.safetensors"));
}

#[test]
fn training_ends_once_validations_stop_improving() {
    let shelf = Shelf::new();
    let data = demonstrations(Split::Train, 1);
    // Without a learning rate every validation is like the first.
    let config = TrainConfig { learning_rate: 0.0, validate_every: 2, patience: 3, ..tiny_training(40) };
    let (summary, journal) = shelf.train("early", &config, &data, Some(&data)).unwrap();
    let at: Vec<usize> = journal.validations.iter().map(|seen| seen.update).collect();
    assert_eq!((summary.updates, journal.updates.len()), (8, 8), "one validation and three more");
    assert_eq!(at, [2, 4, 6, 8]);
    assert_eq!(summary.best.unwrap().update, 2);
    shelf.policy("early");
    for config in [
        TrainConfig { keep: Keep::Best, ..tiny_training(2) },
        TrainConfig { patience: 1, ..tiny_training(2) },
    ] {
        let fault = shelf.train("blind", &config, &data, None).unwrap_err().to_string();
        assert!(fault.contains("needs validation episodes"), "{fault}");
    }
}

#[test]
fn accumulated_batches_are_the_same_update_as_one_batch_in_as_many_shards() {
    let shelf = Shelf::new();
    let data = demonstrations(Split::Train, 3);
    let wide = TrainConfig { batch_size: 4, shards: 2, accumulate: 1, ..tiny_training(6) };
    let long = TrainConfig { batch_size: 2, shards: 1, accumulate: 2, ..wide.clone() };
    let longer = TrainConfig { accumulate: 3, ..long.clone() };
    for (name, config) in [("wide", &wide), ("long", &long), ("longer", &longer)] {
        shelf.train(name, config, &data, None).unwrap();
    }
    let [wide, long, longer] =
        ["wide", "long", "longer"].map(|name| contents(&shelf.path(name))["model.safetensors"].clone());
    assert!(wide == long, "the same windows in the same order gave other weights");
    assert!(long != longer, "a third batch changes nothing");
}

#[test]
fn an_action_that_is_no_number_is_reported_with_the_windows_of_its_shard() {
    let shelf = Shelf::new();
    let mut data = demonstrations(Split::Train, 3);
    for action in &mut data.episodes[2].actions {
        action.world_from_gripper.translation.x = f64::NAN;
    }
    let config = TrainConfig { batch_size: 2, shards: 2, first_window_share: 1.0, ..tiny_training(200) };
    let fault = shelf.train("policy", &config, &data, None).unwrap_err().to_string();
    println!("{fault}");
    // One window in each shard, so the one that is named is the one that is to blame.
    assert!(
        fault.contains("not finite") && fault.contains(" of update ") && fault.contains("(2, 0)"),
        "{fault}"
    );
    assert!(!fault.contains("(0, 0)") && !fault.contains("(1, 0)"), "{fault}");
    assert!(shelf.names().is_empty(), "{:?}", shelf.names());
}

#[test]
fn thinned_and_resized_clouds_train_other_weights() {
    let shelf = Shelf::new();
    let data = demonstrations(Split::Train, 2);
    let plain = tiny_training(4);
    let thinned =
        TrainConfig { augment: AugmentConfig { drop_points: 0.5, ..plain.augment }, ..plain.clone() };
    let resized = TrainConfig { augment: AugmentConfig { scale_std: 0.1, ..plain.augment }, ..plain.clone() };
    for (name, config) in [("plain", &plain), ("thinned", &thinned), ("resized", &resized)] {
        shelf.train(name, config, &data, None).unwrap();
    }
    let [plain, thinned, resized] =
        ["plain", "thinned", "resized"].map(|name| contents(&shelf.path(name))["model.safetensors"].clone());
    assert!(plain != thinned && plain != resized && thinned != resized);
}
