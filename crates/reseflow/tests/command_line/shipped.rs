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

/// Not more bytes of weights than this ship.
const LARGEST: u64 = 4 << 20;

#[test]
fn what_ships_scores_about_what_its_card_says_and_acts() {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/pretrained");
    let bench = Bench::new();
    for task in ["door", "painting", "triangle"] {
        let card: Value =
            serde_json::from_slice(&fs::read(shipped.join(task).join("card.json")).unwrap()).unwrap();
        bench.succeed(&format!(
            "gen --task {task} --episodes 6 --seed 90 --split validation --out {task}.npz"
        ));
        for policy in ["flow1", "flow2", "etseed"] {
            let weights = shipped.join(task).join(policy).join("model.safetensors");
            assert!(fs::metadata(&weights).unwrap().len() <= LARGEST, "{}", weights.display());
            let scores = card["policies"][policy]["scores"].as_array().unwrap();
            let (row, steps) = (scores.last().unwrap(), scores.last().unwrap()["steps"].as_u64().unwrap());
            let eval = bench.json(&format!(
                "eval --checkpoint {task}/{policy} --data {task}.npz --steps {steps} --seeds 2 --out e.json --json"
            ));
            let [here, there] = [&eval["rows"][0], row].map(|row| row["d_geo_mean"].as_f64().unwrap());
            // Six other scenes, one of which the baseline may take by the other half-turn.
            let half_turned = if policy == "etseed" { std::f64::consts::PI / 6.0 } else { 0.0 };
            assert!(here < 2.0 * there + half_turned, "{task}/{policy}: {here}, its card says {there}");
        }
        let acts = bench.json(&format!(
            "rollout --policy {task}/flow2 --task {task} --episodes 3 --seed 90 --split validation --steps 1 \
             --n-action-steps 10 --out r.json --json"
        ));
        assert!(acts["successes"].as_u64().unwrap() >= 2, "{task}: {}", acts["successes"]);
    }
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
    assert_eq!(names[3..], ["train", "train-2", "eval", "eval-2", "rollout", "latency"], "and no pairs");
    let weights = |name: &str| bench.bytes(&format!("{name}/model.safetensors"));
    assert!(weights("runs/tiny/checkpoint-2") == weights("policy"));
    assert!(done().is_empty());
    // Another policy of the same name is noticed.
    let config = fs::read_to_string(bench.path("trained/flow2/config.toml")).unwrap();
    fs::write(bench.path("trained/flow2/config.toml"), format!("{config}\n# changed\n")).unwrap();
    assert_eq!(done(), ["train-2", "eval-2", "rollout", "latency"]);

    bench.refuses(&format!("{run} --set regressor=true"), &["trained/regressor", "no such folder"]);
    bench.refuses("run tiny.toml --set pretrained=nowhere", &["nowhere", "no such folder"]);
}
