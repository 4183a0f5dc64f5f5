//! A training that is killed with SIGKILL, at whatever moment, goes on to the bytes of one that was not; a state that does not fit
//! is refused by `train` and ignored by `run`.

use std::fs;
use std::process::{Child, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde_json::Value;

use crate::support::{Bench, TINY};

const UPDATES: usize = 60;
const STATE: &str = "policy.partial/state";

/// A folder with a training of sixty updates that saves its state after every fifth.
fn bench() -> Bench {
    let bench = Bench::new();
    fs::write(bench.path("tiny.toml"), TINY).unwrap();
    bench.succeed("gen --task triangle --episodes 4 --seed 90 --out train.npz");
    bench.succeed("gen --task triangle --episodes 2 --seed 90 --split validation --out held_out.npz");
    bench
}

fn train(out: &str, more: &str) -> String {
    format!(
        "train --config tiny.toml --data train.npz --validation held_out.npz --out {out} \
         --set train.updates={UPDATES} --set train.save_every=5 {more}"
    )
}

fn start(bench: &Bench, call: &str) -> Child {
    bench.command(call).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
}

/// Waits until `done`, or until the process has ended; minutes at most.
fn wait(child: &mut Child, done: impl Fn() -> bool) -> Option<ExitStatus> {
    let started = Instant::now();
    while started.elapsed() < Duration::from_secs(300) {
        let ended = child.try_wait().unwrap();
        if ended.is_some() || done() {
            return ended;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    panic!("nothing happened for five minutes");
}

/// Kills the process, if it has not ended, and returns what it said.
fn kill(mut child: Child) -> String {
    child.kill().unwrap();
    let output = child.wait_with_output().unwrap();
    String::from_utf8(output.stderr).unwrap()
}

/// The metrics without the speed, which no two runs share.
fn untimed(bench: &Bench, name: &str) -> Vec<Value> {
    let text = String::from_utf8(bench.bytes(name)).unwrap();
    let line = |text: &str| {
        let mut line: Value = serde_json::from_str(text).unwrap();
        line.as_object_mut().unwrap().remove("samples_per_sec");
        line
    };
    text.lines().map(line).collect()
}

#[test]
fn a_training_killed_at_random_moments_and_resumed_ends_with_the_bytes_of_one_left_alone() {
    let bench = bench();
    let started = Instant::now();
    bench.succeed(&train("alone", ""));
    let whole = started.elapsed();
    let weights = bench.bytes("alone/model.safetensors");
    let metrics = untimed(&bench, "alone/metrics.jsonl");
    let updates: Vec<_> = metrics.iter().filter(|line| line.get("loss").is_some()).collect();
    assert_eq!(updates.len(), UPDATES);
    assert!(updates.iter().enumerate().all(|(index, line)| line["update"] == index + 1));

    let mut rng = ChaCha8Rng::seed_from_u64(u64::from(std::process::id()));
    let (mut killed, mut resumed) = (0, 0);
    while killed < 8 {
        let mut child = start(&bench, &train("policy", "--resume"));
        if killed % 2 == 1 {
            // Half of the kills come when there is something to lose, the others at any time, the very start included.
            let before = fs::metadata(bench.path(STATE)).and_then(|meta| meta.modified()).ok();
            let newer = || fs::metadata(bench.path(STATE)).and_then(|meta| meta.modified()).ok() != before;
            wait(&mut child, newer);
        }
        let moment = whole.mul_f64(rng.random_range(0.0..0.4));
        let deadline = Instant::now() + moment;
        let ended = wait(&mut child, || Instant::now() >= deadline);
        let said = kill(child);
        resumed += usize::from(said.contains("training goes on after update"));
        if let Some(status) = ended {
            assert!(status.success(), "{said}");
            check_whole(&bench, &weights, &metrics);
            fs::remove_dir_all(bench.path("policy")).unwrap();
        } else {
            killed += 1;
        }
        let names = bench.names(".");
        assert!(
            names.iter().all(|name| {
                ["alone", "policy", "policy.partial", "tiny.toml", "train.npz", "held_out.npz"]
                    .contains(&name.as_str())
            }),
            "a killed training left rubbish: {names:?}"
        );
        if bench.path("policy.partial").exists() {
            let names = bench.names("policy.partial");
            let aside = names.iter().filter(|name| name.starts_with(".reseflow-")).count();
            assert!(aside <= 1 && names.len() <= 5, "rubbish grows: {names:?}");
        }
    }
    println!("killed {killed} times, resumed {resumed} times");
    assert!(resumed > 0, "no kill came after a state had been saved");
    bench.succeed(&train("policy", "--resume"));
    check_whole(&bench, &weights, &metrics);
}

/// The checkpoint is that of the training that was left alone, and nothing else remains of the kills.
fn check_whole(bench: &Bench, weights: &[u8], metrics: &[Value]) {
    assert!(bench.bytes("policy/model.safetensors") == weights, "the weights differ");
    assert_eq!(untimed(bench, "policy/metrics.jsonl"), metrics);
    assert!(!bench.path("policy.partial").exists(), "the state outlived its training");
}

#[test]
fn a_state_of_another_training_or_a_damaged_one_is_refused_with_one_sentence() {
    let bench = bench();
    // So long that it is certainly killed before its end.
    let endless = |more: &str| train("policy", &format!("--set train.updates=1000000 {more}"));
    let mut child = start(&bench, &endless(""));
    let ended = wait(&mut child, || bench.path(STATE).exists());
    let said = kill(child);
    assert!(ended.is_none(), "{said}");
    let state = bench.bytes(STATE);

    bench.succeed("gen --task triangle --episodes 3 --seed 90 --out other.npz");
    let other_data = endless("--resume").replace("train.npz", "other.npz");
    bench.refuses(&other_data, &["policy.partial/state", "other demonstrations"]);
    let blind = endless("--resume").replace("--validation held_out.npz", "");
    bench.refuses(&blind, &["policy.partial/state", "other validation episodes"]);
    let other_config = endless("--resume --set train.learning_rate=4e-3");
    bench.refuses(&other_config, &["policy.partial/state", "another configuration"]);
    assert!(bench.bytes(STATE) == state, "a refused state was touched");
    for length in [state.len() / 2, state.len() - 1, 20, 0] {
        fs::write(bench.path(STATE), &state[..length]).unwrap();
        bench.refuses(&endless("--resume"), &["policy.partial/state", "cut off"]);
        assert!(bench.bytes(STATE) == state[..length], "a refused state was touched");
    }
    assert!(!bench.path("policy").exists());
}

#[test]
fn a_run_goes_on_by_itself_and_ignores_a_state_that_it_cannot_use() {
    let bench = Bench::new();
    let config = TINY.replace("updates = 30", "updates = 60\nsave_every = 5");
    fs::write(bench.path("tiny.toml"), config).unwrap();
    let weights =
        |bench: &Bench, folder: &str| bench.bytes(&format!("{folder}/tiny/checkpoint/model.safetensors"));
    bench.succeed("run tiny.toml --set output=alone");

    let state = bench.path("runs/tiny/checkpoint.partial/state");
    let interrupt = || {
        let mut child = start(&bench, "run tiny.toml");
        let ended = wait(&mut child, || state.exists());
        let said = kill(child);
        assert!(ended.is_none(), "the run ended before it could be killed: {said}");
    };
    let finish = || {
        let output = bench.run("run tiny.toml");
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{said}");
        assert!(!state.exists());
        assert!(weights(&bench, "runs") == weights(&bench, "alone"), "the weights differ: {said}");
        said
    };
    interrupt();
    let said = finish();
    assert!(said.contains("training goes on after update"), "{said}");

    fs::remove_dir_all(bench.path("runs")).unwrap();
    interrupt();
    let bytes = fs::read(&state).unwrap();
    fs::write(&state, &bytes[..bytes.len() / 2]).unwrap();
    let said = finish();
    assert!(said.contains("warning: training starts anew") && said.contains("cut off"), "{said}");
}
