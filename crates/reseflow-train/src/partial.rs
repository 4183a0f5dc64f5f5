//! The folder `<checkpoint>.partial` beside a checkpoint under way: the training's state, its metrics so far, and the checkpoint
//! before it takes its place. It belongs to one training at a time and disappears with success.

use std::fs::{File, TryLockError};
use std::io::Write;
use std::path::{Path, PathBuf};

use crate::{TrainError, checkpoint};

const STATE: &str = "state";
const LOCK: &str = "lock";
const NEW: &str = "new";
const OLD: &str = "old";
/// Files that were being written aside when a process was killed.
const ASIDE: &str = ".reseflow-";

/// A claimed folder. Dropping it removes it, unless there is a state to go on from or an older checkpoint to put back.
#[derive(Debug)]
pub(crate) struct PartialFolder {
    path: PathBuf,
    out: PathBuf,
    metrics: File,
    /// Held until the process ends, however it ends.
    _lock: File,
}

impl PartialFolder {
    /// Claims the folder beside `out` and clears away what a killed training left, but for its state.
    ///
    /// # Errors
    /// Where another training is at work there, where the folder holds something else, and what the file system reports.
    pub(crate) fn claim(out: &Path) -> Result<Self, TrainError> {
        let mut name = out.file_name().unwrap_or_default().to_owned();
        name.push(".partial");
        let path = out.with_file_name(name);
        let io = |source| TrainError::Io { path: path.clone(), source };
        let refuse = |fault: String| Err(TrainError::State { path: path.clone(), fault });
        if let Ok(what) = std::fs::symlink_metadata(&path)
            && !what.is_dir()
        {
            return refuse("is not a folder, so a training cannot keep its state there".to_owned());
        }
        std::fs::create_dir_all(&path).map_err(io)?;
        for entry in std::fs::read_dir(&path).map_err(io)? {
            let name = entry.map_err(io)?.file_name().to_string_lossy().into_owned();
            let known = [STATE, LOCK, NEW, OLD, checkpoint::METRICS].contains(&name.as_str());
            if !known && !name.starts_with(ASIDE) {
                return refuse(format!("holds `{name}`, which is no part of a training's state"));
            }
        }
        let lock = File::create(path.join(LOCK)).map_err(io)?;
        if let Err(TryLockError::WouldBlock) = lock.try_lock() {
            return refuse("another training is at work there".to_owned());
        }
        // Killed between the two renames of a replacement: the older checkpoint goes back.
        if path.join(OLD).exists() && !out.exists() {
            std::fs::rename(path.join(OLD), out).map_err(io)?;
        }
        for entry in std::fs::read_dir(&path).map_err(io)? {
            let entry = entry.map_err(io)?;
            let name = entry.file_name();
            if name == STATE || name == LOCK {
                continue;
            }
            let is_folder = entry.file_type().map_err(io)?.is_dir();
            let remove = if is_folder { std::fs::remove_dir_all } else { std::fs::remove_file };
            remove(entry.path()).map_err(io)?;
        }
        let metrics = File::create(path.join(checkpoint::METRICS)).map_err(io)?;
        Ok(Self { path, out: out.to_owned(), metrics, _lock: lock })
    }

    /// The state's file, whether it is there or not.
    pub(crate) fn state_path(&self) -> PathBuf {
        self.path.join(STATE)
    }

    /// The bytes of the state, where there is one.
    pub(crate) fn read_state(&self) -> Result<Option<Vec<u8>>, TrainError> {
        match std::fs::read(self.state_path()) {
            Ok(bytes) => Ok(Some(bytes)),
            Err(absent) if absent.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(source) => Err(TrainError::Io { path: self.state_path(), source }),
        }
    }

    /// Replaces the state by `bytes`: wholly, or not at all.
    pub(crate) fn write_state(&self, bytes: &[u8]) -> Result<(), TrainError> {
        Ok(reseflow_data::write_atomically(&self.state_path(), |file| file.write_all(bytes))?)
    }

    /// Appends to the metrics that can be read while the training goes on.
    pub(crate) fn append_metrics(&mut self, lines: &[u8]) -> Result<(), TrainError> {
        let io = |source| TrainError::Io { path: self.path.join(checkpoint::METRICS), source };
        self.metrics.write_all(lines).map_err(io)
    }

