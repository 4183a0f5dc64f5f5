//! What was trained is what is loaded.

use reseflow_data::{ObservationHistory, Policy, Split};
use reseflow_net::Symmetry;
use reseflow_train::{
    CheckpointConfig, DeviceKind, FlowPolicy, ModelConfig, PolicyKind, TrainConfig, read_kind,
};

use crate::support::{Shelf, contents, demonstrations, histories, mean_d_geo, tiny_model, tiny_training};

/// The trainer validates the weights that it holds in memory, so the file must score the same to the last bit.
#[test]
fn a_loaded_policy_predicts_what_the_trained_one_did() {
    reads_back_what_was_trained(&tiny_model());
}

#[test]
fn a_loaded_policy_of_higher_degrees_predicts_what_the_trained_one_did() {
    let mut model = tiny_model();
    (model.network.encoder.layers, model.network.encoder.max_degree) = (2, 2);
    reads_back_what_was_trained(&model);
}

#[test]
fn a_loaded_policy_of_less_symmetry_predicts_what_the_trained_one_did() {
    for symmetry in [Symmetry::Upright, Symmetry::None] {
        let mut model = tiny_model();
        model.network.symmetry = symmetry;
        reads_back_what_was_trained(&model);
    }
}

fn reads_back_what_was_trained(model: &ModelConfig) {
    let shelf = Shelf::new();
    let data = demonstrations(Split::Train, 2);
    let held_out = demonstrations(Split::Validation, 3);
    let config = TrainConfig { ema_decay: 0.9, ..tiny_training(15) };
    let (summary, _) = shelf.train_model("policy", model, &config, &data, Some(&held_out)).unwrap();
    let policy = shelf.policy("policy");
    let seen = histories(&held_out, 0);
    let drawn = policy.predict(&seen, &[3407], 1).unwrap();
    assert_eq!(mean_d_geo(&drawn, &held_out), summary.validation.unwrap().d_geo);

    let text = contents(&shelf.path("policy"))["config.toml"].clone();
    let kept: CheckpointConfig<ModelConfig> = toml::from_str(std::str::from_utf8(&text).unwrap()).unwrap();
    assert_eq!((kept.kind, kept.model, kept.train), (PolicyKind::Flow, model.clone(), Some(config)));

    // A checkpoint that says no kind is a flow's, and its whole configuration is the model's.
    let old = toml::to_string(model).unwrap();
    std::fs::write(shelf.path("policy").join("config.toml"), old).unwrap();
    assert_eq!(shelf.policy("policy").predict(&seen, &[3407], 1).unwrap(), drawn);
    assert_eq!(read_kind(&shelf.path("policy")).unwrap(), (PolicyKind::Flow, None));

    std::fs::rename(shelf.path("policy"), shelf.path("moved")).unwrap();
    assert_eq!(shelf.policy("moved").predict(&seen, &[3407], 1).unwrap(), drawn);
}

#[test]
fn a_policy_predicts_the_same_alone_and_among_others_for_the_same_stream() {
    let shelf = Shelf::new();
    let data = demonstrations(Split::Train, 3);
    shelf.train("policy", &tiny_training(5), &data, None).unwrap();
    let policy = shelf.policy("policy");
    let seen = histories(&data, 3);
    let together = policy.predict(&seen, &[1, 2], 3).unwrap();
    assert_eq!(together.iter().map(Vec::len).collect::<Vec<_>>(), [2, 2, 2]);
    assert_ne!(together[0][0], together[0][1], "seeds differ");
    let alone = policy.predict(&seen[..1], &[2], 3).unwrap();
    for (one, other) in alone[0][0].consensus.iter().zip(together[0][1].consensus.iter()) {
        let between = reseflow_lie::geodesic_distance(&one.world_from_gripper, &other.world_from_gripper);
        assert!(between.d_geo() < 1e-5, "a neighbour in the batch changed a prediction by {between:?}");
    }
    for sample in together.iter().flatten() {
        assert_eq!((sample.nodes.len(), sample.spread.len()), (2, 10));
        assert!(sample.spread.iter().all(|spread| spread.is_finite() && *spread >= 0.0));
        assert!(sample.consensus.iter().all(|action| (0.0..=1.0).contains(&action.opening)));
    }
    assert!(policy.predict(&[], &[1], 1).unwrap().is_empty());
    assert!(policy.predict(&seen, &[1], 0).unwrap_err().to_string().contains("at least 1 step"));
}

