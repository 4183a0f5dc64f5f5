//! A flow whose network predicts velocities, through every command, and the combinations that are refused.

use std::fs;

use reseflow_data::{PairSet, Predictions};
use serde_json::Value;

use crate::support::{Bench, TINY};

/// The tiny configuration in twist form, with a round of reflow.
fn config() -> String {
    let network = TINY.replacen("token_vectors = 8", "token_vectors = 8\nparameterisation = \"twist\"", 1);
    let objective = "[train.objective]\nerror = \"twist\"\n\n[eval]";
    let reflow = "[reflow]\nupdates = 12\npairs = { windows = 1, noises = 2, solver = { kind = \"heun\", steps = 2 } }";
    format!("{}\n{reflow}\n", network.replacen("[eval]", objective, 1))
}

#[test]
fn a_flow_of_velocities_goes_through_every_command() {
    let bench = Bench::new();
    fs::write(bench.path("tiny.toml"), config()).unwrap();
    let summary = bench.json("run tiny.toml --json");
    let flows = summary["flows"].as_array().unwrap();
    assert_eq!(flows.len(), 2);
    let root = "runs/tiny";
    for name in ["checkpoint", "checkpoint-2"] {
        let kept = String::from_utf8(bench.bytes(&format!("{root}/{name}/config.toml"))).unwrap();
        assert!(kept.contains("parameterisation = \"twist\""), "{name}:\n{kept}");
    }

    bench.succeed("gen --task triangle --episodes 2 --seed 90 --split validation --out held_out.npz");
    let policy = format!("{root}/checkpoint-2");
    let predict = format!("predict --checkpoint {policy} --data held_out.npz --seeds 2");
    let report = bench.json(&format!("{predict} --solver rk4 --steps 2 --out p.npz --json"));
    assert_eq!((&report["steps"], &report["evaluations"]), (&Value::from(2), &Value::from(8)));
    let drawn = Predictions::read(bench.path("p.npz")).unwrap();
    assert_eq!((drawn.chunks.len(), drawn.chunks[0].len()), (2, 2));
    let eval = format!("eval --checkpoint {policy} --data held_out.npz --seeds 2 --out e.json --json");
    let eval = bench.json(&eval);
    assert!(eval["straightness"]["absolute"].as_f64().is_some_and(|absolute| absolute > 0.0), "{eval}");
    for row in eval["rows"].as_array().unwrap() {
        assert_eq!(row["per_node"], Value::Array(Vec::new()), "nodes say no trajectories");
        assert!(row["node_spread"].as_f64().is_some_and(|spread| spread > 0.0), "{row}");
    }
    let roll =
        format!("rollout --policy {policy} --task triangle --episodes 1 --seed 90 --steps 2 --disturb");
    let report = bench.json(&format!("{roll} --out r.json --json"));
    assert_eq!((&report["steps"], &report["disturbed"]), (&Value::from(2), &Value::from(true)));

    // Flow 2 by hand: what the file says of the network is the checkpoint's to say, and the objective has to go with it.
    bench.succeed("gen --task triangle --episodes 2 --seed 90 --out train.npz");
    let reflow = format!("reflow --config tiny.toml --checkpoint {root}/checkpoint --data train.npz");
    bench.succeed(&format!("{reflow} --out flow-2"));
    let pairs = PairSet::read(bench.path("flow-2.pairs.npz")).unwrap();
    assert_eq!((pairs.windows.len(), pairs.windows[0].pairs.len()), (2, 2));
    fs::write(bench.path("poses.toml"), TINY).unwrap();
    let reflow = reflow.replace("tiny.toml", "poses.toml");
    bench.refuses(&format!("{reflow} --out flow-3"), &["train.objective.error", "predicts none"]);
    assert!(!bench.path("flow-3.pairs.npz").exists(), "pairs were made for a training that is refused");
}

#[test]
fn combinations_that_make_no_sense_with_velocities_are_refused_with_the_reason() {
    let bench = Bench::new();
    fs::write(bench.path("tiny.toml"), config()).unwrap();
    let key = "model.network.decoder.parameterisation";
    for (set, parts) in [
        ("train.objective.error=chordal", ["train.objective.error = \"chordal\"", "compares clean poses"]),
        ("model.regression=true", ["model.regression = true", "velocities only"]),
        ("regressor=true", ["`regressor` is true", "velocities only"]),
    ] {
        bench.refuses(&format!("run tiny.toml --set {set}"), &[parts[0], parts[1], key]);
    }
    let unknown = format!("run tiny.toml --set {key}=screw");
    bench.refuses(&unknown, &[key, "`screw`", "endpoint, twist"]);
    // There is one place for it.
    bench.refuses(
        "run tiny.toml --set model.parameterisation=twist",
        &["unknown key `model.parameterisation`"],
    );
    assert!(!bench.path("runs").exists(), "a refused run left something");
}
