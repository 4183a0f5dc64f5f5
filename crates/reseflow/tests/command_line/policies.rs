//! A policy from `train` in `predict`, `eval` and `rollout`: the commands agree with one another, and a moved scene is a moved answer.

use std::fs;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use reseflow_data::{ActionChunk, Dataset, McapSummary, Predictions};
use reseflow_lie::{GeodesicDistance, SE3, SO3, Vector3, geodesic_distance};
use serde_json::Value;

use crate::support::Bench;

/// The distances of two trajectories, action by action.
fn distances(one: &ActionChunk, other: &ActionChunk) -> Vec<GeodesicDistance> {
    assert_eq!(one.len(), other.len());
    let pairs = one.iter().zip(other.iter());
    pairs.map(|(a, b)| geodesic_distance(&a.world_from_gripper, &b.world_from_gripper)).collect()
}

/// As [`distances`] for all trajectories of two prediction files: D_geo, ascending.
fn differences(one: &Predictions, other: &Predictions) -> Vec<f64> {
    let pairs = one.chunks.iter().flatten().zip(other.chunks.iter().flatten());
    let mut all: Vec<f64> =
        pairs.flat_map(|(a, b)| distances(a, b)).map(|distance| distance.d_geo()).collect();
    all.sort_by(f64::total_cmp);
    all
}

fn mean(values: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, count) = values.into_iter().fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / count
}

#[test]
fn what_is_predicted_is_what_is_scored() {
    let bench = Bench::with_policy();
    let predict = "predict --checkpoint policy --data held_out.npz --steps 3 --seeds 4";
    let report = bench.json(&format!("{predict} --out p.npz --json"));
    assert_eq!(report["seeds"], serde_json::json!([3407, 3408, 3409, 3410]));
    let contents = bench.json("inspect p.npz --json");
    assert_eq!(
        [&contents["kind"], &contents["episodes"], &contents["seeds"], &contents["horizon"]],
        [&Value::from("predictions"), &Value::from(3), &Value::from(4), &Value::from(10)]
    );
    bench.succeed(&format!("{predict} --out again.npz"));
    assert!(bench.bytes("p.npz") == bench.bytes("again.npz"), "the same call, other bytes");

    let printed = bench.json(
        "eval --checkpoint policy --data held_out.npz --train-data train.npz --steps 1,3 --seeds 4 --out e.json --json",
    );
    assert_eq!(printed, bench.read_json("e.json"), "what is printed is what is written");
    assert_eq!(printed["trivial"]["training_episodes"], 4);

    // D̄_geo and its parts, from the prediction file and the data set.
    let predictions = Predictions::read(bench.path("p.npz")).unwrap();
    let data = Dataset::read(bench.path("held_out.npz")).unwrap();
    let errors: Vec<Vec<GeodesicDistance>> = (predictions.chunks.iter().zip(&data.episodes))
        .flat_map(|(drawn, episode)| {
            drawn.iter().map(|chunk| distances(chunk, &ActionChunk(episode.actions.clone())))
        })
        .collect();
    let row = &printed["rows"][1];
    assert_eq!(row["steps"], 3);
    let all = || errors.iter().flatten();
    for (key, expected) in [
        ("d_geo_mean", mean(all().map(GeodesicDistance::d_geo))),
        ("rotation_rad", mean(all().map(|error| error.rotation_rad))),
        ("translation_m", mean(all().map(|error| error.translation_m))),
    ] {
        let got = row[key].as_f64().unwrap();
        assert!((got - expected).abs() < 1e-5, "`{key}` is {got}, the predictions say {expected}");
    }
    for (step, got) in row["per_action_mean"].as_array().unwrap().iter().enumerate() {
        let expected = mean(errors.iter().map(|chunk| chunk[step].d_geo()));
        assert!((got.as_f64().unwrap() - expected).abs() < 1e-5, "action {step}: {got}, expected {expected}");
    }
    assert_ne!(row["d_geo_mean"], printed["rows"][0]["d_geo_mean"], "the steps make no difference");

    bench.succeed(&format!("{predict} --device ndarray --out n.npz"));
    let other = Predictions::read(bench.path("n.npz")).unwrap();
    let worst = differences(&predictions, &other).pop().unwrap();
    assert!(worst < 1e-4, "the backends differ by {worst}");
}

