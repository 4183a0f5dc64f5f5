//! What `reseflow report` writes for machines and for README.md, and means over training seeds.

use std::fs;

use serde_json::{Value, json};

use crate::report::rows;
use crate::support::{Bench, TINY};

/// Equal to six digits that count.
fn same(short: &Value, value: f64) -> bool {
    (short.as_f64().unwrap() - value).abs() <= 6e-6 * value.abs()
}

/// What `report/` holds for machines and for README.md is what the run in `runs/tiny` left, number by number.
pub(crate) fn check_results(bench: &Bench, summary: &Value) {
    assert_eq!([&summary["results"], &summary["summary"]], ["report/results.json", "report/results.md"]);
    let results = bench.read_json("report/results.json");
    let run = &results["runs"][0];
    let told = ["name", "task", "demonstrations", "training_seed", "two_experts"].map(|key| &run[key]);
    assert_eq!(told, [&json!("tiny"), &json!("triangle"), &json!(3), &json!(1), &json!(false)]);

    let files = [("Flow 1", "eval"), ("Flow 2", "eval-2"), ("ET-SEED", "eval-baseline")];
    let table = String::from_utf8(bench.bytes("report/results.md")).unwrap();
    let shown = rows(&table);
    let timed = bench.read_json("runs/tiny/latency.json");
    for (place, (policy, file)) in files.into_iter().enumerate() {
        let report = bench.read_json(&format!("runs/tiny/{file}.json"));
        let result = &run["policies"][place];
        assert_eq!([&result["policy"], &result["split"]], [policy, "test"]);
        assert_eq!(result["episodes"], report["episodes"]);
        assert_eq!(result["first_noise_seed"], report["seeds"][0]);
        assert_eq!(result["noise_seeds"], 2);
        for (short, row) in result["steps"].as_array().unwrap().iter().zip(report["rows"].as_array().unwrap())
        {
            let of = |key: &str| row[key].as_f64().unwrap();
            assert_eq!(short["steps"], row["steps"]);
            for key in ["d_geo_mean", "d_geo_std", "d_geo_low", "d_geo_high", "rotation_rad"] {
                assert!(same(&short["error"][key], of(key)), "{key}: {short} for {row}");
            }
            assert!(same(&short["error"]["translation_mm"], 1e3 * of("translation_m")));
            let name = ["flow1", "flow2", "etseed"][place];
            let of_row = |time: &&Value| time["policy"] == name && time["steps"] == row["steps"];
            let time = timed["rows"].as_array().unwrap().iter().find(of_row).unwrap();
            for key in ["p50", "p99"] {
                assert!(same(&short["call_ms"][key], time["whole_ms"][key].as_f64().unwrap()));
            }
        }
        let line = shown.iter().find(|row| row[1] == policy).unwrap();
        let of = |place: usize, key: &str| report["rows"][place][key].as_f64().unwrap();
        let [mean, low, high] = ["d_geo_mean", "d_geo_low", "d_geo_high"].map(|key| of(0, key));
        assert_eq!(line[2], format!("{mean:.4} ({low:.4}–{high:.4})"));
        assert_eq!(line[4], format!("{:.4}", of(1, "d_geo_mean")), "in three steps");
    }

    let rollout = bench.read_json("runs/tiny/rollout.json");
    let acting = &run["rollouts"][0];
    for key in ["episodes", "successes", "steps", "split", "disturbed"] {
        assert_eq!(acting[key], rollout[key], "{key}");
    }
    assert!(same(&acting["success_high"], rollout["success_high"].as_f64().unwrap()));
    let line = shown.iter().find(|row| row[1] == "Flow 2").unwrap();
    let expected = format!("{} of {} (", rollout["successes"], rollout["episodes"]);
    assert!(line[6].starts_with(&expected), "replanning is what the tiny run does: {line:?}");
    assert_eq!([line[0], line[7], line[8], line[9]], ["Rotating triangle (3)", "–", "–", "0.876"]);
}

