//! Files that appear whole or not at all: written aside in the same folder, then renamed into place.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::TempPath;

use crate::DataError;

/// A file under way. Dropping it without [`PendingFile::publish`] leaves whatever stood at its path untouched.
#[derive(Debug)]
pub(crate) struct PendingFile {
    target: PathBuf,
    aside: TempPath,
}

impl PendingFile {
    /// Opens a new file beside `target`, which is to become `target`.
    ///
    /// # Errors
    /// When the folder is missing or cannot be written to, or when `target` is something other than a regular file.
    pub(crate) fn create(target: &Path) -> Result<(Self, File), DataError> {
        // A rename would silently replace a folder's name or a device such as /dev/null.
        if target.exists() && !target.is_file() {
            return Err(DataError::invalid(target, "is not a regular file, so it cannot be written"));
        }
        if target.file_name().is_none() {
            return Err(DataError::invalid(target, "is not a file name, so it cannot be written"));
        }
        let folder = match target.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        let mut builder = tempfile::Builder::new();
        builder.prefix(".reseflow-").suffix(".part");
        // Temporary files are private by default; the published one gets what the user's umask allows.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let aside = builder.tempfile_in(folder).map_err(|source| {
            let fault =
                format!("cannot be written, because its folder {} {}", folder.display(), why(&source));
            DataError::invalid(target, fault)
        })?;
        let (file, aside) = aside.into_parts();
        Ok((Self { target: target.to_owned(), aside }, file))
    }

    /// Flushes `file` to disk and renames it into place.
    ///
    /// # Errors
    /// When the disk is full or the rename is refused; the target is then as it was.
    pub(crate) fn publish(self, file: BufWriter<File>) -> Result<(), DataError> {
        let Self { target, aside } = self;
        let file = file.into_inner().map_err(|failed| DataError::io(&target, failed.into_error()))?;
        file.sync_all().map_err(|source| DataError::io(&target, source))?;
        drop(file);
        aside.persist(&target).map_err(|failed| DataError::io(&target, failed.error))
    }
}

/// Writes `target` through `write`: either it succeeds and the file is complete, or what was there stays as it was.
///
/// # Errors
/// When the folder cannot be written to, the disk is full, or `write` fails.
pub fn write_atomically(
    target: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> std::io::Result<()>,
) -> Result<(), DataError> {
    let (pending, file) = PendingFile::create(target)?;
    let mut file = BufWriter::with_capacity(1 << 18, file);
    write(&mut file).and_then(|()| file.flush()).map_err(|source| DataError::io(target, source))?;
    pending.publish(file)
}

/// The usual reasons in plain words.
fn why(source: &std::io::Error) -> String {
    match source.kind() {
        std::io::ErrorKind::NotFound => "does not exist".to_owned(),
        std::io::ErrorKind::NotADirectory => "is not a folder".to_owned(),
        std::io::ErrorKind::PermissionDenied => "does not allow writing".to_owned(),
        _ => format!("refuses: {source}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("kept.txt");
        std::fs::write(&target, "old").unwrap();
        let result = write_atomically(&target, |file| {
            file.write_all(b"half of the new")?;
            Err(std::io::Error::other("the disk is full"))
        });
        assert_eq!(result.unwrap_err().to_string(), format!("{}: the disk is full", target.display()));
        assert_eq!(std::fs::read_to_string(&target).unwrap(), "old");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "a temporary file was left behind");
    }

    #[test]
    fn a_missing_folder_a_folder_and_a_socket_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("nowhere").join("a.txt");
        let message = write_atomically(&missing, |_| Ok(())).unwrap_err().to_string();
        assert!(message.ends_with("nowhere does not exist"), "{message}");
        let message = write_atomically(folder.path(), |_| Ok(())).unwrap_err().to_string();
        assert!(message.ends_with("is not a regular file, so it cannot be written"), "{message}");
        let occupied = folder.path().join("file");
        std::fs::write(&occupied, "").unwrap();
        let message = write_atomically(&occupied.join("a.txt"), |_| Ok(())).unwrap_err().to_string();
        assert!(message.ends_with("file is not a folder"), "{message}");
        #[cfg(unix)]
        {
            let socket = folder.path().join("socket");
            let _listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
            let message = write_atomically(&socket, |_| Ok(())).unwrap_err().to_string();
            assert!(message.ends_with("is not a regular file, so it cannot be written"), "{message}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn the_published_file_has_the_permissions_of_an_ordinary_one() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (ours, plain) = (folder.path().join("ours"), folder.path().join("plain"));
        write_atomically(&ours, |file| file.write_all(b"new")).unwrap();
        std::fs::write(&plain, "new").unwrap();
        let mode = |path: &Path| std::fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&ours), mode(&plain));
        assert_eq!(std::fs::read(&ours).unwrap(), b"new");
    }
}
