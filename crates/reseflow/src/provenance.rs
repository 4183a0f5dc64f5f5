//! Where a figure comes from: version, commit, device and machine, written beside every result.

use std::path::Path;
use std::sync::OnceLock;

use serde::{Deserialize, Serialize};

/// What a result was made with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// This program's version.
    pub version: String,
    /// The commit that the program was built from, `+` appended where files were changed; `null` where it was built outside
    /// its repository.
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
            commit: option_env!("RESEFLOW_COMMIT").map(str::to_owned),
            device: device.to_owned(),
            platform: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            processor: processor(),
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            command: std::env::args_os().map(|word| word.to_string_lossy().into_owned()).collect(),
        }
    }
}

/// The hash of the running program's file: another build, another hash.
pub fn program_hash() -> &'static str {
    static HASH: OnceLock<String> = OnceLock::new();
    HASH.get_or_init(|| {
        let program = std::env::current_exe().and_then(std::fs::read);
        program.map_or_else(
            |_| env!("CARGO_PKG_VERSION").to_owned(),
            |bytes| blake3::hash(&bytes).to_hex().to_string(),
        )
    })
}

/// The content hash of a file, or of every file in a folder with its name.
///
/// # Errors
/// When something in it cannot be read.
pub fn content_hash(path: &Path) -> std::io::Result<String> {
    let mut hasher = blake3::Hasher::new();
    if path.is_dir() {
        let mut entries = std::fs::read_dir(path)?.collect::<std::io::Result<Vec<_>>>()?;
        entries.sort_by_key(std::fs::DirEntry::file_name);
        for entry in entries {
            hasher.update(entry.file_name().as_encoded_bytes());
            hasher.update(content_hash(&entry.path())?.as_bytes());
        }
    } else {
        hasher.update(&std::fs::read(path)?);
    }
    Ok(hasher.finalize().to_hex().to_string())
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