/// A run of one flow, and a copy that is called `name` and says that it was trained with `seed`, its errors `factor` times as large.
fn copy(bench: &Bench, name: &str, seed: u64, factor: f64) {
    let target = bench.path(&format!("runs/{name}"));
    fs::create_dir_all(&target).unwrap();
    let config = String::from_utf8(bench.bytes("runs/tiny/config.toml")).unwrap();
    let mut config: toml::Table = config.parse().unwrap();
    config["name"] = name.into();
    config["train"]["seed"] = i64::try_from(seed).unwrap().into();
    fs::write(target.join("config.toml"), config.to_string()).unwrap();
    let mut report = bench.read_json("runs/tiny/eval.json");
    for row in report["rows"].as_array_mut().unwrap() {
        row["d_geo_mean"] = json!(factor * row["d_geo_mean"].as_f64().unwrap());
    }
    fs::write(target.join("eval.json"), report.to_string()).unwrap();
    fs::copy(bench.path("runs/tiny/rollout.json"), target.join("rollout.json")).unwrap();
}

#[test]
fn runs_of_other_training_seeds_are_one_experiment() {
    let bench = Bench::new();
    fs::write(bench.path("tiny.toml"), TINY).unwrap();
    bench.succeed("run tiny.toml --set train.updates=2 --set train.validate_every=1");
    copy(&bench, "tiny-seed2", 2, 1.5);
    copy(&bench, "tiny-seed3", 3, 2.0);
    bench.succeed("report runs/tiny runs/tiny-seed2 runs/tiny-seed3 --out report");
    let markdown = String::from_utf8(bench.bytes("report/report.md")).unwrap();
    let all = rows(&markdown);
    let first = bench.read_json("runs/tiny/eval.json")["rows"][0]["d_geo_mean"].as_f64().unwrap();
    // 1, 1.5 and 2 times the same: their mean is 1.5 times, and they lie half of it apart.
    let text = format!("{:.4} ± {:.4}", 1.5 * first, 0.5 * first);
    let pooled = all.iter().find(|row| row.len() == 8 && row[..3] == ["Flow 1", "test", "1"]);
    let pooled = pooled.unwrap_or_else(|| panic!("no row over training seeds in\n{markdown}"));
    let each = [1.0, 1.5, 2.0].map(|factor| format!("{:.4}", factor * first)).join(", ");
    assert_eq!([pooled[3], pooled[4], pooled[7]], ["3", &text, &each]);
    assert_eq!(all.iter().filter(|row| row.len() == 11 && row[..3] == ["Flow 1", "test", "1"]).count(), 3);

    let beside = all.iter().find(|row| row[0].ends_with("over training seeds")).expect("beside the paper");
    assert_eq!(beside[3], format!("{text} (3 training seeds)"));
    let rollout = bench.read_json("runs/tiny/rollout.json");
    let rate = 100.0 * rollout["success_rate"].as_f64().unwrap();
    let acting = all.iter().find(|row| row[0] == "tiny × 3 training seeds").expect("acting");
    assert_eq!(acting[8], format!("{rate:.1} % ± 0.0 %"));

    // What makes runs several experiments: other settings, other noise, the same seed.
    let refused = |why: &str| {
        let left_out = bench.json("report runs/tiny runs/tiny-seed2 runs/tiny-seed3 --out report --json");
        let left_out = left_out["left_out"].to_string();
        assert!(left_out.contains(why), "{left_out}");
    };
    let config = String::from_utf8(bench.bytes("runs/tiny-seed3/config.toml")).unwrap();
    let mut longer: toml::Table = config.parse().unwrap();
    longer["train"]["updates"] = 9.into();
    fs::write(bench.path("runs/tiny-seed3/config.toml"), longer.to_string()).unwrap();
    refused("their configurations differ in more than the training seed");
    fs::write(bench.path("runs/tiny-seed3/config.toml"), config).unwrap();
    let mut report = bench.read_json("runs/tiny-seed3/eval.json");
    report["seeds"] = json!([1, 2]);
    fs::write(bench.path("runs/tiny-seed3/eval.json"), report.to_string()).unwrap();
    refused("they were scored on different episodes or noise seeds");
    copy(&bench, "tiny-seed3", 2, 2.0);
    refused("trained with the same seed");
    let markdown = String::from_utf8(bench.bytes("report/report.md")).unwrap();
    assert!(rows(&markdown).iter().all(|row| !row[0].contains("training seeds")));
}

