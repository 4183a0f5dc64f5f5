//! A checkpoint that cannot be used, and a training that cannot be done: one sentence, exit code 2, and nothing overwritten.

use std::fs;

use crate::support::Bench;

/// Copies the folder `policy` to `to` and gives the bytes of its file `name` to `harm`; `None` removes the file.
fn damaged(bench: &Bench, to: &str, name: &str, harm: impl Fn(Vec<u8>) -> Option<Vec<u8>>) {
    fs::create_dir(bench.path(to)).unwrap();
    for entry in fs::read_dir(bench.path("policy")).unwrap() {
        let entry = entry.unwrap();
        fs::copy(entry.path(), bench.path(to).join(entry.file_name())).unwrap();
    }
    let file = bench.path(to).join(name);
    match harm(fs::read(&file).unwrap()) {
        Some(bytes) => fs::write(file, bytes).unwrap(),
        None => fs::remove_file(file).unwrap(),
    }
}

fn replaced(bytes: Vec<u8>, from: &str, to: &str) -> Option<Vec<u8>> {
    let text = String::from_utf8(bytes).unwrap();
    assert!(text.contains(from), "no `{from}` in:\n{text}");
    Some(text.replacen(from, to, 1).into_bytes())
}

#[test]
fn a_checkpoint_that_cannot_be_used_is_refused_by_every_command() {
    let bench = Bench::with_policy();
    let (weights, config) = ("model.safetensors", "config.toml");
    damaged(&bench, "half", weights, |bytes| Some(bytes[..bytes.len() / 2].to_vec()));
    damaged(&bench, "blank", weights, |_| Some(Vec::new()));
    damaged(&bench, "noise", weights, |bytes| Some(bytes.iter().rev().copied().collect()));
    damaged(&bench, "weightless", weights, |_| None);
    damaged(&bench, "nameless", config, |_| None);
    damaged(&bench, "key", config, |bytes| replaced(bytes, "token_vectors", "token_vector"));
    damaged(&bench, "size", config, |bytes| replaced(bytes, "channels = 8", "channels = 12"));
    damaged(&bench, "zero", config, |bytes| replaced(bytes, "nodes = 2", "nodes = 0"));
    for name in ["kept.npz", "kept.json", "kept.mcap"] {
        fs::write(bench.path(name), "older result").unwrap();
    }
    let calls = |checkpoint: &str| {
        [
            format!("predict --checkpoint {checkpoint} --data held_out.npz --out kept.npz"),
            format!("eval --checkpoint {checkpoint} --data held_out.npz --out kept.json"),
            format!(
                "rollout --policy {checkpoint} --task triangle --episodes 1 --seed 1 --mcap kept.mcap --out kept.json"
            ),
        ]
    };
    let table: [(&str, &[&str]); 9] = [
        ("half", &["half/model.safetensors", "cut off"]),
        ("blank", &["blank/model.safetensors", "cut off"]),
        ("noise", &["noise/model.safetensors", "safetensors"]),
        ("weightless", &["weightless/model.safetensors", "no such file"]),
        ("nameless", &["nameless/config.toml", "No such file"]),
        ("key", &["key/config.toml", "`token_vector`", "`token_vectors`"]),
        ("size", &["size/model.safetensors", "has the shape [3, 8], expected [3, 12]"]),
        ("zero", &["zero/config.toml", "encoder.nodes", "at least 1"]),
        ("absent", &["absent", "no such folder"]),
    ];
    for (checkpoint, parts) in table {
        for call in calls(checkpoint) {
            bench.refuses(&call, parts);
        }
    }
    for call in calls("policy") {
        bench.refuses(&format!("{call} --device gpu"), &["--device", "gpu", "cpu", "ndarray"]);
    }
    for name in ["kept.npz", "kept.json", "kept.mcap"] {
        assert_eq!(fs::read_to_string(bench.path(name)).unwrap(), "older result", "{name}");
    }
    assert!(bench.litter().is_empty(), "temporary files were left: {:?}", bench.litter());
}

#[test]
fn a_training_that_cannot_be_done_leaves_the_older_checkpoint() {
    let bench = Bench::with_policy();
    let old = bench.bytes("policy/model.safetensors");
    fs::write(bench.path("no.npz"), "no data").unwrap();
    let train = "train --config tiny.toml --out policy --data";
    let elsewhere = "train --config tiny.toml --data train.npz --out";
    let table: [(String, &[&str]); 12] = [
        (
            "predict --checkpoint policy --data train.npz --out train.npz".to_owned(),
            &["train.npz: would replace"],
        ),
        (
            "rollout --policy policy --task triangle --episodes 1 --seed 1 --steps 1 --mcap policy/model.safetensors --out r.json"
                .to_owned(),
            &["policy/model.safetensors: would replace"],
        ),
        (format!("{elsewhere} ."), &["expected the name of a folder"]),
        (format!("{elsewhere} train.npz"), &["train.npz", "is not a folder"]),
        (format!("{elsewhere} tiny.toml/policy"), &["tiny.toml"]),
        (format!("{train} no.npz"), &["no.npz"]),
        (format!("{train} absent.npz"), &["absent.npz", "No such file"]),
        (format!("{train} train.npz --validation no.npz"), &["no.npz"]),
        (format!("{train} train.npz --device gpu"), &["--device", "gpu", "cpu"]),
        (format!("{train} train.npz --set train.batch_size=5"), &["train.batch_size", "multiple", "5 and 2"]),
        (format!("{train} train.npz --set train.ema_decay=1.5"), &["train.ema_decay", "1.5"]),
        (
            format!("{train} train.npz --set model.network.encoder.channel=4"),
            &["--set model.network.encoder.channel", "did you mean `model.network.encoder.channels`?"],
        ),
    ];
    for (call, parts) in table {
        bench.refuses(&call, parts);
        assert!(bench.bytes("policy/model.safetensors") == old, "`{call}` touched the older checkpoint");
    }
    assert!(bench.litter().is_empty(), "temporary files were left: {:?}", bench.litter());

    bench.succeed(&format!("{train} train.npz --set train.seed=9"));
    assert!(bench.bytes("policy/model.safetensors") != old, "a training that can be done replaces it");
    assert!(bench.litter().is_empty(), "temporary files were left: {:?}", bench.litter());
}
