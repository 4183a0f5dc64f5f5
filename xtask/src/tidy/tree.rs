//! The text files of the workspace.

use std::path::Path;

use anyhow::{Context, Result};

/// Top-level folders that hold no source: build outputs and the runs of experiments.
const SKIPPED: [&str; 2] = ["target", "runs"];

/// The hidden top-level folders that are ours; any other (`.git`, a virtual environment) is skipped.
const HIDDEN: [&str; 3] = [".cargo", ".ci", ".config"];

/// Whether the folder at `path`, relative to the root, is looked into.
fn is_source_folder(path: &str) -> bool {
    !SKIPPED.contains(&path) && (!path.starts_with('.') || HIDDEN.iter().any(|ours| path.starts_with(ours)))
}

/// A text file and where it lies.
#[derive(Debug)]
pub(crate) struct SourceFile {
    /// Relative to the workspace's root, with `/`.
    pub(crate) path: String,
    /// What it says.
    pub(crate) text: String,
}

impl SourceFile {
    /// The last part of the path.
    pub(crate) fn name(&self) -> &str {
        self.path.rsplit('/').next().unwrap_or(&self.path)
    }

    /// Whether the name ends with one of `extensions`.
    pub(crate) fn has_extension(&self, extensions: &[&str]) -> bool {
        self.name().rsplit_once('.').is_some_and(|(_, extension)| extensions.contains(&extension))
    }
}

/// Every text file under `root` but for top-level folders that hold no source, sorted by path.
///
/// # Errors
/// When a folder or a file cannot be read.
pub(crate) fn read(root: &Path) -> Result<Vec<SourceFile>> {
    let mut files = Vec::new();
    let mut pending = vec![String::new()];
    while let Some(folder) = pending.pop() {
        let here = root.join(&folder);
        for entry in std::fs::read_dir(&here).with_context(|| format!("cannot list {}", here.display()))? {
            let entry = entry?;
            let name = entry.file_name().to_string_lossy().into_owned();
            let path = if folder.is_empty() { name } else { format!("{folder}/{name}") };
            let kind = entry.file_type()?;
            if kind.is_dir() && is_source_folder(&path) {
                pending.push(path);
            } else if kind.is_file() {
                let bytes = std::fs::read(entry.path()).with_context(|| format!("cannot read {path}"))?;
                if let Ok(text) = String::from_utf8(bytes) {
                    files.push(SourceFile { path, text });
                }
            }
        }
    }
    files.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(files)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn build_outputs_and_binary_files_are_left_out() {
        let root = std::env::temp_dir().join(format!("reseflow-tidy-{}", std::process::id()));
        for folder in ["src", "target/debug", "src/target", ".ci", ".git"] {
            std::fs::create_dir_all(root.join(folder)).unwrap();
        }
        std::fs::write(root.join("src/lib.rs"), "//! A.").unwrap();
        std::fs::write(root.join("src/target/b.rs"), "//! B.").unwrap();
        std::fs::write(root.join("target/debug/c.rs"), "//! C.").unwrap();
        std::fs::write(root.join(".ci/run"), "true").unwrap();
        std::fs::write(root.join(".git/config"), "[core]").unwrap();
        std::fs::write(root.join("cloud.npz"), [0xff, 0xfe, 0x00]).unwrap();
        let paths: Vec<String> = read(&root).unwrap().into_iter().map(|file| file.path).collect();
        std::fs::remove_dir_all(&root).unwrap();
        assert_eq!(paths, [".ci/run", "src/lib.rs", "src/target/b.rs"]);
    }
}
