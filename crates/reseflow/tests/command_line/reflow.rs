//! `reseflow reflow`, and a run with a `[reflow]` table: pairs with their provenance, Flow 2, and both flows' figures.

use std::fs;

use reseflow_data::PairSet;
use serde_json::Value;

use crate::support::{Bench, TINY};

/// The tiny configuration with a round of reflow of a few seconds.
const REFLOW: &str = r#"
[reflow]
updates = 12
learning_rate = 2e-3
warmup = 2
pairs = { windows = 2, noises = 3, solver = { kind = "euler", steps = 3 } }
"#;

fn config() -> String {
    format!("{TINY}\n{REFLOW}")
}

#[test]
fn reflow_makes_pairs_that_say_where_they_come_from_and_uses_them_again() {
    let bench = Bench::with_policy();
    fs::write(bench.path("reflow.toml"), config()).unwrap();
    let call = "reflow --config reflow.toml --checkpoint policy --data train.npz";
    let report = bench.json(&format!("{call} --out flow-2 --validation held_out.npz --json"));
    assert_eq!((&report["pairs_found"], &report["windows"]), (&Value::from(false), &Value::from(8)));
    assert_eq!((&report["noises"], &report["pairs"]), (&Value::from(3), &Value::from("flow-2.pairs.npz")));
    assert!(report["validation"]["d_geo"].as_f64().is_some_and(|d_geo| d_geo > 0.0));
    let pairs = PairSet::read(bench.path("flow-2.pairs.npz")).unwrap();
    assert_eq!(pairs.meta.settings["solver"]["kind"], "euler");
    assert_eq!(pairs.meta.checkpoint_hash.len(), 64);
    let contents = bench.json("inspect flow-2.pairs.npz --json");
    let counted = ["windows", "noises", "horizon", "episodes"].map(|key| contents[key].as_u64().unwrap());
    assert_eq!((contents["kind"].as_str(), counted), (Some("pairs"), [8, 3, 10, 4]));
    assert_eq!(contents["checkpoint_hash"], pairs.meta.checkpoint_hash.as_str());
    assert!(bench.succeed("inspect flow-2.pairs.npz").contains("8 / 3 / 10"));
    let weights = bench.bytes("flow-2/model.safetensors");
    assert!(weights != bench.bytes("policy/model.safetensors"), "Flow 2 is Flow 1");

    // Once more: the same bytes from the same pairs; with other settings or another checkpoint, other pairs.
    let again = bench.json(&format!("{call} --out again --pairs flow-2.pairs.npz --json"));
    assert_eq!(again["pairs_found"], true);
    assert!(bench.bytes("again/model.safetensors") == weights, "the same call, other weights");
    let mut made = Vec::new();
    for other in [
        format!("{call} --set reflow.pairs.seed=2"),
        call.replace("--checkpoint policy", "--checkpoint flow-2"),
        format!("{call} --set reflow.mixture.pair_share=1 --set reflow.pairs.noises=1"),
    ] {
        fs::write(bench.path("pairs.npz"), bench.bytes("flow-2.pairs.npz")).unwrap();
        let report = bench.json(&format!("{other} --out other --pairs pairs.npz --json"));
        assert_eq!(report["pairs_found"], false, "{other}");
        made.push(bench.bytes("pairs.npz"));
    }
    assert!(made.iter().all(|bytes| *bytes != bench.bytes("flow-2.pairs.npz")));
    let independent = format!("{call} --set reflow.mixture.coupling=independent --pairs flow-2.pairs.npz");
    assert_eq!(bench.json(&format!("{independent} --out other --json"))["pairs_found"], true);
    assert!(bench.bytes("other/model.safetensors") != weights, "the coupling makes no difference");
    assert!(bench.litter().is_empty(), "temporary files were left: {:?}", bench.litter());
}

