//! Demonstrations and scripted rollouts: nothing here needs a network.

use std::fs;

use serde_json::Value;

use crate::support::Bench;

#[test]
fn demonstrations_are_recorded_replayed_inspected_and_repeatable() {
    let bench = Bench::new();
    let call =
        "gen --task triangle --episodes 6 --seed 5 --split validation --verify-replay --out a.npz --json";
    let report = bench.json(&format!("{call} --preview a.png"));
    assert_eq!(report["episodes"], 6);
    assert_eq!(report["replay"]["episodes"], 6);
    assert_eq!(report["replay"]["successes"], 6, "stored actions replay: {report}");
    let png = fs::read(bench.path("a.png")).unwrap();
    assert!(png.starts_with(b"\x89PNG") && png.len() > 10_000);
    assert_eq!(report["preview"], "a.png, a.gif");
    let gif = fs::read(bench.path("a.gif")).unwrap();
    assert!(gif.starts_with(b"GIF89a") && gif.len() > 10_000);

    bench.json("gen --task triangle --episodes 6 --seed 5 --split validation --out b.npz --json");
    assert_eq!(
        fs::read(bench.path("a.npz")).unwrap(),
        fs::read(bench.path("b.npz")).unwrap(),
        "one seed, the same bytes"
    );

    let summary = bench.json("inspect a.npz --json");
    assert_eq!(summary["kind"], "data_set");
    assert_eq!((&summary["episodes"], &summary["hash_check"]), (&Value::from(6), &Value::from("matches")));
    assert_eq!(summary["meta"]["split"], "validation");
    assert_eq!(summary["meta"]["seeds"][5]["index"], 5);
    let table = bench.succeed("inspect a.npz");
    assert!(table.contains("triangle (validation)") && table.contains("as recorded"), "{table}");
}

#[test]
fn the_expert_succeeds_standing_still_does_not_and_both_are_logged() {
    let bench = Bench::new();
    let options = "--task triangle --episodes 6 --seed 2 --steps 1";
    let expert = bench.json(&format!(
        "rollout --policy expert {options} --mcap l.mcap --mcap-episodes 2 --preview e.png --out e.json --json"
    ));
    assert_eq!((&expert["episodes"], &expert["successes"]), (&Value::from(6), &Value::from(6)));
    let (low, high) = (expert["success_low"].as_f64().unwrap(), expert["success_high"].as_f64().unwrap());
    assert!((low - 0.6097).abs() < 1e-3 && high == 1.0, "Wilson's interval of 6 of 6: {low} to {high}");
    let file: Value = serde_json::from_slice(&fs::read(bench.path("e.json")).unwrap()).unwrap();
    assert_eq!(file["outcomes"], expert["outcomes"], "what is printed is what is written");

    let film = fs::read(bench.path("e.gif")).unwrap();
    assert!(film.starts_with(b"GIF89a") && fs::read(bench.path("e.png")).unwrap().starts_with(b"\x89PNG"));

    let turned = bench.json(&format!("rollout --policy expert {options} --split turned --out t.json --json"));
    assert_eq!((&turned["successes"], &turned["split"]), (&Value::from(6), &Value::from("turned")));

    let still = bench.json(&format!("rollout --policy still {options} --out s.json --json"));
    assert_eq!(still["successes"], 0);

    let log = bench.json("inspect l.mcap --json");
    let topic = |name: &str| {
        log["topics"]
            .as_array()
            .unwrap()
            .iter()
            .find(|topic| topic["topic"] == name)
            .cloned()
            .unwrap_or_default()
    };
    let points = topic("/observation/points");
    assert_eq!(points["schema"], "foxglove.PointCloud");
    assert_eq!(points["spacing_nanos"][1], 50_000_000);
    assert_eq!(points["strictly_increasing"], true);
    assert_eq!(topic("/outcome")["messages"], 2);
}
