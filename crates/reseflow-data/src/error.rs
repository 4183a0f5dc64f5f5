//! What can be wrong with a data file, said in one sentence.

use std::path::{Path, PathBuf};

/// A fault in a data set or a log. Every message names the file and what was expected.
#[derive(Debug, thiserror::Error)]
pub enum DataError {
    /// The file cannot be read or written.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// The operating system's reason.
        source: std::io::Error,
    },
    /// The file is not what it should be.
    #[error("{path}: {fault}")]
    Invalid {
        /// The file.
        path: PathBuf,
        /// What is wrong and what was expected.
        fault: String,
    },
}

impl DataError {
    pub(crate) fn io(path: &Path, source: std::io::Error) -> Self {
        Self::Io { path: path.to_owned(), source }
    }

    pub(crate) fn invalid(path: &Path, fault: impl Into<String>) -> Self {
        Self::Invalid { path: path.to_owned(), fault: fault.into() }
    }
}
