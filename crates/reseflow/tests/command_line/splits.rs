//! A run that scores on every split, compares solvers and acts in every way.

use std::fs;

use reseflow_data::Dataset;
use serde_json::Value;

use crate::support::{Bench, TINY};

/// The tiny configuration with everything that a run can measure, after a training of two updates.
fn config() -> String {
    let every = TINY
        .replace("updates = 30", "updates = 2")
        .replace("seeds = 2", "seeds = 2\nsplits = [\"test\", \"wide\", \"turned\"]\nbaseline_episodes = 1")
        .replace(
            "episodes = 2\nsteps = 1",
            "episodes = 2\nsteps = 1\nvariants = [\"replan\", \"open_loop\", \"disturbed\"]\nbeside = true\nbaseline_steps = 3",
        );
    let more = "[reflow]\nupdates = 2\npairs = { windows = 1, noises = 1, solver = { kind = \"euler\", steps = 1 } }\n
[baseline]\nupdates = 2\ndiffusion = { steps = 10 }\n
[samplers]\nkinds = [\"euler\", \"rk4\", \"rk45\"]\nevaluations = [1, 41]\ntolerances = [0.1]\nepisodes = 1\nseeds = 1\n";
    format!("{every}\n{more}")
}

#[test]
fn every_split_is_scored_and_every_way_to_act_is_tried() {
    let bench = Bench::new();
    fs::write(bench.path("tiny.toml"), config()).unwrap();
    let done = |options: &str| -> (Value, Vec<String>) {
        let summary = bench.json(&format!("run tiny.toml --json {options}"));
        let stages = summary["stages"].as_array().unwrap().iter();
        let fresh = stages.filter(|stage| stage["skipped"] == false);
        let names = fresh.map(|stage| stage["name"].as_str().unwrap().to_owned()).collect();
        (summary, names)
    };
    let (summary, names) = done("");
    let scored = ["eval", "eval-wide", "eval-turned"];
    for name in scored.iter().flat_map(|name| ["", "-2", "-baseline"].map(|who| format!("{name}{who}"))) {
        assert!(names.contains(&name), "no `{name}` among {names:?}");
        let eval = bench.read_json(&format!("runs/tiny/{name}.json"));
        let episodes = if name.ends_with("baseline") { 1 } else { 2 };
        assert_eq!(eval["episodes"], episodes, "{name}");
        assert_eq!(eval["turned"].is_object(), name.contains("turned"), "{name}");
    }
    check_rows(&bench.read_json("runs/tiny/eval-2.json"));
    check_turned(&bench);
    check_samplers(&bench.read_json("runs/tiny/samplers.json"));

    let acted = ["rollout", "rollout-open_loop", "rollout-disturbed", "rollout-flow1", "rollout-baseline"];
    let series: Vec<&str> =
        names.iter().map(String::as_str).filter(|name| name.starts_with("roll")).collect();
    assert_eq!(series, acted);
    for (place, (name, n_action_steps)) in acted.iter().zip([5, 10, 5, 5, 5]).enumerate() {
        let rollout = bench.read_json(&format!("runs/tiny/{name}.json"));
        assert_eq!(rollout["n_action_steps"], n_action_steps, "{name}");
        assert_eq!(rollout["disturbed"], *name == "rollout-disturbed", "{name}");
        let kept = &summary["series"][place];
        assert_eq!((&kept["name"], &kept["successes"]), (&Value::from(*name), &rollout["successes"]));
    }
    let baseline = bench.read_json("runs/tiny/rollout-baseline.json");
    assert_eq!((&baseline["steps"], &baseline["config"]["kind"]), (&Value::from(3), &Value::from("et_seed")));

    assert!(done("").1.is_empty());
    assert_eq!(done("--set rollout.baseline_steps=2").1, ["rollout-baseline"]);
    let elsewhere = done("--set rollout.baseline_steps=2 --set eval.steps_elsewhere=[3]").1;
    let others =
        ["", "-baseline", "-2"].map(|who| ["wide", "turned"].map(|split| format!("eval-{split}{who}")));
    assert_eq!(elsewhere, others.concat());
    let wide = bench.read_json("runs/tiny/eval-wide.json");
    assert_eq!(wide["rows"].as_array().unwrap().iter().map(|row| &row["steps"]).collect::<Vec<_>>(), [3]);
    let turned = &bench.read_json("runs/tiny/eval-turned-2.json")["turned"];
    assert!(turned["d_geo_difference_max"][0].as_f64().unwrap() < 1e-4, "with three steps each: {turned}");
    let run = "run tiny.toml --set eval.steps_elsewhere";
    bench.refuses(&format!("{run}=[2]"), &["`eval.steps_elsewhere` is [2]", "[1, 3]"]);
    bench.refuses(&format!("{run}=[]"), &["`eval.steps_elsewhere` is []"]);

    let fewer = "--set rollout.baseline_steps=2 --set eval.steps_elsewhere=[3] --set rollout.variants=[\"replan\"] --set eval.splits=[\"test\"]";
    assert!(done(fewer).1.is_empty(), "to ask for less is no reason to do anything again");
}

/// What a row says beside its scores.
fn check_rows(eval: &Value) {
    for row in eval["rows"].as_array().unwrap() {
        let calibration = &row["calibration"];
        assert!(calibration["spearman"].as_f64().is_some_and(|rank| rank.abs() <= 1.0), "{calibration}");
        let bins = calibration["bins"].as_array().unwrap();
        let actions: u64 = bins.iter().map(|bin| bin["actions"].as_u64().unwrap()).sum();
        assert_eq!(actions, 2 * 2 * 10, "episodes, seeds, actions");
        assert!(row["latency"].is_null(), "a run times its policies when it has scored them");
    }
    let paired = &eval["against_most_steps"][0];
    assert_eq!(
        (&paired["steps"], &paired["against"], &paired["episodes"]),
        (&1.into(), &3.into(), &2.into())
    );
    let mean = |row: usize| eval["rows"][row]["d_geo_mean"].as_f64().unwrap();
    let difference = paired["difference"].as_f64().unwrap();
    assert!((difference - (mean(0) - mean(1))).abs() < 1e-9, "{paired}");
}

/// The turned episodes are the test episodes moved, and so are the answers.
fn check_turned(bench: &Bench) {
    let [test, turned] = ["test", "turned"]
        .map(|split| Dataset::read(bench.path(&format!("runs/tiny/data/{split}.npz"))).unwrap());
    for (here, there) in test.episodes.iter().zip(&turned.episodes) {
        let motion = there.actions[0].world_from_gripper * here.actions[0].world_from_gripper.inverse();
        assert!(motion.rotation.angle() > 1e-3, "a motion worth the name");
        let between = |episode: &reseflow_data::Episode| {
            episode.observations[0].world_from_gripper.inverse() * episode.actions[9].world_from_gripper
        };
        let apart = reseflow_lie::geodesic_distance(&between(here), &between(there)).d_geo();
        assert!(apart < 1e-5, "what is seen from the gripper has changed by {apart}");
    }
    for name in ["eval-turned", "eval-turned-2", "eval-turned-baseline"] {
        let turned = &bench.read_json(&format!("runs/tiny/{name}.json"))["turned"];
        let error = &turned["equivariance"];
        assert!(error["p50"].as_f64().unwrap() < 1e-4, "{name}: {error}");
        assert!(
            error["p50"].as_f64() <= error["p99"].as_f64() && error["p999"].as_f64() <= error["max"].as_f64()
        );
        assert_eq!(turned["d_geo_difference_max"].as_array().map(Vec::len), Some(2), "one for each row");
    }
}

/// Solvers start from the same noise, spend no more than they may, and come closer to the exact solution the more they spend.
fn check_samplers(report: &Value) {
    let flows = report["flows"].as_array().unwrap();
    assert_eq!(flows.iter().map(|flow| flow["flow"].as_u64().unwrap()).collect::<Vec<_>>(), [1, 2]);
    for flow in flows {
        let rows = flow["rows"].as_array().unwrap();
        let spent =
            |row: &Value| (row["solver"].as_str().unwrap().to_owned(), row["evaluations"].as_u64().unwrap());
        let expected = [("euler", 1), ("euler", 41), ("rk4", 1), ("rk4", 41)];
        assert_eq!(
            rows[..4].iter().map(spent).collect::<Vec<_>>(),
            expected.map(|(name, n)| (name.to_owned(), n))
        );
        assert_eq!((&rows[4]["solver"], &rows[4]["rtol"]), (&"dormand_prince".into(), &0.1.into()));
        assert_eq!(rows[0]["d_geo_mean"], rows[2]["d_geo_mean"], "one step of any solver is the same answer");
        let off = |row: usize| rows[row]["d_geo_to_reference"].as_f64().unwrap();
        assert!(off(1) < off(0) && off(3) < off(2), "{rows:?}");
    }
}
