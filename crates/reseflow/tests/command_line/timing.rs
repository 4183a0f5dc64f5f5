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
    let report = bench.json(&format!("{call} --steps 1,4 --out times.json --json"));
    assert_eq!(timed(&report), [("policy".to_owned(), 1), ("policy".to_owned(), 4)]);
    assert!(report["rows"][0]["encoder_ms"].is_object(), "a flow has its parts timed");
    assert_eq!(bench.read_json("times.json"), report);
    assert!(bench.succeed(&format!("{call} --steps 2")).contains("p99"));

    bench.refuses(&format!("{call} --steps 1 --out held_out.npz"), &["held_out.npz", "would replace"]);
    bench.refuses(&format!("{call} --solver rk45 --steps 2"), &["--steps", "rk45"]);
    bench.refuses("bench --checkpoint nothing --data held_out.npz", &["nothing", "no such folder"]);
    bench.refuses("bench --checkpoint policy --data none.npz", &["none.npz"]);
    bench.refuses("bench policy", &["policy", "expected the folder of a run"]);
}

#[test]
fn a_run_is_timed_at_its_end_or_afterwards() {
    let bench = Bench::new();
    fs::write(bench.path("tiny.toml"), TINY).unwrap();
    let here = |name: &str| bench.path(name).exists();
    let run = "run tiny.toml --set train.updates=2 --set eval.timed=false";
    bench.succeed(run);
    assert!(!here("runs/tiny/latency.json"), "nobody asked for it");
    let all = bench.json("bench runs/tiny --json");
    assert_eq!(timed(&all[0]), [("flow1".to_owned(), 1), ("flow1".to_owned(), 3)]);
    assert_eq!(bench.read_json("runs/tiny/latency.json"), all[0]);

    bench.succeed(run);
    assert!(here("runs/tiny/latency.json"), "nothing has changed");
    let shown = || {
        bench.succeed("report runs/tiny --out report");
        bench.read_json("report/results.json")["runs"][0]["policies"][0]["steps"][1]["call_ms"].clone()
    };
    assert!(shown()["p50"].as_f64().unwrap() > 0.0);
    bench.succeed(&format!("{run} --set train.seed=2"));
    assert!(!here("runs/tiny/latency.json"), "these times were another policy's");
    assert!(shown().is_null());
    bench.succeed("run tiny.toml --set train.updates=2 --set train.seed=2");
    assert_eq!(timed(&bench.read_json("runs/tiny/latency.json")).len(), 2);
    assert!(shown()["p50"].as_f64().unwrap() > 0.0);
}
