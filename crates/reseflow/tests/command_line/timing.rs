//! `reseflow bench`, and what a run and a report make of it.

use std::fs;

use serde_json::Value;

use crate::support::{Bench, TINY};

/// The rows of a timing: policy and steps of each, once its times have been looked at.
fn timed(report: &Value) -> Vec<(String, u64)> {
    let rows = report["rows"].as_array().unwrap();
    for row in rows {
        let whole = &row["whole_ms"];
        let at = |part: &Value, key: &str| part[key].as_f64().unwrap();
        assert!(at(whole, "p50") <= at(whole, "p95") && at(whole, "p95") <= at(whole, "p99"), "{row}");
        assert!(at(whole, "p99") <= at(whole, "max") && whole["calls"].as_u64().unwrap() >= 20, "{row}");
        for part in
            ["encoder_ms", "decoder_ms"].map(|part| &row[part]).into_iter().filter(|part| part.is_object())
        {
            assert!(0.0 < at(part, "p50") && at(part, "p50") < at(whole, "max"), "{row}");
        }
    }
    rows.iter()
        .map(|row| (row["policy"].as_str().unwrap().to_owned(), row["steps"].as_u64().unwrap()))
        .collect()
}

#[test]
fn a_policy_is_timed_with_each_number_of_steps() {
    let bench = Bench::with_policy();
    let call = "bench --checkpoint policy --data held_out.npz";
    let reports = bench.json(&format!("{call} --steps 1,4 --out times.json --json"));
    let report = reports[0].clone();
    assert_eq!((reports.as_array().unwrap().len(), &report["of"]), (1, &"policy".into()));
    assert_eq!(timed(&report), [("policy".to_owned(), 1), ("policy".to_owned(), 4)]);
    assert!(report["rows"][0]["encoder_ms"].is_object(), "a flow has its parts timed");
    assert_eq!(bench.read_json("times.json"), report);
    assert!(bench.succeed(&format!("{call} --steps 2")).contains("p99"));

    bench.refuses(&format!("{call} --steps 1 --out held_out.npz"), &["held_out.npz", "would replace"]);
    bench.refuses(&format!("{call} --solver rk45 --steps 2"), &["--steps", "rk45"]);
    bench.refuses("bench --checkpoint nothing --data held_out.npz", &["nothing", "no such folder"]);
    bench.refuses("bench --checkpoint policy --data none.npz", &["none.npz"]);
    bench.refuses("bench policy", &["policy", "expected the folder of a run"]);
    bench.refuses("bench nothing", &["nothing", "no such folder", "--checkpoint"]);
    bench.refuses("bench", &["nothing to time", "--checkpoint", "--data"]);
}

/// The time of a call with the last number of steps, as a report of the tiny run shows it.
fn shown(bench: &Bench) -> Value {
    bench.succeed("report runs/tiny --out report");
    let run = &bench.read_json("report/results.json")["runs"][0];
    run["policies"][0]["steps"].as_array().unwrap().last().unwrap()["call_ms"].clone()
}

#[test]
fn a_run_is_timed_at_its_end_or_afterwards_and_only_its_own_policies_count() {
    let bench = Bench::new();
    fs::write(bench.path("tiny.toml"), TINY).unwrap();
    let run = "run tiny.toml --set train.updates=2 --set eval.timed=false";
    bench.succeed(run);
    assert!(!bench.path("runs/tiny/latency.json").exists(), "nobody asked for it");
    let all = bench.json("bench runs/tiny --json");
    assert_eq!(all[0]["of"], "runs/tiny");
    assert_eq!(timed(&all[0]), [("flow1".to_owned(), 1), ("flow1".to_owned(), 3)]);
    assert_eq!(bench.read_json("runs/tiny/latency.json"), all[0]);

    bench.succeed(&format!("{run} --set rollout.episodes=1"));
    assert!(shown(&bench)["p50"].as_f64().unwrap() > 0.0, "the policy is the same");
    bench.succeed(&format!("{run} --set train.seed=2"));
    assert!(shown(&bench).is_null(), "these times were another policy's");
    let timed_run = "run tiny.toml --set train.updates=2 --set train.seed=2";
    bench.succeed(timed_run);
    assert_eq!(timed(&bench.read_json("runs/tiny/latency.json")).len(), 2);
    assert!(shown(&bench)["p50"].as_f64().unwrap() > 0.0);

    bench.succeed("bench runs/tiny");
    let quiet = bench.bytes("runs/tiny/latency.json");
    let summary = bench.json(&format!("{timed_run} --json"));
    assert!(summary["stages"].as_array().unwrap().iter().all(|stage| stage["skipped"] == true), "{summary}");
    assert!(bench.bytes("runs/tiny/latency.json") == quiet, "times that were taken afterwards stay");

    bench.refuses("bench runs/tiny runs/tyni", &["runs/tyni", "no such folder"]);
    fs::remove_file(bench.path("runs/tiny/data/test.npz")).unwrap();
    bench.refuses("bench runs/tiny", &["runs/tiny/data/test.npz", "what the run left there"]);
    assert!(bench.bytes("runs/tiny/latency.json") == quiet, "nothing was timed");
}

#[test]
fn a_solver_that_chooses_its_steps_is_timed_too() {
    let bench = Bench::new();
    fs::write(bench.path("tiny.toml"), TINY).unwrap();
    bench.succeed(
        "run tiny.toml --set train.updates=2 --set data.test_episodes=6 --set eval.seeds=10 \
         --set eval.solver={kind=\"rk45\",rtol=0.01,atol=0.01}",
    );
    assert!(shown(&bench)["p50"].as_f64().unwrap() > 0.0);
}
