//! Policies that ship: found by name in the current folder, and taken by a run instead of training.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::support::Bench;

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        fs::copy(entry.path(), to.join(entry.file_name())).unwrap();
    }
}

#[test]
fn a_policy_by_name_is_the_policy_by_path() {
    let bench = Bench::with_policy();
    copy(&bench.path("policy"), &bench.path("assets/pretrained/tiny_task/flow1"));
    for call in [
        "eval --data held_out.npz --steps 1 --seeds 2 --out e.json --checkpoint",
        "predict --data held_out.npz --seeds 2 --out p.npz --checkpoint",
        "rollout --task triangle --episodes 1 --seed 90 --out r.json --policy",
    ] {
        let [by_path, by_name] = ["policy", "tiny_task/flow1"].map(|policy| {
            let mut report = bench.json(&format!("{call} {policy} --json"));
            for row in report["rows"].as_array_mut().into_iter().flatten() {
                row["latency"] = Value::Null;
                row["secs"] = Value::Null;
            }
            [report["rows"].clone(), report["outcomes"].clone(), report["episodes"].clone()]
        });
        assert_eq!(by_path, by_name, "{call}");
        bench.refuses(
            &format!("{call} tiny_tusk/flow1"),
            &["tiny_task/flow1", "did you mean", "no such folder"],
        );
    }
    let eval = bench.read_json("e.json");
    assert_eq!(
        eval["checkpoint"], "assets/pretrained/tiny_task/flow1",
        "the result says which folder it was"
    );
}

#[test]
fn a_run_takes_trained_policies_as_they_are() {
    let bench = Bench::with_policy();
    copy(&bench.path("policy"), &bench.path("trained/flow1"));
    copy(&bench.path("policy"), &bench.path("trained/flow2"));
    let run = "run tiny.toml --json --set pretrained=trained --set reflow.rounds=1";
    let done = || -> Vec<String> {
        let summary = bench.json(run);
        let fresh = summary["stages"].as_array().unwrap().iter().filter(|stage| stage["skipped"] == false);
        fresh.map(|stage| stage["name"].as_str().unwrap().to_owned()).collect()
    };
    let names = done();
    assert_eq!(names[3..], ["train", "train-2", "eval", "eval-2", "rollout"], "and no pairs");
    let weights = |name: &str| bench.bytes(&format!("{name}/model.safetensors"));
    assert!(weights("runs/tiny/checkpoint-2") == weights("policy"));
    assert!(done().is_empty());
    // Another policy of the same name is noticed.
    let config = fs::read_to_string(bench.path("trained/flow2/config.toml")).unwrap();
    fs::write(bench.path("trained/flow2/config.toml"), format!("{config}\n# changed\n")).unwrap();
    assert_eq!(done(), ["train-2", "eval-2", "rollout"]);

    bench.refuses(&format!("{run} --set regressor=true"), &["trained/regressor", "no such folder"]);
    bench.refuses("run tiny.toml --set pretrained=nowhere", &["nowhere", "no such folder"]);
}
