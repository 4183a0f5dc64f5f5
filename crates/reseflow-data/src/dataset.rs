//! The data-set file: recorded episodes as arrays in one `.npz`, with their provenance beside them.
//!
//! | array | type | shape | meaning |
//! |---|---|---|---|
//! | `points` | float32 | \[E, T, N, 3\] | the camera's points, world frame, metres |
//! | `rgb` | uint8 | \[E, T, N, 3\] | their colours, sRGB |
//! | `gripper_pose` | float32 | \[E, T, 4, 4\] | reached `world_from_gripper` at the start of each action step |
//! | `gripper_opening` | float32 | \[E, T\] | reached opening, 0 closed to 1 open |
//! | `action_pose` | float32 | \[E, T, 4, 4\] | commanded `world_from_gripper` at the end of each action step |
//! | `action_opening` | float32 | \[E, T\] | commanded opening |
//! | `action_pose_alt` | float32 | \[E, T, 4, 4\] | what another expert, as good, would have commanded; optional |
//! | `disturbed` | int32 | \[E, 2\] | before which step the scene was disturbed, and from which on the actions answer it; both 0 where it was not; optional |
//! | `meta` | text | \[\] | JSON, see [`DatasetMeta`]; optional |
//!
//! E episodes of T action steps with N points a frame. In Python: `file = numpy.load(path)` and
//! `meta = json.loads(str(file["meta"]))`.

mod arrays;
mod disturbance;
pub(crate) mod extents;
mod meta;
pub(crate) mod pose_array;
mod summary;

use std::path::Path;

use crate::npz::{NpzReader, NpzWriter};
use crate::{DataError, Episode, write_atomically};
use arrays::DatasetArrays;
pub use meta::{DATASET_VERSION, DatasetMeta};
pub use summary::{DatasetSummary, HashCheck, PoseRange};

/// Recorded episodes, all with the same number of steps T and of points N.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Dataset {
    /// The episodes, E of them.
    pub episodes: Vec<Episode>,
    /// Where they come from; `None` for files that were written without it.
    pub meta: Option<DatasetMeta>,
}

/// A data set as found in a file, with what is known about the file itself.
#[derive(Debug, Clone)]
pub struct DatasetFile {
    /// The episodes and their provenance.
    pub dataset: Dataset,
    /// blake3 over the arrays as they lie in the file, in hexadecimal: what the data set is, whatever its name.
    pub content_hash: String,
    /// Why `meta` was ignored, where it is there but is not what this library writes.
    pub meta_fault: Option<String>,
}

impl Dataset {
    /// Reads and checks a data set.
    ///
    /// Poses come back as the rotation nearest to the stored `float32` matrix; everything else bit by bit.
    ///
    /// # Errors
    /// When the file is missing or damaged, an array is missing or has the wrong type or shape, a number is not finite, a matrix is
    /// no rigid transform, or an opening lies outside \[0, 1\]. The message names file, array, index and expectation.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, DataError> {
        Ok(DatasetFile::read(path)?.dataset)
    }

    /// Writes the data set: whole or not at all, and the same bytes for the same episodes. `meta.content_hash` is filled in.
    ///
    /// # Errors
    /// When the episodes differ in T or N, hold a number that is not finite or an opening outside \[0, 1\], or when the file cannot
    /// be written; what was there before then stays as it was.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), DataError> {
        let path = path.as_ref();
        let arrays =
            DatasetArrays::from_episodes(&self.episodes).map_err(|fault| DataError::invalid(path, fault))?;
        arrays.check().map_err(|fault| DataError::invalid(path, fault))?;
        let meta = match &self.meta {
            Some(meta) => {
                let meta = DatasetMeta { content_hash: Some(arrays.hash()), ..meta.clone() };
                let text = serde_json::to_string(&meta);
                Some(text.map_err(|fault| DataError::invalid(path, format!("`meta` is no JSON: {fault}")))?)
            }
            None => None,
        };
        write_atomically(path, |file| {
            let mut npz = NpzWriter::new(file);
            arrays.write(&mut npz)?;
            if let Some(meta) = &meta {
                npz.text("meta", meta)?;
            }
            npz.finish().map(drop)
        })
    }

    /// The number of episodes, E.
    pub fn len(&self) -> usize {
        self.episodes.len()
    }

    /// Whether there is no episode.
    pub fn is_empty(&self) -> bool {
        self.episodes.is_empty()
    }

    /// Action steps per episode, T; 0 without episodes.
    pub fn steps(&self) -> usize {
        self.episodes.first().map_or(0, |episode| episode.actions.len())
    }

    /// Points per cloud, N; 0 without episodes.
    pub fn points(&self) -> usize {
        let first = self.episodes.first().and_then(|episode| episode.observations.first());
        first.map_or(0, |observation| observation.cloud.len())
    }
}

impl DatasetFile {
    /// Reads and checks a data set, and says what is known about its file.
    ///
    /// # Errors
    /// As [`Dataset::read`]. A `meta` that cannot be used is no error: what counts are the arrays.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, DataError> {
        let path = path.as_ref();
        let mut npz = NpzReader::open(path)?;
        let arrays = DatasetArrays::read(&mut npz)?;
        let extents = arrays.check().map_err(|fault| DataError::invalid(path, fault))?;
        let (meta, meta_fault) = read_meta(&mut npz);
        let content_hash = arrays.hash();
        let episodes = arrays.into_episodes(extents).map_err(|fault| DataError::invalid(path, fault))?;
        Ok(Self { dataset: Dataset { episodes, meta }, content_hash, meta_fault })
    }
}

/// The provenance, or why there is none.
fn read_meta(npz: &mut NpzReader) -> (Option<DatasetMeta>, Option<String>) {
    if !npz.contains("meta") {
        return (None, None);
    }
    let text = match npz.text("meta") {
        Ok(text) => text,
        Err(DataError::Invalid { fault, .. }) => return (None, Some(fault)),
        Err(DataError::Io { source, .. }) => return (None, Some(source.to_string())),
    };
    match serde_json::from_str(&text) {
        Ok(meta) => (Some(meta), None),
        Err(fault) => (None, Some(format!("`meta` is not the JSON that this program writes: {fault}"))),
    }
}
