//! A checkpoint appears whole or not at all; what was there before is replaced by a whole one only, and nothing else is ever touched.

use reseflow_data::{Dataset, Split};
use reseflow_train::TrainConfig;

use crate::support::{Shelf, contents, demonstrations, tiny_training};

#[test]
fn a_run_that_fails_leaves_the_old_checkpoint_and_no_litter() {
    let shelf = Shelf::new();
    let good = demonstrations(Split::Train, 2);
    let config = tiny_training(3);
    shelf.train("policy", &config, &good, None).unwrap();
    let old = contents(&shelf.path("policy"));

    let mut nan_points = good.clone();
    for episode in &mut nan_points.episodes {
        episode.observations.iter_mut().for_each(|seen| seen.cloud.points[7][2] = f32::NAN);
    }
    let mut nan_actions = good.clone();
    for episode in &mut nan_actions.episodes {
        episode.actions.iter_mut().for_each(|action| action.world_from_gripper.translation.z = f64::NAN);
    }
    let mut no_actions = good.clone();
    no_actions.episodes[1].actions.clear();
    let empty = Dataset::default();
    let uneven = TrainConfig { batch_size: 3, ..config.clone() };
    let cases: [(&str, &TrainConfig, &Dataset, Option<&Dataset>, &str); 8] = [
        ("an impossible batch", &uneven, &good, None, "train.batch_size"),
        ("NaN among the points", &config, &nan_points, None, "point 7"),
        ("NaN among the actions", &config, &nan_actions, None, "token 0 is not finite: shard "),
        ("no episode", &config, &empty, None, "no episode"),
        ("an episode without actions", &config, &no_actions, None, "episode 1"),
        ("NaN in validation, after the last update", &config, &good, Some(&nan_points), "point 7"),
        ("no episode to validate on", &config, &good, Some(&empty), "no episode"),
        ("validation without actions", &config, &good, Some(&no_actions), "episode 1"),
    ];
    for (what, config, data, validation, part) in cases {
        for name in ["policy", "new"] {
            let Err(fault) = shelf.train(name, config, data, validation) else {
                panic!("{what}: the training went through");
            };
            assert!(fault.to_string().contains(part), "{what}: expected `{part}` in: {fault}");
            assert_eq!(shelf.names(), ["policy"], "{what}: only the old checkpoint is there");
        }
        assert!(contents(&shelf.path("policy")) == old, "{what}: the old checkpoint was touched");
    }

    shelf.train("policy", &TrainConfig { seed: 5, ..config }, &good, None).unwrap();
    let new = contents(&shelf.path("policy"));
    assert_eq!(shelf.names(), ["policy"], "a replacement leaves no litter");
    assert!(new.keys().eq(old.keys()) && new["model.safetensors"] != old["model.safetensors"]);
    shelf.policy("policy");
}

#[test]
fn a_checkpoint_never_replaces_what_is_no_checkpoint() {
    let shelf = Shelf::new();
    let data = demonstrations(Split::Train, 1);
    let config = tiny_training(2);

    std::fs::write(shelf.path("file"), "a result").unwrap();
    let fault = shelf.train("file", &config, &data, None).unwrap_err().to_string();
    assert!(fault.contains("file: ") && fault.contains("folder"), "{fault}");
    assert_eq!(std::fs::read(shelf.path("file")).unwrap(), b"a result");

    shelf.train("mine", &config, &data, None).unwrap();
    std::fs::write(shelf.path("mine/notes.txt"), "do not lose").unwrap();
    let before = contents(&shelf.path("mine"));
    let fault = shelf.train("mine", &config, &data, None).unwrap_err().to_string();
    assert!(fault.contains("mine: ") && fault.contains("notes.txt"), "{fault}");
    assert!(contents(&shelf.path("mine")) == before);

    std::fs::create_dir(shelf.path("empty")).unwrap();
    shelf.train("empty", &config, &data, None).unwrap();
    shelf.policy("empty");

    shelf.train("deep/in/the/tree", &config, &data, None).unwrap();
    shelf.policy("deep/in/the/tree");
    assert_eq!(shelf.names(), ["deep", "empty", "file", "mine"]);
}
