//! A folder to run the real binary in, and files with one fault each.

use std::fs::{self, File};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;
use zip::write::SimpleFileOptions;
use zip::{ZipArchive, ZipWriter};

/// A run of a few seconds with a network of a few thousand numbers. Its seed is one that no reported figure uses.
pub(crate) const TINY: &str = r#"
name = "tiny"
task = "triangle"
output = "runs"
device = "cpu"

[data]
train_episodes = 3
validation_episodes = 2
test_episodes = 2
seed = 90

[model.network.encoder]
graph = { centres = 8, point_neighbors = 6, centre_neighbors = 4 }
channels = 8
layers = 1
nodes = 2
point_radial = { count = 6, max_m = 0.12 }
centre_radial = { count = 6, max_m = 0.3 }

[model.network.decoder]
horizon = 10
frames = 2
layers = 1
token_scalars = 16
token_vectors = 8

[train]
updates = 30
batch_size = 4
shards = 2
learning_rate = 5e-3
warmup = 5
ema_decay = 0.9
validate_every = 20
seed = 1

[eval]
steps = [1, 3]
seeds = 2

[rollout]
episodes = 2
steps = 1
n_action_steps = 5
log_episodes = 1
picture_episodes = 1
"#;

/// A temporary folder in which the binary is run.
pub(crate) struct Bench {
    folder: tempfile::TempDir,
}

impl Bench {
    /// An empty folder.
    pub(crate) fn new() -> Self {
        Self { folder: tempfile::tempdir().unwrap() }
    }

    /// The path of `name` in the folder.
    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Runs `reseflow` with the words of `call`.
    pub(crate) fn run(&self, call: &str) -> Output {
        self.command(call).output().unwrap()
    }

    /// `reseflow` with the words of `call`, not yet started.
    pub(crate) fn command(&self, call: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_reseflow"));
        command.current_dir(self.folder.path()).args(call.split_whitespace());
        command
    }

    /// The bytes of the file `name`.
    pub(crate) fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|fault| panic!("{name}: {fault}"))
    }

    /// The JSON in the file `name`.
    pub(crate) fn read_json(&self, name: &str) -> Value {
        serde_json::from_slice(&self.bytes(name)).unwrap()
    }

    /// Writes `tiny.toml`, four episodes `train.npz` and three `held_out.npz`, and trains the policy in `policy`.
    pub(crate) fn with_policy() -> Self {
        let bench = Self::new();
        fs::write(bench.path("tiny.toml"), TINY).unwrap();
        bench.succeed("gen --task triangle --episodes 4 --seed 90 --out train.npz");
        bench.succeed("gen --task triangle --episodes 3 --seed 90 --split validation --out held_out.npz");
        bench.succeed("train --config tiny.toml --data train.npz --out policy");
        bench
    }

    /// Standard output of a call that must succeed.
    pub(crate) fn succeed(&self, call: &str) -> String {
        let output = self.run(call);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "`{call}` failed: {errors}");
        String::from_utf8(output.stdout).unwrap()
    }

    /// The JSON on standard output of a call that must succeed.
    pub(crate) fn json(&self, call: &str) -> Value {
        serde_json::from_str(&self.succeed(call)).unwrap()
    }

    /// A call that must be refused: exit code 2, nothing on standard output, one line on standard error that contains `parts`.
    pub(crate) fn refuses(&self, call: &str, parts: &[&str]) {
        let output = self.run(call);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "`{call}`: {errors}");
        assert!(output.stdout.is_empty(), "`{call}` printed a result");
        assert_eq!(errors.trim_end().lines().count(), 1, "`{call}`: expected one line, got:\n{errors}");
        for part in parts {
            assert!(errors.contains(part), "`{call}`: expected `{part}` in: {errors}");
        }
    }

    /// The names of everything in the folder `name`.
    pub(crate) fn names(&self, name: &str) -> Vec<String> {
        let entries = fs::read_dir(self.path(name)).unwrap();
        entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect()
    }

    /// Files that a failed write left behind.
    pub(crate) fn litter(&self) -> Vec<String> {
        let names = std::fs::read_dir(self.folder.path()).unwrap();
        let names = names.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned());
        names.filter(|name| name.starts_with('.')).collect()
    }
}

/// One member of an npz: its header's text and its data.
pub(crate) struct Member {
    /// The dictionary in Python's notation, padded with blanks.
    pub(crate) header: String,
    /// The elements' bytes, little-endian.
    pub(crate) data: Vec<u8>,
}

/// Copies the data set `from` to `to`, the array `name` changed, or left out where `change` gives `None`.
pub(crate) fn tamper(from: &Path, to: &Path, name: &str, change: impl Fn(Member) -> Option<Member>) {
    let mut archive = ZipArchive::new(File::open(from).unwrap()).unwrap();
    let mut copy = ZipWriter::new(File::create(to).unwrap());
    for index in 0..archive.len() {
        let mut file = archive.by_index(index).unwrap();
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).unwrap();
        let file_name = file.name().unwrap().into_owned();
        if file_name == format!("{name}.npy") {
            // Version 1: six bytes of magic, two of version, two of header length.
            let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
            let header = String::from_utf8(bytes[10..10 + length].to_vec()).unwrap();
            let Some(changed) = change(Member { header, data: bytes[10 + length..].to_vec() }) else {
                continue;
            };
            assert_eq!(changed.header.len(), length, "the header keeps its length");
            bytes.splice(10.., [changed.header.as_bytes(), &changed.data].concat());
        }
        copy.start_file(file_name, SimpleFileOptions::default()).unwrap();
        copy.write_all(&bytes).unwrap();
    }
    copy.finish().unwrap();
}
