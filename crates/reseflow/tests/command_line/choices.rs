//! The solver as a choice, the task that a checkpoint remembers, and what is said on request.

use std::fs;

use reseflow_data::{Dataset, Predictions};
use reseflow_lie::geodesic_distance;
use serde_json::Value;

use crate::support::{Bench, tamper};

#[test]
fn every_solver_makes_the_same_single_step_and_its_own_longer_way() {
    let bench = Bench::with_policy();
    let predict = |options: &str| {
        let call =
            format!("predict --checkpoint policy --data held_out.npz --seeds 2 --out p.npz --json {options}");
        let report = bench.json(&call);
        (report["evaluations"].as_u64().unwrap(), Predictions::read(bench.path("p.npz")).unwrap())
    };
    let (evaluations, one) = predict("");
    assert_eq!(evaluations, 1, "one Euler step is the default");
    let mut ways = Vec::new();
    for (solver, of_four) in [("euler", 4), ("midpoint", 7), ("heun", 7), ("rk4", 13)] {
        assert!(predict(&format!("--solver {solver} --steps 1")) == (1, one.clone()), "{solver}");
        let (evaluations, way) = predict(&format!("--solver {solver} --steps 4"));
        // The last step of every solver arrives with a single evaluation.
        assert_eq!(evaluations, of_four, "{solver}");
        assert!(!ways.contains(&way), "{solver} is another solver");
        ways.push(way);
    }
    let (loose, _) = predict("--solver rk45 --rtol 1e-2 --atol 1e-2");
    let (tight, exact) = predict("--solver rk45 --rtol 1e-3 --atol 1e-4");
    assert!(1 < loose && loose < tight, "{loose} and {tight} evaluations");
    let apart = |way: &Predictions| -> f64 {
        let pairs = way.chunks.iter().flatten().zip(exact.chunks.iter().flatten());
        let actions = pairs.flat_map(|(a, b)| a.iter().zip(b.iter()));
        actions.map(|(a, b)| geodesic_distance(&a.world_from_gripper, &b.world_from_gripper).d_geo()).sum()
    };
    assert!(apart(&ways[3]) < apart(&one), "four steps of rk4 are no nearer to the flow than one");

    let eval = "eval --checkpoint policy --data held_out.npz --seeds 2 --out e.json --json";
    let rows = bench.json(&format!("{eval} --solver rk45 --rtol 1e-3 --atol 1e-4"))["rows"].clone();
    assert_eq!(rows.as_array().unwrap().len(), 1);
    assert_eq!(
        (&rows[0]["solver"], &rows[0]["evaluations"]),
        (&Value::from("dormand_prince"), &Value::from(tight))
    );
    let rows = bench.json(&format!("{eval} --solver heun --steps 2,4"))["rows"].clone();
    assert_eq!([&rows[0]["evaluations"], &rows[1]["evaluations"]], [3, 7]);
    let roll = "rollout --policy policy --task triangle --episodes 1 --seed 90 --out r.json --json";
    let report = bench.json(&format!("{roll} --steps 2 --solver midpoint"));
    assert_eq!((&report["steps"], report["solver"].as_str()), (&Value::from(2), Some("midpoint")));

    bench.refuses(&format!("{eval} --solver rk45 --steps 1,2"), &["--steps", "rk45"]);
    bench.refuses(&format!("{eval} --solver heun --rtol 1e-3"), &["--solver heun", "rk45"]);
    bench.refuses(&format!("{eval} --solver rk45 --atol 0"), &["--solver rk45", "atol"]);
    bench.refuses(&format!("{eval} --solver rk5"), &["--solver", "rk5", "rk45"]);
    bench.refuses(&format!("{eval} --unimodal-d-geo 0"), &["--unimodal-d-geo", "greater than 0"]);
}

