//! `reseflow run`: every result is there, and only what has to be is done again.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use reseflow_data::{Dataset, McapSummary};
use serde_json::Value;

use crate::support::{Bench, TINY};

const STAGES: [&str; 8] =
    ["data-train", "data-test", "data-validation", "train", "training-log", "eval", "rollout", "latency"];

/// The stages that a call of `reseflow run` did, in order.
fn done(bench: &Bench, options: &str) -> Vec<String> {
    let summary = bench.json(&format!("run tiny.toml --json {options}"));
    let stages = summary["stages"].as_array().unwrap();
    assert_eq!(stages.iter().map(|stage| stage["name"].as_str().unwrap()).collect::<Vec<_>>(), STAGES);
    let fresh = stages.iter().filter(|stage| stage["skipped"] == false);
    fresh.map(|stage| stage["name"].as_str().unwrap().to_owned()).collect()
}

/// Every file below `folder` but those that say when they were made.
fn results(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(&next).unwrap() {
            let path = entry.unwrap().path();
            let name = path.strip_prefix(folder).unwrap().display().to_string();
            if path.is_dir() {
                folders.push(path);
            } else if name != "summary.json" {
                found.insert(name, fs::read(&path).unwrap());
            }
        }
    }
    found
}

#[test]
fn a_run_leaves_every_result_and_a_second_one_does_only_what_has_changed() {
    let bench = Bench::new();
    fs::write(bench.path("tiny.toml"), TINY).unwrap();
    assert_eq!(done(&bench, ""), STAGES, "everything is new");
    check_results(&bench);
    let first = results(&bench.path("runs/tiny"));
    assert!(
        first.keys().all(|name| !name.split('/').any(|part| part.starts_with('.'))),
        "{:?}",
        first.keys()
    );

    let nothing: [&str; 0] = [];
    assert_eq!(done(&bench, ""), nothing);
    assert!(results(&bench.path("runs/tiny")) == first, "a run with nothing to do changed a result");

    assert_eq!(done(&bench, "--set eval.seeds=3"), ["eval"]);
    assert_eq!(bench.read_json("runs/tiny/eval.json")["seeds"], serde_json::json!([3407, 3408, 3409]));
    assert_eq!(done(&bench, "--set eval.seeds=3 --set rollout.n_action_steps=10"), ["rollout"]);
    let after_training = ["train", "training-log", "eval", "rollout", "latency"];
    assert_eq!(done(&bench, "--set train.updates=31"), after_training, "the rest hangs on it");
    assert_eq!(
        done(&bench, "--set train.updates=31 --set data.test_episodes=3"),
        ["data-test", "eval", "latency"],
        "training does not look at the test split"
    );
    fs::remove_file(bench.path("runs/tiny/pictures/per_action.png")).unwrap();
    assert_eq!(
        done(&bench, "--set train.updates=31 --set data.test_episodes=3"),
        ["eval"],
        "a picture was gone"
    );

    // Back to the start and all over again: the same figures, whatever happened in between.
    assert_eq!(done(&bench, "--fresh"), STAGES);
    let again = results(&bench.path("runs/tiny"));
    assert!(first.keys().eq(again.keys()));
    for name in
        ["data/train.npz", "data/test.npz", "checkpoint/model.safetensors", "rollout.mcap", "config.toml"]
    {
        assert!(first[name] == again[name], "{name} differs between two runs of one configuration");
    }
    let scores = |results: &BTreeMap<String, Vec<u8>>| -> Vec<Value> {
        let eval: Value = serde_json::from_slice(&results["eval.json"]).unwrap();
        eval["rows"].as_array().unwrap().iter().map(|row| row["per_action_mean"].clone()).collect()
    };
    assert_eq!(scores(&first), scores(&again));
}

