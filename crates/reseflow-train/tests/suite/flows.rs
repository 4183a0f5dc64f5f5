//! Every kind of flow that the network can express trains, loads and moves with the scene.

use reseflow_data::{ActionChunk, Split};
use reseflow_flow::{HaarPrior, ObjectiveConfig, Path, PoseError, Prior};
use reseflow_train::{DeviceKind, FlowPolicy, ModelConfig, TrainConfig};

use crate::equivariance::{SEEDS, errors};
use crate::support::{Shelf, contents, demonstrations, histories, tiny_model, tiny_training};

#[test]
fn every_prior_path_and_error_trains_and_moves_with_the_scene() {
    let (data, held_out) = (demonstrations(Split::Train, 4), demonstrations(Split::Validation, 4));
    let seen = histories(&held_out, 0);
    let haar = Prior::Haar(HaarPrior::default());
    for (name, prior, path, error, pseudo_huber) in [
        ("haar", haar, Path::Screw, PoseError::Chordal, Some(1.0)),
        ("product", tiny_model().prior, Path::Product, PoseError::Chordal, None),
        ("twist", tiny_model().prior, Path::Screw, PoseError::Twist, None),
        ("all three", haar, Path::Product, PoseError::Twist, Some(1.0)),
    ] {
        let shelf = Shelf::new();
        let model = ModelConfig { prior, path, ..tiny_model() };
        let objective = ObjectiveConfig { error, pseudo_huber, ..ObjectiveConfig::default() };
        let config = TrainConfig { objective, warmup: 5, ..tiny_training(80) };
        let (_, journal) = shelf.train_model(name, &model, &config, &data, None).unwrap();
        let losses: Vec<f64> = journal.updates.iter().map(|update| update.loss).collect();
        let mean = |losses: &[f64]| losses.iter().sum::<f64>() / losses.len() as f64;
        let (first, last) = (mean(&losses[..5]), mean(&losses[70..]));

        let policy = shelf.policy(name);
        let together = errors(&policy, &seen, 3, true);
        let typical = together[together.len() * 99 / 100];
        let left_behind = errors(&policy, &seen, 3, false);
        let median = left_behind[left_behind.len() / 2];
        println!("{name}: loss {first:.3} to {last:.3}, moved {typical:.1e}, left behind {median:.1e}");
        assert!(last < 0.6 * first, "{name}: the loss went from {first} to {last} only");
        assert!(typical < 1e-4, "{name}: {typical}");
        assert!(median > 1e-2, "{name}: moving the cloud alone changes too little: {median}");
    }
}

#[test]
fn a_checkpoint_from_before_there_was_a_choice_loads_as_it_was() {
    let (shelf, data) = (Shelf::new(), demonstrations(Split::Train, 1));
    shelf.train("new", &tiny_training(2), &data, None).unwrap();
    let old = shelf.path("old");
    std::fs::create_dir(&old).unwrap();
    for (name, bytes) in contents(&shelf.path("new")) {
        let bytes = if name == "config.toml" {
            let text = toml::to_string(&tiny_model()).unwrap();
            let (before, after): (Vec<_>, Vec<_>) =
                text.lines().partition(|line| line.starts_with("kind =") || line.starts_with("path ="));
            assert_eq!(before.len(), 2, "{text}");
            after.join("\n").into_bytes()
        } else {
            bytes
        };
        std::fs::write(old.join(name), bytes).unwrap();
    }
    let draw = |policy: FlowPolicy| policy.predict(&histories(&data, 0), &SEEDS, 2).unwrap();
    assert_eq!(draw(FlowPolicy::load(&old, DeviceKind::Cpu).unwrap()), draw(shelf.policy("new")));
}

#[test]
fn a_traced_way_leads_from_its_noise_to_what_the_policy_draws() {
    let (shelf, data) = (Shelf::new(), demonstrations(Split::Train, 2));
    shelf.train("flow", &tiny_training(20), &data, None).unwrap();
    let policy = shelf.policy("flow");
    let first = histories(&data, 0);
    let ways = policy.trace(&first[0], &[5, 6], 4).unwrap();
    assert_eq!(ways.iter().map(Vec::len).collect::<Vec<_>>(), [5, 5]);
    let poses =
        |chunk: &ActionChunk| chunk.iter().map(|action| action.world_from_gripper).collect::<Vec<_>>();
    for (way, seed) in ways.iter().zip([5, 6]) {
        let drawn = policy.predict(&first[..1], &[seed], 4).unwrap();
        assert_eq!(poses(&way[4]), poses(&drawn[0][0].consensus), "the way of seed {seed} ends elsewhere");
        assert!(way.windows(2).all(|pair| pair[0] != pair[1]), "the way of seed {seed} stands still");
    }
    assert_ne!(ways[0][0], ways[1][0], "two seeds start at the same noise");
    assert_eq!(policy.trace(&first[0], &[5], 1).unwrap()[0][0], ways[0][0], "the noise depends on the steps");
    assert!(policy.trace(&first[0], &[5], 0).is_err());
}
