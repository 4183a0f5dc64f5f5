//! Output files and folders: checked before long work, written whole or not at all.
//!
//! A result replaces an older file of the same name only once it is complete; until then, and after any failure, what was there
//! stays as it was.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::Context;
use serde::Serialize;
use tempfile::NamedTempFile;

use crate::error::bad_input;

/// A file that can be written: its folder exists and takes new files.
#[derive(Debug, Clone)]
pub struct OutputFile {
    path: PathBuf,
}

impl OutputFile {
    /// Makes sure that `path` can be written, creating its folder.
    ///
    /// # Errors
    /// Bad input when `path` is a folder, or when its folder cannot be made or written.
    pub fn claim(path: &Path) -> anyhow::Result<Self> {
        if path.exists() && !path.is_file() {
            return Err(bad_input(format!(
                "{}: is not a regular file, so it cannot be written",
                path.display()
            )));
        }
        if path.file_name().is_none() {
            return Err(bad_input(format!("{}: expected the name of a file to write", path.display())));
        }
        let folder = match path.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
            _ => PathBuf::from("."),
        };
        make_writable(&folder, path)?;
        if fs::metadata(path).is_ok_and(|meta| meta.permissions().readonly()) {
            return Err(bad_input(format!("{}: cannot be written: the file is read-only", path.display())));
        }
        Ok(Self { path: path.to_owned() })
    }

    /// [`claim`](Self::claim), and makes sure that the result does not replace one of `others`: inputs, folders of inputs, or other
    /// outputs of the same command.
    ///
    /// # Errors
    /// As [`claim`](Self::claim), and bad input when it would.
    pub fn claim_apart(path: &Path, others: &[&Path]) -> anyhow::Result<Self> {
        let claimed = Self::claim(path)?;
        let target = located(path);
        match others.iter().find(|other| target.starts_with(located(other))) {
            Some(other) => Err(bad_input(format!(
                "{}: would replace {}, which this command reads or writes as well",
                path.display(),
                other.display()
            ))),
            None => Ok(claimed),
        }
    }

    /// Where the result will be.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes `bytes`.
    ///
    /// # Errors
    /// When the file system refuses; the target is then as it was.
    pub fn write(&self, bytes: &[u8]) -> anyhow::Result<()> {
        Ok(reseflow_data::write_atomically(&self.path, |file| file.write_all(bytes))?)
    }

    /// Writes `value` as indented JSON.
    ///
    /// # Errors
    /// When it cannot be serialised or written.
    pub fn write_json(&self, value: &impl Serialize) -> anyhow::Result<()> {
        let mut text = serde_json::to_string_pretty(value).context("serialising the result")?;
        text.push('\n');
        self.write(text.as_bytes())
    }
}

/// Writes `value` as JSON to `path`, whole or not at all.
///
/// # Errors
/// Bad input when the folder cannot be written.
pub fn write_json(path: &Path, value: &impl Serialize) -> anyhow::Result<()> {
    OutputFile::claim(path)?.write_json(value)
}

/// The path with its folder's links and dots resolved; the last part need not exist.
fn located(path: &Path) -> PathBuf {
    let resolved = fs::canonicalize(path).ok();
    let through_folder = || {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        Some(fs::canonicalize(folder).ok()?.join(path.file_name()?))
    };
    resolved.or_else(through_folder).unwrap_or_else(|| path.to_owned())
}

/// A folder that takes new files.
#[derive(Debug, Clone)]
pub struct OutputFolder(PathBuf);

impl OutputFolder {
    /// Makes sure that `path` is a folder that can be written, creating it.
    ///
    /// # Errors
    /// Bad input when it cannot.
    pub fn claim(path: &Path) -> anyhow::Result<Self> {
        make_writable(path, path)?;
        Ok(Self(path.to_owned()))
    }

    /// Makes sure that the folder `path` can appear later, whole: that the one around it can be written, creating that.
    ///
    /// # Errors
    /// Bad input when it cannot.
    pub fn claim_around(path: &Path) -> anyhow::Result<()> {
        match path.parent() {
            Some(around) if !around.as_os_str().is_empty() => make_writable(around, path),
            _ => make_writable(Path::new("."), path),
        }
    }

    /// The path of `name` in this folder.
    pub fn join(&self, name: impl AsRef<Path>) -> PathBuf {
        self.0.join(name)
    }

    /// The folder itself.
    pub fn path(&self) -> &Path {
        &self.0
    }
}

/// Creates `folder` and proves by a scratch file that it can be written; `target` is what the message names.
fn make_writable(folder: &Path, target: &Path) -> anyhow::Result<()> {
    let refuse = |reason: std::io::Error| {
        bad_input(format!("{}: cannot be written: folder {}: {reason}", target.display(), folder.display()))
    };
    fs::create_dir_all(folder).map_err(refuse)?;
    NamedTempFile::new_in(folder).map_err(refuse)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::{EXIT_BAD_INPUT, exit_code};

    #[test]
    fn a_result_replaces_the_old_one_and_leaves_no_litter() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("new folder").join("result.json");
        let file = OutputFile::claim(&path).unwrap();
        file.write(b"old").unwrap();
        write_json(&path, &[1, 2]).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "[\n  1,\n  2\n]\n");
        assert_eq!(fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
    }

    #[test]
    fn a_parent_that_is_a_file_is_bad_input() {
        let folder = tempfile::tempdir().unwrap();
        let blocker = folder.path().join("blocker");
        fs::write(&blocker, "").unwrap();
        let error = OutputFile::claim(&blocker.join("out.json")).unwrap_err();
        assert_eq!(exit_code(&error), EXIT_BAD_INPUT);
        assert!(error.to_string().contains("out.json: cannot be written"), "{error}");
        assert_eq!(exit_code(&OutputFolder::claim(&blocker.join("run")).unwrap_err()), EXIT_BAD_INPUT);
        assert_eq!(exit_code(&OutputFile::claim(folder.path()).unwrap_err()), EXIT_BAD_INPUT);
    }

    #[test]
    fn a_read_only_file_is_not_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("kept.json");
        fs::write(&path, "kept").unwrap();
        let mut permissions = fs::metadata(&path).unwrap().permissions();
        permissions.set_readonly(true);
        fs::set_permissions(&path, permissions).unwrap();
        let error = OutputFile::claim(&path).unwrap_err();
        assert!(error.to_string().contains("read-only"), "{error}");
    }

    #[test]
    fn a_result_never_takes_the_place_of_what_the_command_reads() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::create_dir(path("checkpoint")).unwrap();
        fs::write(path("data.npz"), "data").unwrap();
        let (data, checkpoint) = (path("data.npz"), path("checkpoint"));
        let others = [data.as_path(), &checkpoint];
        for out in ["data.npz", "checkpoint/../data.npz", "checkpoint/model.safetensors"] {
            let error = OutputFile::claim_apart(&path(out), &others).unwrap_err();
            assert_eq!(exit_code(&error), EXIT_BAD_INPUT, "{out}");
        }
        for out in ["new.npz", "data.npz.json", "checkpoint-2"] {
            OutputFile::claim_apart(&path(out), &others).unwrap();
        }
    }
}