    /// Lets `write` fill a new checkpoint, puts it in place of the older one, and ends the training's state.
    pub(crate) fn publish(
        self,
        write: impl FnOnce(&Path) -> Result<(), TrainError>,
    ) -> Result<(), TrainError> {
        let io = |source| TrainError::Io { path: self.out.clone(), source };
        let (new, old) = (self.path.join(NEW), self.path.join(OLD));
        std::fs::create_dir(&new).map_err(io)?;
        write(&new)?;
        for entry in std::fs::read_dir(&new).map_err(io)? {
            File::open(entry.map_err(io)?.path()).and_then(|file| file.sync_all()).map_err(io)?;
        }
        checkpoint::put_in_place(&new, &self.out, &old).map_err(io)?;
        // From here on the checkpoint stands; what is left of the folder is rubbish, and the next training clears it away.
        let _ = std::fs::remove_dir_all(&self.path);
        Ok(())
    }
}

impl Drop for PartialFolder {
    fn drop(&mut self) {
        if !self.state_path().exists() && !self.path.join(OLD).exists() {
            let _ = std::fs::remove_dir_all(&self.path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).unwrap();
        let mut names: Vec<_> =
            entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    /// What a process killed at `moment` of a replacement leaves: 1 after the older checkpoint moved, 2 after the new one did.
    fn killed(root: &Path, moment: u8) -> PathBuf {
        let (out, partial) = (root.join("policy"), root.join("policy.partial"));
        std::fs::create_dir_all(partial.join(OLD)).unwrap();
        std::fs::write(partial.join(OLD).join("mark"), "older").unwrap();
        let new = if moment == 1 { partial.join(NEW) } else { out.clone() };
        std::fs::create_dir(&new).unwrap();
        std::fs::write(new.join("mark"), "newer").unwrap();
        std::fs::write(partial.join(STATE), "state").unwrap();
        std::fs::write(partial.join(".reseflow-abc.part"), "half").unwrap();
        out
    }

    #[test]
    fn a_checkpoint_that_a_killed_replacement_moved_away_comes_back() {
        for (moment, expected) in [(1, "older"), (2, "newer")] {
            let root = tempfile::tempdir().unwrap();
            let out = killed(root.path(), moment);
            let claimed = PartialFolder::claim(&out).unwrap();
            assert_eq!(std::fs::read_to_string(out.join("mark")).unwrap(), expected);
            assert_eq!(claimed.read_state().unwrap().unwrap(), b"state");
            assert_eq!(names(&claimed.path), ["lock", "metrics.jsonl", "state"], "the rest is cleared away");
            drop(claimed);
            assert_eq!(names(root.path()), ["policy", "policy.partial"], "a state is kept");
        }
    }

    #[test]
    fn a_folder_without_a_state_disappears_and_one_of_somebody_else_is_left_alone() {
        let root = tempfile::tempdir().unwrap();
        let out = root.path().join("policy");
        drop(PartialFolder::claim(&out).unwrap());
        assert!(names(root.path()).is_empty());

        let other = root.path().join("policy.partial");
        std::fs::create_dir(&other).unwrap();
        std::fs::write(other.join("notes.txt"), "mine").unwrap();
        let fault = PartialFolder::claim(&out).unwrap_err().to_string();
        assert!(fault.contains("policy.partial: ") && fault.contains("notes.txt"), "{fault}");
        assert_eq!(names(&other), ["notes.txt"]);

        std::fs::remove_dir_all(&other).unwrap();
        std::fs::write(&other, "a file").unwrap();
        assert!(PartialFolder::claim(&out).unwrap_err().to_string().contains("is not a folder"));
        assert_eq!(std::fs::read_to_string(&other).unwrap(), "a file");
    }

    #[test]
    fn two_trainings_never_share_a_folder() {
        let root = tempfile::tempdir().unwrap();
        let out = root.path().join("policy");
        let first = PartialFolder::claim(&out).unwrap();
        first.write_state(b"state").unwrap();
        let fault = PartialFolder::claim(&out).unwrap_err().to_string();
        assert!(fault.contains("another training is at work"), "{fault}");
        drop(first);
        assert_eq!(PartialFolder::claim(&out).unwrap().read_state().unwrap().unwrap(), b"state");
    }
}