#[test]
fn a_reflow_that_cannot_be_done_is_refused_and_leaves_what_is_there() {
    let bench = Bench::with_policy();
    fs::write(bench.path("reflow.toml"), config()).unwrap();
    fs::write(bench.path("kept.npz"), "older file").unwrap();
    let (old, data) = (bench.bytes("policy/model.safetensors"), bench.bytes("held_out.npz"));
    let call = "reflow --config reflow.toml --checkpoint policy --data train.npz --out flow-2";
    let table: [(String, &[&str]); 11] = [
        (call.replace("--out flow-2", "--out policy"), &["policy", "the flow to start from"]),
        (call.replace("--checkpoint policy", "--checkpoint nowhere"), &["nowhere", "no such folder"]),
        (call.replace("train.npz", "absent.npz"), &["absent.npz", "No such file"]),
        (call.replace("reflow.toml", "absent.toml"), &["absent.toml"]),
        (format!("{call} --pairs kept.npz"), &["kept.npz", "not an .npz file"]),
        (format!("{call} --pairs held_out.npz"), &["held_out.npz", "no array `window`"]),
        (format!("{call} --set reflow.mixture.pair_share=1.5"), &["reflow.mixture.pair_share", "1.5"]),
        (format!("{call} --set reflow.mixture.coupling=near"), &["coupling", "near", "anchored"]),
        (format!("{call} --set reflow.pairs.noises=0"), &["reflow.pairs.noises", "at least 1"]),
        (format!("{call} --set reflow.rounds=0"), &["reflow.rounds", "at least 1"]),
        (format!("{call} --set reflow.update=5"), &["reflow.update", "did you mean `reflow.updates`?"]),
    ];
    for (call, parts) in table {
        bench.refuses(&call, parts);
        assert!(!bench.path("flow-2").exists(), "`{call}` left a checkpoint");
    }
    assert_eq!(fs::read_to_string(bench.path("kept.npz")).unwrap(), "older file");
    assert!(bench.bytes("policy/model.safetensors") == old && bench.bytes("held_out.npz") == data);
    assert!(bench.litter().is_empty(), "temporary files were left: {:?}", bench.litter());
}

#[test]
fn a_run_with_reflow_trains_both_flows_scores_both_and_acts_with_the_last() {
    let bench = Bench::new();
    let coin_toss = config().replace("task = \"triangle\"", "task = \"coin_toss\"");
    fs::write(bench.path("tiny.toml"), coin_toss).unwrap();
    let done = |options: &str| -> (Value, Vec<String>) {
        let summary = bench.json(&format!("run tiny.toml --json {options}"));
        let stages = summary["stages"].as_array().unwrap().iter();
        let fresh = stages.filter(|stage| stage["skipped"] == false);
        let names = fresh.map(|stage| stage["name"].as_str().unwrap().to_owned()).collect();
        (summary, names)
    };
    let (summary, names) = done("");
    let expected = [
        "data-train",
        "data-test",
        "data-validation",
        "train",
        "pairs-2",
        "train-2",
        "training-log",
        "eval",
        "eval-2",
        "rollout",
        "latency",
    ];
    assert_eq!(names, expected);
    for (flow, name) in [(0, "eval.json"), (1, "eval-2.json")] {
        let eval = bench.read_json(&format!("runs/tiny/{name}"));
        let straightness = &eval["straightness"];
        assert!(straightness["absolute"].as_f64().is_some_and(|value| value >= 0.0), "{straightness}");
        assert_eq!(summary["flows"][flow]["straightness"], *straightness);
        let modes = &eval["rows"][0]["modes"];
        assert_eq!(summary["flows"][flow]["modes"], *modes);
        let shares = &modes["share_per_mode"];
        let sum = shares[0].as_f64().unwrap() + shares[1].as_f64().unwrap();
        assert!((sum - 1.0).abs() < 1e-12, "{modes}");
        assert!(modes["d_geo_apart"].as_f64().unwrap() > 1.0, "the experts turn to opposite sides: {modes}");
        assert!(modes["d_geo_nearer"].as_f64() <= eval["rows"][0]["d_geo_mean"].as_f64(), "{modes}");
    }
    let rollout = bench.read_json("runs/tiny/rollout.json");
    assert!(rollout["policy"].as_str().is_some_and(|name| name.ends_with("checkpoint-2")), "{rollout}");
    assert_eq!(summary["d_geo_mean"], bench.read_json("runs/tiny/eval-2.json")["rows"][0]["d_geo_mean"]);

    assert_eq!(done("").1, Vec::<String>::new());
    assert_eq!(
        done("--set reflow.updates=13").1,
        ["train-2", "training-log", "eval-2", "rollout", "latency"]
    );
    let two = "--set reflow.updates=13 --set reflow.rounds=2";
    assert_eq!(
        done(two).1,
        ["pairs-3", "train-3", "training-log", "eval-3", "rollout", "latency"],
        "another round goes on from the last"
    );
}
