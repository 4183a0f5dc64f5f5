//! A disk that takes no more: what was there stays whole, one sentence says which file failed, and with room again the work goes on.
//!
//! The limit on the size of a file stands for the full disk: a write beyond it fails half-way, as there.

use std::fs;
use std::process::{Command, Output};

use crate::support::{Bench, TINY};

/// Runs a call that may not make any file larger than `bytes`.
fn run_within(bench: &Bench, bytes: u64, call: &str) -> Output {
    // Without the signal, so that the write returns an error.
    let script = format!("trap '' XFSZ; ulimit -f {}; exec \"$0\" \"$@\"", bytes / 512);
    let program = bench.command("").get_program().to_owned();
    let mut command = Command::new("sh");
    command.arg("-c").arg(script).arg(program).args(call.split_whitespace());
    command.current_dir(bench.path(".")).output().unwrap()
}

/// Makes sure that the call failed, and that its last line names `file`.
#[track_caller]
fn assert_failed_at(output: &Output, file: &str) {
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(matches!(output.status.code(), Some(1 | 2)), "{said}");
    let faults: Vec<&str> = said.lines().filter(|line| line.starts_with("error: ")).collect();
    assert!(faults.len() == 1 && faults[0].contains(file), "expected `{file}` in: {said}");
    assert!(said.trim_end().ends_with(faults[0]), "expected nothing after the error: {said}");
}

#[test]
fn a_disk_that_fills_up_loses_nothing() {
    let bench = Bench::with_policy();
    let weights = bench.bytes("policy/model.safetensors");
    let small = weights.len() as u64 / 2;
    let all = |folder: &str| {
        bench.names(folder).iter().map(|name| bench.bytes(&format!("{folder}/{name}"))).collect::<Vec<_>>()
    };

    // The checkpoint does not fit: the older one stays, and nothing beside it.
    let before = all("policy");
    let anew = "train --config tiny.toml --data train.npz --out policy --set train.seed=2 --set train.updates=4 --set train.save_every=0";
    assert_failed_at(&run_within(&bench, small, anew), "model.safetensors");
    assert!(all("policy") == before, "the older checkpoint was touched");
    assert!(!bench.path("policy.partial").exists(), "there was no state to keep");

    // The state does not fit: the older state stays, and the training goes on from it once there is room.
    let long = |out: &str, more: &str| {
        format!(
            "train --config tiny.toml --data train.npz --out {out} --set train.updates=12 --set train.save_every=4 {more}"
        )
    };
    bench.succeed(&long("whole", ""));
    let fits = weights.len() as u64 + 4096;
    assert_failed_at(&run_within(&bench, fits, &long("other", "")), "other.partial/state");
    assert!(!bench.path("other").exists());

    // Everything fits but the data set that is being recorded.
    let data = bench.bytes("train.npz");
    let record = "gen --task triangle --episodes 4 --seed 91 --out train.npz";
    assert_failed_at(&run_within(&bench, data.len() as u64 / 2, record), "train.npz");
    assert!(bench.bytes("train.npz") == data, "the older data set was touched");

    bench.succeed(&long("other", "--resume"));
    assert!(bench.bytes("other/model.safetensors") == bench.bytes("whole/model.safetensors"));
    assert!(
        !bench.names(".").iter().any(|name| name.starts_with(".reseflow-") || name.ends_with(".partial"))
    );
    assert!(fs::read_to_string(bench.path("tiny.toml")).unwrap() == TINY);
}