#[test]
fn a_policy_acts_on_the_task_that_it_has_learned_unless_told_otherwise() {
    let bench = Bench::with_policy();
    let roll = "rollout --policy policy --episodes 1 --seed 90 --out r.json --task";
    bench.refuses(&format!("{roll} coin_toss"), &["policy", "`triangle`, not `coin_toss`", "--any-task"]);
    assert!(!bench.path("r.json").exists());
    bench.succeed(&format!("{roll} coin_toss --any-task"));
    assert_eq!(bench.read_json("r.json")["config"]["task"], "triangle");

    let mut data = Dataset::read(bench.path("held_out.npz")).unwrap();
    data.meta.as_mut().unwrap().task = "door".to_owned();
    data.write(bench.path("door.npz")).unwrap();
    for (data, warned) in [("held_out.npz", false), ("door.npz", true)] {
        for call in [
            format!("eval --checkpoint policy --data {data} --steps 1 --seeds 2 --out e.json"),
            format!("predict --checkpoint policy --data {data} --out p.npz"),
        ] {
            let output = bench.run(&call);
            let said = String::from_utf8(output.stderr).unwrap();
            assert!(output.status.success(), "{said}");
            assert_eq!(
                said.contains("learned the task `triangle`, and door.npz is of the task `door`"),
                warned,
                "{said}"
            );
        }
    }
}

#[test]
fn a_cloud_that_no_network_can_use_is_refused_by_the_name_of_its_file() {
    let bench = Bench::with_policy();
    tamper(&bench.path("held_out.npz"), &bench.path("huge.npz"), "points", |mut member| {
        for value in member.data.chunks_exact_mut(4) {
            let metres = f32::from_le_bytes([value[0], value[1], value[2], value[3]]);
            value.copy_from_slice(&(1e30 * metres).to_le_bytes());
        }
        Some(member)
    });
    for call in [
        "eval --checkpoint policy --data huge.npz --steps 1 --out e.json",
        "predict --checkpoint policy --data huge.npz --out p.npz",
        "train --config tiny.toml --data huge.npz --out q",
        "train --config tiny.toml --data train.npz --validation huge.npz --out q",
    ] {
        let output = bench.run(call);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "`{call}`: {said}");
        assert!(said.lines().last().unwrap().starts_with("error: huge.npz: "), "`{call}`: {said}");
    }
    assert!(!bench.path("q").exists() && !bench.path("p.npz").exists());
}

#[test]
fn what_goes_on_is_told_on_request() {
    let bench = Bench::with_policy();
    let said = |call: &str| String::from_utf8(bench.run(call).stderr).unwrap();
    let train = "train --config tiny.toml --data train.npz --validation held_out.npz --out policy";
    let (plain, info, debug) = (said(train), said(&format!("{train} -v")), said(&format!("{train} -vv")));
    assert!(!plain.contains("INFO"), "{plain}");
    for part in ["INFO", "parameters=", "validation", "d_geo=", "checkpoint written"] {
        assert!(info.contains(part), "no `{part}` in:\n{info}");
    }
    assert!(!info.contains("gradient_norm=") && debug.contains("gradient_norm="), "{debug}");
    let eval = said("eval --checkpoint policy --data held_out.npz --steps 1,2 --seeds 2 --out e.json -v");
    assert_eq!(eval.lines().filter(|line| line.contains("scored")).count(), 2, "{eval}");
    fs::remove_file(bench.path("e.json")).unwrap();
}

/// A log under way has no name in its folder, so that whatever ends the program leaves nothing behind.
#[cfg(target_os = "linux")]
#[test]
fn a_rollout_that_is_killed_leaves_no_half_of_a_log() {
    use std::process::Stdio;
    let bench = Bench::new();
    let call = "rollout --policy expert --task triangle --episodes 900 --seed 90 --mcap l.mcap --mcap-episodes 900 --out r.json";
    let mut child = bench.command(call).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let folder = fs::canonicalize(bench.path(".")).unwrap();
    let logging = |pid: u32| {
        let open = fs::read_dir(format!("/proc/{pid}/fd")).into_iter().flatten().flatten();
        open.filter_map(|entry| fs::read_link(entry.path()).ok()).any(|target| target.starts_with(&folder))
    };
    while !logging(child.id()) {
        assert!(child.try_wait().unwrap().is_none(), "the rollout ended before it could be killed");
        std::thread::yield_now();
    }
    child.kill().unwrap();
    child.wait().unwrap();
    assert_eq!(bench.names("."), Vec::<String>::new());
}
