//! The references beside a flow, the baseline and the regressor: trained, resumed, scored and acting through the same commands.

use std::fs;
use std::process::Stdio;
use std::time::{Duration, Instant};

use reseflow_data::Predictions;
use serde_json::Value;

use crate::support::{Bench, TINY};

/// The tiny configuration with a baseline of ten noise levels and a regressor.
fn config() -> String {
    let top = TINY.replacen("device = \"cpu\"", "device = \"cpu\"\nregressor = true", 1);
    format!(
        "{top}\n[baseline]\nupdates = 20\nlearning_rate = 5e-3\nwarmup = 4\n\n[baseline.diffusion]\nsteps = 10\n"
    )
}

fn bench() -> Bench {
    let bench = Bench::new();
    fs::write(bench.path("tiny.toml"), config()).unwrap();
    bench.succeed("gen --task triangle --episodes 3 --seed 90 --out train.npz");
    bench.succeed("gen --task triangle --episodes 2 --seed 90 --split validation --out held_out.npz");
    bench
}

#[test]
fn a_baseline_is_trained_resumed_scored_and_rolled_out_by_the_commands_of_a_flow() {
    let bench = bench();
    let train = "train --config tiny.toml --data train.npz --validation held_out.npz --baseline --set train.save_every=5";
    bench.succeed(&format!("{train} --out alone"));
    let config = String::from_utf8(bench.bytes("alone/config.toml")).unwrap();
    for line in ["kind = \"et_seed\"", "task = \"triangle\"", "updates = 20", "steps = 10", "channels = 8"] {
        assert!(config.contains(line), "no `{line}` in:\n{config}");
    }
    let mut child = bench
        .command(&format!("{train} --out policy"))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let started = Instant::now();
    while !bench.path("policy.partial/state").exists() && child.try_wait().unwrap().is_none() {
        assert!(started.elapsed() < Duration::from_secs(300), "no state was saved for five minutes");
        std::thread::yield_now();
    }
    child.kill().unwrap();
    child.wait().unwrap();
    bench.succeed(&format!("{train} --out policy --resume"));
    assert!(bench.bytes("policy/model.safetensors") == bench.bytes("alone/model.safetensors"));
    assert!(!bench.path("policy.partial").exists());

    let predict = "predict --checkpoint policy --data held_out.npz --seeds 2";
    let report = bench.json(&format!("{predict} --steps 5 --out p.npz --json"));
    assert_eq!((&report["steps"], &report["evaluations"]), (&Value::from(5), &Value::from(5)));
    let predictions = Predictions::read(bench.path("p.npz")).unwrap();
    assert_eq!((predictions.chunks.len(), predictions.chunks[0].len()), (2, 2));
    let eval = bench.json("eval --checkpoint policy --data held_out.npz --seeds 2 --out e.json --json");
    let steps: Vec<_> = eval["rows"].as_array().unwrap().iter().map(|row| row["steps"].clone()).collect();
    assert_eq!(steps, [1, 2, 10], "the usual numbers of steps, as far as there are noise levels");
    for row in eval["rows"].as_array().unwrap() {
        assert_eq!((&row["per_node"], &row["node_spread"]), (&Value::Array(Vec::new()), &Value::Null));
        assert!(row["d_geo_mean"].as_f64().unwrap() > 0.0);
    }
    assert_eq!((&eval["straightness"], &eval["config"]["kind"]), (&Value::Null, &Value::from("et_seed")));
    let roll = "rollout --policy policy --task triangle --episodes 1 --seed 90";
    let report = bench.json(&format!("{roll} --steps 10 --out r.json --json"));
    assert_eq!((&report["steps"], &report["config"]["kind"]), (&Value::from(10), &Value::from("et_seed")));

    bench.refuses(&format!("{predict} --steps 11 --out q.npz"), &["10 noise levels", "got 11"]);
    bench.refuses(&format!("{predict} --solver rk4 --out q.npz"), &["baseline", "euler", "rk4"]);
    bench.refuses(
        "reflow --config tiny.toml --checkpoint policy --data train.npz --out flow-2",
        &["policy/config.toml", "`et_seed`", "expected `flow`"],
    );
    bench.refuses(&format!("{train} --out q --set baseline.update=3"), &["did you mean `baseline.updates`?"]);
    bench.refuses(&format!("{train} --out q --set baseline.opening=-1"), &["baseline.opening", "-1"]);
    bench.refuses(&format!("{train} --out q --set eval.steps=[20]"), &["`eval.steps`", "20", "noise levels"]);
}

