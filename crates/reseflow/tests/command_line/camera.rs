//! The camera's settings: on the command line, in a configuration, in a data set's `meta`, and refused where they cannot be.

use std::fs;

use reseflow_data::{Dataset, DatasetMeta};
use serde_json::{Value, json};

use crate::support::{Bench, TINY};

fn read(bench: &Bench, name: &str) -> (Dataset, DatasetMeta) {
    let data = Dataset::read(bench.path(name)).unwrap();
    let meta = data.meta.clone().unwrap();
    (data, meta)
}

#[test]
fn demonstrations_are_seen_by_the_camera_that_was_asked_for() {
    let bench = Bench::new();
    let call = "gen --task triangle --episodes 2 --seed 90";
    bench.succeed(&format!("{call} --out plain.npz"));
    let (plain, meta) = read(&bench, "plain.npz");
    assert_eq!((plain.points(), meta.extra.get("camera")), (100, None));
    bench.succeed(&format!("{call} --camera points=100 --camera depth_noise_m=1e-3 --out same.npz"));
    assert_eq!(read(&bench, "same.npz").0.episodes, plain.episodes, "the usual camera, said aloud");

    let settings = [
        "points=1",
        "points=64",
        "selection=farthest",
        "depth_noise_m=0.004",
        "drop_fraction=0.5",
        "crop_below_m=-0.5",
        "mask_gripper=false",
        "second_view_rad=3.14",
    ];
    for setting in settings {
        let (key, value) = setting.split_once('=').unwrap();
        bench.succeed(&format!("{call} --camera {setting} --out seen.npz"));
        let (seen, meta) = read(&bench, "seen.npz");
        let expected = serde_json::from_str(value).unwrap_or_else(|_| Value::from(value));
        assert_eq!(meta.extra["camera"][key], expected, "{setting}");
        let points = if key == "points" { value.parse().unwrap() } else { 100 };
        assert_eq!((seen.points(), &meta.config["points"]), (points, &Value::from(points)), "{setting}");
        for (seen, plain) in seen.episodes.iter().zip(&plain.episodes) {
            assert_ne!(seen.observations[0].cloud, plain.observations[0].cloud, "{setting}");
            assert_eq!(seen.actions, plain.actions, "{setting}: the expert does not look");
        }
    }
}

#[test]
fn a_camera_that_cannot_be_is_one_sentence_and_exit_code_two() {
    let bench = Bench::new();
    fs::write(bench.path("camera.toml"), "[data.camera]\ndrop_fraction = 1.5").unwrap();
    fs::write(bench.path("key.toml"), "[data.camera]\npoint = 64").unwrap();
    let call = "gen --task triangle --episodes 1 --seed 90 --out a.npz --camera";
    let act = "rollout --policy expert --task triangle --episodes 1 --seed 90 --out a.json --camera";
    for (call, parts) in [
        (
            format!("{call} point=64"),
            &["--camera point: unknown key `point`", "did you mean `points`?"] as &[_],
        ),
        (format!("{call} points=0"), &["--camera: `points` is 0, expected 1 to 10000"]),
        (
            format!("{call} points=-1"),
            &["--camera points: `points` is integer `-1`, expected a whole number"],
        ),
        (format!("{call} depth_noise_m=nan"), &["--camera: `depth_noise_m` is NaN, expected 0 to 1"]),
        (
            format!("{call} selection=nearest"),
            &["`selection` is `nearest`, expected one of salient, farthest"],
        ),
        (format!("{call} points"), &["--camera", "expected KEY=VALUE, for example points=64"]),
        (format!("{act} drop_fraction=1.5"), &["--camera: `drop_fraction` is 1.5, expected 0 to 1"]),
        (
            "run camera.toml".to_owned(),
            &["camera.toml: `data.camera`: `drop_fraction` is 1.5, expected 0 to 1"],
        ),
        ("run key.toml".to_owned(), &["key.toml:2", "`data.camera.point`", "`data.camera.points`"]),
    ] {
        bench.refuses(&call, parts);
    }
    assert!(!bench.path("a.npz").exists() && !bench.path("a.json").exists());
}

#[test]
fn a_run_records_and_acts_under_the_camera_of_its_configuration_and_is_done_again_under_another() {
    let bench = Bench::new();
    fs::write(bench.path("tiny.toml"), TINY).unwrap();
    let call = "run tiny.toml --json --set train.updates=2 --set data.camera.points";
    let done = |points: usize| {
        let summary = bench.json(&format!("{call}={points}"));
        let stages = summary["stages"].as_array().unwrap();
        stages.iter().filter(|stage| stage["skipped"] == false).count()
    };
    assert_eq!((done(64), done(64), done(40)), (8, 0, 8));
    for split in ["train", "validation", "test"] {
        let (data, meta) = read(&bench, &format!("runs/tiny/data/{split}.npz"));
        assert_eq!((data.points(), &meta.extra["camera"]["points"]), (40, &json!(40)), "{split}");
    }
    assert_eq!(bench.read_json("runs/tiny/rollout.json")["camera"]["points"], 40);
    let resolved = String::from_utf8(bench.bytes("runs/tiny/config.toml")).unwrap();
    assert!(resolved.contains("[data.camera]\npoints = 40"), "{resolved}");

    let act = "rollout --policy runs/tiny/checkpoint --task triangle --episodes 1 --seed 90 --json";
    let report = bench.json(&format!("{act} --camera points=64 --out a.json"));
    assert_eq!(report["camera"]["points"], 64);
}