#[test]
fn a_moved_data_set_gets_the_moved_predictions_and_the_same_score() {
    let bench = Bench::with_policy();
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut data = Dataset::read(bench.path("held_out.npz")).unwrap();
    let mut motions = Vec::new();
    for episode in &mut data.episodes {
        let rotation = SO3::sample_haar(&mut rng);
        let motion = SE3::new(rotation, Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0)));
        for seen in &mut episode.observations {
            for point in &mut seen.cloud.points {
                let moved: [f64; 3] = motion.act(&Vector3::from(point.map(f64::from))).into();
                *point = moved.map(|coordinate| coordinate as f32);
            }
            seen.world_from_gripper = motion * seen.world_from_gripper;
        }
        for action in &mut episode.actions {
            action.world_from_gripper = motion * action.world_from_gripper;
        }
        motions.push(motion);
    }
    data.meta = None;
    data.write(bench.path("moved.npz")).unwrap();

    for steps in [1, 10] {
        let predict = |data: &str, out: &str| {
            bench.succeed(&format!(
                "predict --checkpoint policy --data {data} --steps {steps} --seeds 5 --out {out}"
            ));
            Predictions::read(bench.path(out)).unwrap()
        };
        let (plain, moved) = (predict("held_out.npz", "plain.npz"), predict("moved.npz", "there.npz"));
        let mut expected = plain.clone();
        for (of_episode, motion) in expected.chunks.iter_mut().zip(&motions) {
            for action in of_episode.iter_mut().flat_map(|chunk| &mut chunk.0) {
                action.world_from_gripper = *motion * action.world_from_gripper;
            }
        }
        let errors = differences(&moved, &expected);
        let (typical, worst) = (errors[errors.len() * 99 / 100], errors[errors.len() - 1]);
        println!("{steps} steps: 99th percentile {typical:.2e}, worst {worst:.2e}");
        assert!(typical <= 1e-4, "{steps} steps: {typical}");
        let unmoved = differences(&moved, &plain);
        assert!(unmoved[unmoved.len() / 2] > 0.1, "a prediction that does not move would pass");
    }
    let score = |data: &str| {
        let eval = bench
            .json(&format!("eval --checkpoint policy --data {data} --steps 1 --seeds 2 --out e.json --json"));
        eval["rows"][0]["d_geo_mean"].as_f64().unwrap()
    };
    let (plain, moved) = (score("held_out.npz"), score("moved.npz"));
    assert!((plain - moved).abs() < 1e-4 * plain, "{plain} here, {moved} there");
}

#[test]
fn rollouts_of_a_trained_policy_repeat_themselves_and_their_log_reads_back() {
    let bench = Bench::with_policy();
    let rollout =
        "rollout --policy policy --task triangle --episodes 2 --seed 90 --steps 2 --n-action-steps 4";
    let report = bench.json(&format!("{rollout} --mcap l.mcap --mcap-episodes 1 --out r.json --json"));
    assert_eq!((&report["episodes"], &report["steps"]), (&Value::from(2), &Value::from(2)));
    let steps: Vec<u64> =
        report["outcomes"].as_array().unwrap().iter().map(|line| line["steps"].as_u64().unwrap()).collect();
    let plans = |steps: u64| steps.div_ceil(4);
    assert_eq!(report["plan_latency_ms"]["calls"], steps.iter().map(|&steps| plans(steps)).sum::<u64>());

    let log = McapSummary::read(bench.path("l.mcap")).unwrap();
    let topic = |name: &str| log.topics.iter().find(|topic| topic.topic == name).unwrap();
    for name in ["/observation/points", "/tf", "/scene", "/gripper/opening"] {
        let topic = topic(name);
        assert!(topic.strictly_increasing, "{name} goes back in time");
        assert_eq!(topic.spacing_nanos, Some([50_000_000; 3]), "{name}: a message every 50 ms");
        assert_eq!(topic.messages, topic.last_nanos / 50_000_000 + 1, "{name}: from 0 to the end");
    }
    assert_eq!(topic("/observation/points").schema, "foxglove.PointCloud");
    assert_eq!(topic("/plan/poses").messages, plans(steps[0]));
    assert_eq!(topic("/plan/uncertainty").messages, plans(steps[0]), "the nodes' spread is logged");
    assert_eq!(topic("/outcome").messages, 1);
    assert!(log.topics.iter().all(|topic| topic.last_nanos <= log.end_nanos));

    bench.succeed(&format!("{rollout} --mcap again.mcap --mcap-episodes 1 --out again.json"));
    assert!(bench.bytes("l.mcap") == bench.bytes("again.mcap"), "the same call, another log");
    assert_eq!(report["outcomes"], bench.read_json("again.json")["outcomes"]);
}

#[test]
fn the_number_of_threads_changes_no_byte() {
    let bench = Bench::with_policy();
    let with_threads = |threads: &str, call: &str| {
        let output = bench.command(call).env("RAYON_NUM_THREADS", threads).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    };
    for threads in ["1", "5"] {
        fs::create_dir(bench.path(threads)).unwrap();
        with_threads(
            threads,
            &format!("gen --task triangle --episodes 4 --seed 90 --out {threads}/data.npz"),
        );
        with_threads(threads, &format!("train --config tiny.toml --data train.npz --out {threads}/policy"));
        let predict = "predict --checkpoint policy --data held_out.npz --seeds 2";
        with_threads(threads, &format!("{predict} --out {threads}/p.npz"));
    }
    for name in ["data.npz", "policy/model.safetensors", "policy/config.toml", "p.npz"] {
        assert!(bench.bytes(&format!("1/{name}")) == bench.bytes(&format!("5/{name}")), "{name} differs");
    }
    assert!(bench.bytes("1/policy/model.safetensors") == bench.bytes("policy/model.safetensors"));
}
