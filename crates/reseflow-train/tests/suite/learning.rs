//! Training learns, and the same configuration learns the same thing to the last bit.

use reseflow_data::Split;
use reseflow_flow::TimeSampling;
use reseflow_train::{AugmentConfig, TrainConfig};
use serde_json::Value;

use crate::support::{Shelf, contents, demonstrations, histories, mean_d_geo, tiny_training, untimed};

#[test]
fn a_few_hundred_updates_learn_two_demonstrations_by_heart() {
    let shelf = Shelf::new();
    let data = demonstrations(Split::Train, 2);
    let base = TrainConfig {
        shards: 1,
        first_window_share: 1.0,
        augment: AugmentConfig::NONE,
        weight_decay: 0.0,
        time: TimeSampling { zero_share: 0.5, ..TimeSampling::default() },
        ..tiny_training(250)
    };
    // A learning rate of zero keeps the weights as they were drawn.
    let untrained = TrainConfig { updates: 1, learning_rate: 0.0, validate_every: 1, ..base.clone() };
    shelf.train("untrained", &untrained, &data, None).unwrap();
    let (summary, journal) = shelf.train("trained", &base, &data, None).unwrap();

    let losses: Vec<f64> = journal.updates.iter().map(|update| update.loss).collect();
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (first, last) = (mean(&losses[..5]), mean(&losses[losses.len() - 20..]));
    let seeds: Vec<u64> = (0..10).collect();
    let score =
        |name: &str| mean_d_geo(&shelf.policy(name).predict(&histories(&data, 0), &seeds, 1).unwrap(), &data);
    let (before, after) = (score("untrained"), score("trained"));
    println!(
        "{} parameters, loss {first:.4} to {last:.4}, D_geo {before:.4} to {after:.4}",
        summary.parameters
    );
    assert!(last * 10.0 <= first, "the loss went from {first} to {last} only");
    assert!(after * 5.0 <= before, "D_geo went from {before} to {after} only");
    assert_eq!(summary.parameters, parameters_in(&contents(&shelf.path("trained"))["model.safetensors"]));
}

/// The numbers that a safetensors file declares: eight bytes of header length, then JSON with every tensor's shape.
fn parameters_in(file: &[u8]) -> usize {
    let length = u64::from_le_bytes(file[..8].try_into().unwrap()) as usize;
    let header: Value = serde_json::from_slice(&file[8..8 + length]).unwrap();
    let tensors = header.as_object().unwrap().iter().filter(|(name, _)| *name != "__metadata__");
    let size = |tensor: &Value| -> u64 {
        tensor["shape"].as_array().unwrap().iter().map(|extent| extent.as_u64().unwrap()).product()
    };
    tensors.map(|(_, tensor)| size(tensor) as usize).sum()
}

#[test]
fn one_configuration_gives_one_checkpoint_and_another_seed_another() {
    let shelf = Shelf::new();
    let data = demonstrations(Split::Train, 3);
    let held_out = demonstrations(Split::Validation, 2);
    let config = TrainConfig { shards: 4, ..tiny_training(12) };
    // Two at a time and one alone: more threads than processors, then fewer.
    std::thread::scope(|scope| {
        for name in ["first", "second"] {
            let (shelf, data, held_out, config) = (&shelf, &data, &held_out, &config);
            scope.spawn(move || shelf.train(name, config, data, Some(held_out)).unwrap());
        }
    });
    shelf.train("alone", &config, &data, Some(&held_out)).unwrap();
    let [first, second, alone] = ["first", "second", "alone"].map(|name| contents(&shelf.path(name)));
    assert_eq!(
        first.keys().collect::<Vec<_>>(),
        ["config.toml", "metrics.jsonl", "model.safetensors"],
        "what a checkpoint holds"
    );
    for other in [&second, &alone] {
        assert_eq!(first["config.toml"], other["config.toml"]);
        assert!(first["model.safetensors"] == other["model.safetensors"], "the weights differ");
        assert_eq!(untimed(&first["metrics.jsonl"]), untimed(&other["metrics.jsonl"]));
    }
    assert_eq!(untimed(&first["metrics.jsonl"]).len(), 13, "12 updates and a validation");

    shelf.train("other", &TrainConfig { seed: 2, ..config }, &data, Some(&held_out)).unwrap();
    let other = contents(&shelf.path("other"));
    assert!(first["config.toml"] != other["config.toml"], "the configuration does not say the seed");
    assert!(first["model.safetensors"] != other["model.safetensors"], "the seed changes nothing");
    let (mine, theirs) = (untimed(&first["metrics.jsonl"]), untimed(&other["metrics.jsonl"]));
    assert!(mine.iter().zip(&theirs).all(|(a, b)| a != b), "no line is the same");
}

#[test]
fn the_metrics_file_is_what_the_observer_heard() {
    let shelf = Shelf::new();
    let data = demonstrations(Split::Train, 1);
    let config = TrainConfig { validate_every: 4, clip_norm: 1e-3, ..tiny_training(10) };
    let (summary, journal) = shelf.train("policy", &config, &data, Some(&data)).unwrap();
    let text = contents(&shelf.path("policy"))["metrics.jsonl"].clone();
    let lines: Vec<Value> =
        std::str::from_utf8(&text).unwrap().lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let (updates, validations): (Vec<_>, Vec<_>) =
        lines.into_iter().partition(|line| line.get("loss").is_some());
    assert_eq!(updates.len(), journal.updates.len());
    for (line, heard) in updates.iter().zip(&journal.updates) {
        assert_eq!(line, &reread(heard));
        assert!(heard.gradient_norm > config.clip_norm, "the norm is the one before clipping");
    }
    let at: Vec<usize> = journal.validations.iter().map(|validation| validation.update).collect();
    assert_eq!(at, [4, 8, 10], "every fourth update and the last");
    assert_eq!(validations, journal.validations.iter().map(reread).collect::<Vec<_>>());
    assert_eq!(summary.validation.unwrap().d_geo, journal.validations[2].d_geo);
    let rates: Vec<f64> = journal.updates.iter().map(|update| update.learning_rate).collect();
    assert!(rates.iter().all(|rate| (0.0..=config.learning_rate).contains(rate)), "{rates:?}");
}

/// A value as it comes back from its JSON text.
fn reread(value: &impl serde::Serialize) -> Value {
    serde_json::from_str(&serde_json::to_string(value).unwrap()).unwrap()
}
