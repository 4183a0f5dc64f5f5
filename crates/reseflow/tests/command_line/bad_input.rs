//! Bad input is one sentence, exit code 2, and nothing overwritten.

use std::fs;

use crate::support::{Bench, Member, tamper};

/// Each call gets a file with one fault and must answer with one sentence that names the file and the fault, exit with 2, and leave
/// the result that was already there as it was.
#[test]
fn bad_input_is_one_sentence_exit_code_two_and_nothing_overwritten() {
    let bench = Bench::new();
    bench.succeed("gen --task triangle --episodes 2 --seed 5 --out good.npz");
    let good = bench.path("good.npz");
    let whole = fs::read(&good).unwrap();
    fs::write(bench.path("truncated.npz"), &whole[..whole.len() / 2]).unwrap();
    fs::write(bench.path("text.npz"), "not an archive").unwrap();
    tamper(&good, &bench.path("missing.npz"), "action_pose", |_| None);
    tamper(&good, &bench.path("shape.npz"), "gripper_opening", |member| {
        Some(Member { header: member.header.replace("(2, 10)", "(20,)  "), ..member })
    });
    tamper(&good, &bench.path("nan.npz"), "points", |mut member| {
        member.data[28..32].copy_from_slice(&f32::NAN.to_le_bytes());
        Some(member)
    });
    tamper(&good, &bench.path("scaled.npz"), "gripper_pose", |mut member| {
        for pose in member.data.chunks_exact_mut(64) {
            for entry in pose.chunks_exact_mut(4).take(12) {
                let value = f32::from_le_bytes([entry[0], entry[1], entry[2], entry[3]]);
                entry.copy_from_slice(&(1.1 * value).to_le_bytes());
            }
        }
        Some(member)
    });
    fs::write(bench.path("cut.mcap"), b"\x89MCAP0\r\nxx").unwrap();
    fs::write(bench.path("good.toml"), "name = 'x'\noutput = 'new-runs'").unwrap();
    fs::write(bench.path("key.toml"), "name = 'x'\n[data]\ntrain_episode = 3").unwrap();
    fs::write(bench.path("type.toml"), "[eval]\nseeds = 'ten'").unwrap();
    fs::write(bench.path("range.toml"), "[eval]\nsteps = [1, 0]").unwrap();
    fs::create_dir(bench.path("empty")).unwrap();
    fs::write(bench.path("blocker"), "a file where a folder ought to be").unwrap();
    fs::write(bench.path("kept.npz"), "older result").unwrap();
    fs::write(bench.path("kept.json"), "older result").unwrap();

    let gen_to = |out: &str| format!("gen --task triangle --episodes 2 --seed 1 --out {out}");
    let roll = |rest: &str| format!("rollout --task triangle --seed 1 --out kept.json {rest}");
    let table: Vec<(String, &[&str])> = vec![
        ("inspect absent.npz".into(), &["absent.npz", "No such file"]),
        ("inspect truncated.npz".into(), &["truncated.npz"]),
        ("inspect text.npz".into(), &["text.npz", "npz"]),
        ("inspect missing.npz".into(), &["missing.npz", "`action_pose`"]),
        ("inspect shape.npz".into(), &["shape.npz", "`gripper_opening`", "[2, 10]"]),
        ("inspect nan.npz".into(), &["nan.npz", "`points`", "NaN", "finite"]),
        ("inspect scaled.npz".into(), &["scaled.npz", "`gripper_pose`", "rigid"]),
        ("inspect cut.mcap".into(), &["cut.mcap", "broken"]),
        (
            "gen --task trangle --episodes 2 --seed 1 --out kept.npz".into(),
            &["unknown task `trangle`", "`triangle`"],
        ),
        ("gen --task triangle --episodes 0 --seed 1 --out kept.npz".into(), &["--episodes", "1 or more"]),
        ("gen --task triangle --episodes 2 --seed -1 --out kept.npz".into(), &["-1"]),
        (gen_to("blocker/new.npz"), &["blocker/new.npz", "cannot be written"]),
        (gen_to("."), &["not a regular file"]),
        ("run absent.toml".into(), &["absent.toml", "No such file"]),
        (
            "run key.toml".into(),
            &["key.toml:3", "`data.train_episode`", "did you mean `data.train_episodes`?"],
        ),
        ("run type.toml".into(), &["type.toml:2", "`eval.seeds`", "whole number"]),
        ("run range.toml".into(), &["range.toml", "`eval.steps`", "1 or more"]),
        ("run good.toml --set tsk=door".into(), &["--set tsk", "did you mean `task`?"]),
        ("run good.toml --set task=trangle".into(), &["`trangle`", "did you mean `triangle`?"]),
        ("run good.toml --set output=blocker".into(), &["blocker/x", "cannot be written"]),
        ("train --config key.toml --data good.npz --out new".into(), &["key.toml:3", "`data.train_episode`"]),
        ("train --config good.toml --data nan.npz --out new".into(), &["nan.npz", "NaN"]),
        (
            "train --config good.toml --data good.npz --out blocker/new".into(),
            &["blocker/new", "cannot be written"],
        ),
        ("eval --checkpoint absent --data good.npz --out kept.json".into(), &["absent", "no such folder"]),
        ("eval --checkpoint empty --data good.npz --out kept.json".into(), &["empty"]),
        ("eval --checkpoint empty --data nan.npz --out kept.json".into(), &["nan.npz", "NaN"]),
        (
            "eval --checkpoint empty --data good.npz --steps 1,0 --out kept.json".into(),
            &["--steps", "1 or more"],
        ),
        ("predict --checkpoint empty --data good.npz --steps 1 --seeds 2 --out kept.npz".into(), &["empty"]),
        (roll("--policy nowhere --episodes 2 --steps 1"), &["nowhere", "no such folder"]),
        (roll("--policy expert --episodes 2 --steps 0"), &["--steps", "1 or more"]),
        (
            roll("--policy expert --episodes 2 --steps 1 --mcap blocker/l.mcap"),
            &["blocker/l.mcap", "cannot be written"],
        ),
        (roll("--policy expert --episodes 2 --steps 1 --n-action-steps x"), &["--n-action-steps"]),
        (roll("--policy expert --episodes 2 --steps 1 --split tset"), &["tset", "test"]),
    ];
    for (call, parts) in table {
        bench.refuses(&call, parts);
    }
    for name in ["kept.npz", "kept.json"] {
        assert_eq!(fs::read_to_string(bench.path(name)).unwrap(), "older result", "{name}");
    }
    for name in ["new", "new-runs"] {
        assert!(!bench.path(name).exists(), "{name} was made for nothing");
    }
    assert!(bench.litter().is_empty(), "temporary files were left: {:?}", bench.litter());
}