#[test]
fn a_run_trains_and_scores_the_references_and_redoes_only_what_changed() {
    let bench = Bench::new();
    fs::write(bench.path("tiny.toml"), config()).unwrap();
    let run = |options: &str| -> (Value, Vec<String>) {
        let summary = bench.json(&format!("run tiny.toml --json {options}"));
        let stages = summary["stages"].as_array().unwrap().iter();
        let fresh = stages.filter(|stage| stage["skipped"] == false);
        let names = fresh.map(|stage| stage["name"].as_str().unwrap().to_owned()).collect();
        (summary, names)
    };
    let (summary, names) = run("");
    let trained = ["train", "train-baseline", "train-regressor", "training-log"];
    let scored = ["eval", "eval-baseline", "eval-regressor", "rollout", "latency"];
    assert_eq!(names[3..], [&trained[..], &scored].concat());
    let rows = |name: &str| bench.read_json(&format!("runs/tiny/{name}.json"))["rows"].clone();
    let baseline = rows("eval-baseline");
    assert_eq!(
        summary["baseline"],
        serde_json::json!([[1, baseline[0]["d_geo_mean"]], [3, baseline[1]["d_geo_mean"]]])
    );
    let regressor = rows("eval-regressor");
    assert_eq!(regressor.as_array().unwrap().len(), 1, "a regressor answers at once");
    assert_eq!(summary["regressor"], regressor[0]["d_geo_mean"]);
    assert_eq!(regressor[0]["d_geo_std"], 0.0, "a regressor answers the same to every seed");
    assert_eq!(summary["config"]["baseline"]["updates"], 20, "the summary holds the resolved configuration");
    assert_eq!(bench.read_json("runs/tiny/rollout.json")["config"]["kind"], "flow", "the flow acts");
    for name in ["training-baseline", "d_geo_steps-baseline", "per_action-regressor"] {
        image::load_from_memory(&bench.bytes(&format!("runs/tiny/pictures/{name}.png"))).unwrap();
    }

    assert!(run("").1.is_empty());
    let after_training = ["train-baseline", "training-log", "eval-baseline", "latency"];
    assert_eq!(run("--set baseline.updates=21").1, after_training);
    let without = run("--set regressor=false").0;
    assert!(without.get("regressor").is_none() && without["baseline"].is_array());
}

#[test]
fn a_regressor_is_trained_by_itself_and_what_it_cannot_do_is_refused() {
    let bench = bench();
    let alone = TINY.replace("steps = [1, 3]", "steps = [1]");
    fs::write(bench.path("alone.toml"), alone).unwrap();
    let train = "train --config alone.toml --data train.npz --out regressor --set model.regression=true";
    bench.succeed(train);
    let eval = bench.json("eval --checkpoint regressor --data held_out.npz --seeds 2 --out e.json --json");
    assert_eq!(eval["rows"].as_array().unwrap().len(), 1);
    assert_eq!(
        (&eval["config"]["model"]["regression"], &eval["straightness"]),
        (&Value::Bool(true), &Value::Null)
    );
    bench.refuses(
        "predict --checkpoint regressor --data held_out.npz --steps 2 --out p.npz",
        &["answers at once"],
    );
    bench.refuses(&format!("{train} --set eval.steps=[1,2]"), &["`model.regression`", "`eval.steps`"]);
    bench.refuses(&format!("{train} --set reflow.updates=2"), &["`model.regression`", "`reflow`"]);
    bench.refuses(&format!("{train} --set regressor=true"), &["`model.regression`", "`regressor`"]);
}