#[test]
fn a_reset_replays_the_plans_of_an_episode_and_each_plan_has_its_own_noise() {
    let shelf = Shelf::new();
    let data = demonstrations(Split::Train, 1);
    shelf.train("policy", &tiny_training(5), &data, None).unwrap();
    let mut policy = shelf.policy("policy");
    let seen = histories(&data, 0).remove(0);
    let mut plans = |seed: u64| {
        policy.reset(seed);
        [(); 3].map(|()| policy.plan(&seen).unwrap())
    };
    let first = plans(7);
    assert_eq!(plans(7), first);
    assert_ne!(plans(8)[0], first[0]);
    assert!(first[0] != first[1] && first[1] != first[2], "plans of one episode share their noise");
    assert_eq!(first[0].uncertainty.as_ref().map(Vec::len), Some(10));
}

#[test]
fn both_processor_backends_predict_the_same_trajectory() {
    let shelf = Shelf::new();
    let data = demonstrations(Split::Train, 2);
    shelf.train("policy", &tiny_training(10), &data, None).unwrap();
    let predict = |device: DeviceKind| {
        let policy = FlowPolicy::load(&shelf.path("policy"), device).unwrap();
        policy.predict(&histories(&data, 0), &[3407, 3408], 2).unwrap()
    };
    let (flex, ndarray) = (predict(DeviceKind::Flex), predict(DeviceKind::Ndarray));
    let mut worst: f64 = 0.0;
    for (one, other) in flex.iter().flatten().zip(ndarray.iter().flatten()) {
        for (one, other) in one.consensus.iter().zip(other.consensus.iter()) {
            let between = reseflow_lie::geodesic_distance(&one.world_from_gripper, &other.world_from_gripper);
            worst = worst.max(between.d_geo());
        }
    }
    println!("flex against ndarray: {worst:.2e}");
    assert!(worst < 1e-4, "{worst}");
}

#[test]
fn an_observation_that_the_network_cannot_use_is_an_error() {
    let shelf = Shelf::new();
    let data = demonstrations(Split::Train, 1);
    shelf.train("policy", &tiny_training(2), &data, None).unwrap();
    let policy = shelf.policy("policy");
    let frame = &data.episodes[0].observations[0];
    let refuses = |history: ObservationHistory, part: &str| {
        let error = policy.predict(&[history], &[1], 1).unwrap_err().to_string();
        assert!(error.contains(part), "expected `{part}` in: {error}");
    };
    for frames in [1, 3] {
        refuses(ObservationHistory::new(frame.clone(), frames), &format!("expected 2, got {frames}"));
    }
    let mut empty = frame.clone();
    empty.cloud.points.clear();
    empty.cloud.colors.clear();
    refuses(ObservationHistory::new(empty, 2), "empty");
    let mut broken = frame.clone();
    broken.cloud.points[4][1] = f32::NAN;
    refuses(ObservationHistory::new(broken, 2), "point 4");
    let mut nowhere = frame.clone();
    nowhere.world_from_gripper.translation.x = f64::NAN;
    refuses(ObservationHistory::new(nowhere, 2), "finite");
}

#[cfg(unix)]
#[test]
fn every_file_of_a_checkpoint_has_the_permissions_of_an_ordinary_one() {
    use std::os::unix::fs::PermissionsExt;
    let shelf = Shelf::new();
    shelf.train("policy", &tiny_training(2), &demonstrations(Split::Train, 1), None).unwrap();
    std::fs::write(shelf.path("plain"), "").unwrap();
    let mode = |path: std::path::PathBuf| std::fs::metadata(path).unwrap().permissions().mode();
    for name in contents(&shelf.path("policy")).keys() {
        assert_eq!(mode(shelf.path("policy").join(name)), mode(shelf.path("plain")), "{name}");
    }
}

#[test]
fn predictions_do_not_depend_on_how_many_are_made_at_once() {
    let shelf = Shelf::new();
    let data = demonstrations(Split::Train, 2);
    shelf.train("policy", &tiny_training(5), &data, None).unwrap();
    let policy = shelf.policy("policy");
    let seen = histories(&data, 2);
    // 66 histories are drawn in three groups; the last history of the first group and those behind it see their own streams.
    let many: Vec<_> = (0..66).map(|index| seen[index % 2].clone()).collect();
    let all = policy.predict(&many, &[5], 2).unwrap();
    // The sums of a smaller batch are rounded otherwise, no more.
    for end in [20, 66] {
        for (index, one) in policy.predict(&many[..end], &[5], 2).unwrap().iter().enumerate() {
            for (a, b) in one[0].consensus.iter().zip(all[index][0].consensus.iter()) {
                let apart = reseflow_lie::geodesic_distance(&a.world_from_gripper, &b.world_from_gripper);
                assert!(apart.d_geo() < 1e-5, "history {index} among {end}: {apart:?}");
            }
        }
    }
    assert_eq!(all.len(), 66);
    for (index, one) in all.iter().enumerate() {
        assert!(!all[..index].contains(one), "history {index} has the noise of another one");
    }
}
