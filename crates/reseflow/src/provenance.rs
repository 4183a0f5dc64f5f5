//! Where a figure comes from: version, commit, device and machine, written beside every result.

use std::path::Path;
use std::process::Command;

use serde::{Deserialize, Serialize};

/// What a result was made with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// This program's version.
    pub version: String,
    /// The commit that the program was built from, `+` appended where files were changed; `null` outside its repository.
    pub commit: Option<String>,
    /// Where tensors lived.
    pub device: String,
    /// Operating system and architecture.
    pub platform: String,
    /// The processor's name, where the system tells.
    pub processor: Option<String>,
    /// Threads that can run at once.
    pub threads: usize,
    /// The command line.
    pub command: Vec<String>,
}

impl Provenance {
    /// The facts about this process.
    pub fn gather(device: &str) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            commit: commit(),
            device: device.to_owned(),
            platform: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            processor: processor(),
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            command: std::env::args().collect(),
        }
    }
}

/// The commit of the repository that the running program lies in, if that is this project's.
fn commit() -> Option<String> {
    let program = std::env::current_exe().ok()?;
    let folder = program.parent()?;
    let git = |arguments: &[&str]| -> Option<String> {
        let output = Command::new("git").arg("-C").arg(folder).args(arguments).output().ok()?;
        let text = String::from_utf8(output.stdout).ok()?;
        output.status.success().then(|| text.trim().to_owned())
    };
    let root = git(&["rev-parse", "--show-toplevel"])?;
    if !Path::new(&root).join("crates/reseflow/Cargo.toml").is_file() {
        return None;
    }
    let hash = git(&["rev-parse", "--short=12", "HEAD"])?;
    let changed =
        git(&["status", "--porcelain", "--untracked-files=no"]).is_some_and(|text| !text.is_empty());
    Some(if changed { hash + "+" } else { hash })
}

fn processor() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

/// The largest resident memory of this process so far, MiB, where the system tells.
pub fn peak_memory_mib() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kib: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kib / 1024.0)
}