#[test]
fn an_ablation_has_a_row_of_its_own_and_stands_for_nothing_else() {
    let bench = Bench::new();
    fs::write(bench.path("tiny.toml"), TINY).unwrap();
    bench.succeed("run tiny.toml --set variant=twist --set train.updates=2 --set train.validate_every=1");
    copy(&bench, "main", 1, 0.5);
    let config = String::from_utf8(bench.bytes("runs/main/config.toml")).unwrap();
    let mut config: toml::Table = config.parse().unwrap();
    assert_eq!(config.remove("variant"), Some("twist".into()));
    fs::write(bench.path("runs/main/config.toml"), config.to_string()).unwrap();
    bench.succeed("report runs/tiny runs/main --out report");

    let own = bench.read_json("runs/tiny/eval.json")["rows"][0]["d_geo_mean"].as_f64().unwrap();
    let [own, main] = [own, 0.5 * own].map(|error| format!("{error:.4}"));
    let markdown = String::from_utf8(bench.bytes("report/report.md")).unwrap();
    let all = rows(&markdown);
    let row = all.iter().find(|row| row[0] == "twist").expect("the ablation's row");
    // The copy has the same errors, episode by episode.
    assert_eq!(row[1..5], ["Rotating triangle", "3", &own, "+0.0000 (+0.0000 to +0.0000)"]);
    let beside = all.iter().find(|row| row[0].starts_with("Flow 1, ours, 1 step")).expect("our row");
    assert!(beside[3].starts_with(&main), "{beside:?} shows the main run, whose error is {main}");
    let summary = String::from_utf8(bench.bytes("report/results.md")).unwrap();
    let table = summary.split("## ").next().unwrap();
    assert_eq!(rows(table).iter().filter(|row| row[1] == "Flow 1").count(), 1);
    let results = bench.read_json("report/results.json");
    assert_eq!(results["runs"][0]["variant"], "twist");
    assert_eq!(results["runs"][1].get("variant"), None);
}

#[test]
fn the_nearest_demonstration_is_told_with_the_demonstrations_that_it_is_of() {
    let bench = Bench::new();
    fs::write(bench.path("tiny.toml"), TINY).unwrap();
    bench.succeed("run tiny.toml --set task=door --set train.updates=2 --set train.validate_every=1");
    let told = || {
        bench.succeed("report runs/tiny --out report");
        let summary = String::from_utf8(bench.bytes("report/results.md")).unwrap();
        let all = rows(&summary);
        let named = all.iter().find(|row| row[1].starts_with("nearest")).unwrap();
        (named[0].to_owned(), named[1].to_owned(), bench.read_json("report/results.json"))
    };
    let (task, predictor, results) = told();
    assert_eq!((task.as_str(), predictor.as_str()), ("Door opening (3)", "nearest demonstration"));
    assert_eq!(results["runs"][0].get("nearest_among"), None);

    bench.succeed(
        "run tiny.toml --set task=door --set train.updates=2 --set train.validate_every=1 --set data.disturbed_share=0.3",
    );
    let of = bench.read_json("runs/tiny/eval.json")["trivial"]["training_episodes"].as_u64().unwrap();
    assert!((1..3).contains(&of), "{of} of three were left alone");
    let (task, predictor, results) = told();
    assert_eq!((task, predictor), ("Door opening (3)".to_owned(), format!("nearest demonstration of {of}")));
    assert_eq!(results["runs"][0]["nearest_among"], of);
}