/// The files of a finished run hold what they are called.
fn check_results(bench: &Bench) {
    let at = |name: &str| format!("runs/tiny/{name}");
    for (split, episodes) in [("train", 3), ("test", 2), ("validation", 2)] {
        assert_eq!(Dataset::read(bench.path(&at(&format!("data/{split}.npz")))).unwrap().len(), episodes);
    }
    for name in ["checkpoint/model.safetensors", "checkpoint/config.toml", "checkpoint/metrics.jsonl"] {
        assert!(!bench.bytes(&at(name)).is_empty());
    }
    let eval = bench.read_json(&at("eval.json"));
    let steps: Vec<&Value> = eval["rows"].as_array().unwrap().iter().map(|row| &row["steps"]).collect();
    assert_eq!(steps, [1, 3]);
    assert_eq!([&eval["task"], &eval["split"]], ["triangle", "test"]);
    for row in eval["rows"].as_array().unwrap() {
        assert_eq!((&row["evaluations"], row["solver"].as_str()), (&row["steps"], Some("euler")));
        for key in ["d_geo_mean", "d_geo_std", "rotation_rad", "translation_m", "opening_error"] {
            assert!(row[key].as_f64().is_some_and(|value| value >= 0.0), "`{key}` of {row}");
        }
        for (key, length) in [("per_action_mean", 10), ("per_action_std", 10), ("per_node", 2)] {
            assert_eq!(row[key].as_array().map(Vec::len), Some(length), "`{key}`");
        }
    }
    for predictor in ["mean_trajectory", "nearest_demonstration"] {
        assert!(eval["trivial"][predictor]["d_geo_mean"].as_f64().unwrap() > 0.0, "{predictor}");
    }
    assert_eq!(
        eval["config"]["model"]["network"]["encoder"]["channels"], 8,
        "the checkpoint's configuration"
    );
    assert_eq!(
        (&eval["config"]["task"], &eval["config"]["train"]["updates"]),
        (&Value::from("triangle"), &Value::from(30))
    );
    assert_eq!((&eval["episodes"], &eval["provenance"]["device"]), (&Value::from(2), &Value::from("cpu")));

    let rollout = bench.read_json(&at("rollout.json"));
    assert_eq!((&rollout["episodes"], &rollout["n_action_steps"]), (&Value::from(2), &Value::from(5)));
    let (low, high) = (rollout["success_low"].as_f64().unwrap(), rollout["success_high"].as_f64().unwrap());
    assert!(0.0 <= low && low < high && high <= 1.0);

    let log = McapSummary::read(bench.path(&at("rollout.mcap"))).unwrap();
    assert!(log.topics.iter().any(|topic| topic.topic == "/observation/points"));
    let log = McapSummary::read(bench.path(&at("training.mcap"))).unwrap();
    let topics: Vec<_> = log.topics.iter().map(|topic| (topic.topic.as_str(), topic.messages)).collect();
    assert_eq!(topics, [("/training/updates", 30), ("/training/validations", 2)]);
    for name in ["training", "d_geo_steps", "per_action", "episodes"] {
        let picture = image::load_from_memory(&bench.bytes(&at(&format!("pictures/{name}.png")))).unwrap();
        let pixels = picture.to_rgb8();
        assert!(picture.width() > 100 && picture.height() > 100, "{name}");
        assert!(pixels.pixels().any(|pixel| pixel != pixels.get_pixel(0, 0)), "{name} is blank");
    }
    let summary = bench.read_json(&at("summary.json"));
    assert_eq!(summary["d_geo_mean"], eval["rows"][0]["d_geo_mean"]);
    assert_eq!((&summary["rollouts"], &summary["successes"]), (&Value::from(2), &rollout["successes"]));
    let resolved = String::from_utf8(bench.bytes(&at("config.toml"))).unwrap();
    assert!(resolved.contains("token_scalars = 16"), "{resolved}");
}

#[test]
fn a_stage_that_fails_leaves_the_results_before_it_and_runs_again_once_the_fault_is_gone() {
    let bench = Bench::new();
    fs::write(bench.path("tiny.toml"), TINY).unwrap();
    done(&bench, "--set train.updates=2");
    let weights = bench.bytes("runs/tiny/checkpoint/model.safetensors");
    fs::remove_file(bench.path("runs/tiny/eval.json")).unwrap();
    fs::create_dir(bench.path("runs/tiny/eval.json")).unwrap();

    let output = bench.run("run tiny.toml --set train.updates=2 --set eval.seeds=3");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{errors}");
    assert!(errors.lines().last().unwrap().contains("eval.json: is not a regular file"), "{errors}");
    assert!(bench.bytes("runs/tiny/checkpoint/model.safetensors") == weights, "the checkpoint was touched");

    fs::remove_dir(bench.path("runs/tiny/eval.json")).unwrap();
    assert_eq!(done(&bench, "--set train.updates=2 --set eval.seeds=3"), ["eval"]);
}

#[test]
fn a_damaged_result_is_made_again() {
    let bench = Bench::new();
    fs::write(bench.path("tiny.toml"), TINY).unwrap();
    done(&bench, "--set train.updates=2");
    let weights = bench.bytes("runs/tiny/checkpoint/model.safetensors");
    fs::write(bench.path("runs/tiny/checkpoint/model.safetensors"), &weights[..weights.len() / 2]).unwrap();
    assert_eq!(done(&bench, "--set train.updates=2"), ["train"]);
    assert!(bench.bytes("runs/tiny/checkpoint/model.safetensors") == weights, "the weights are others");
}
