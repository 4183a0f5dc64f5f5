//! The prediction file: for every episode and noise seed, the trajectory that a policy answers to the first observation.
//!
//! `pose` float32 \[E, S, L, 4, 4\] and `opening` float32 \[E, S, L\] for E episodes, S seeds and horizon L, in one `.npz`.

use std::path::Path;

use crate::dataset::extents::{
    Axis, check_finite, check_openings, check_shape, describe_index, leading_extents,
};
use crate::dataset::pose_array::{pose_at, push_pose};
use crate::npz::{Array, NpzReader, NpzWriter};
use crate::{Action, ActionChunk, DataError, write_atomically};

/// Predicted trajectories, all of the same horizon L.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Predictions {
    /// One chunk of L actions for each episode and, within it, for each seed.
    pub chunks: Vec<Vec<ActionChunk>>,
}

impl Predictions {
    /// Reads and checks a prediction file.
    ///
    /// # Errors
    /// When the file is missing or damaged, or an array is missing, has the wrong type or shape or holds something other than poses
    /// and openings.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, DataError> {
        let path = path.as_ref();
        let mut npz = NpzReader::open(path)?;
        let (pose, opening) = (npz.array("pose")?, npz.array("opening")?);
        let chunks = chunks_from_arrays(&pose, &opening).map_err(|fault| DataError::invalid(path, fault))?;
        Ok(Self { chunks })
    }

    /// Writes the file: whole or not at all, and the same bytes for the same predictions.
    ///
    /// # Errors
    /// When episodes differ in S or chunks in L, when a number is not finite or an opening lies outside \[0, 1\], or when the file
    /// cannot be written; what was there before then stays as it was.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), DataError> {
        let path = path.as_ref();
        let (pose, opening) =
            arrays_from_chunks(&self.chunks).map_err(|fault| DataError::invalid(path, fault))?;
        write_atomically(path, |file| {
            let mut npz = NpzWriter::new(file);
            npz.array("pose", &pose)?;
            npz.array("opening", &opening)?;
            npz.finish().map(drop)
        })
    }
}

fn check(pose: &Array<f32>, opening: &Array<f32>) -> Result<[usize; 3], String> {
    let extents = leading_extents("pose", pose, ["E (episodes)", "S (seeds)", "L (horizon)"], &[4, 4])?;
    let [e, s, l] = extents;
    let shared = [Axis::Shared("E", e), Axis::Shared("S", s), Axis::Shared("L", l)];
    check_shape("opening", opening, &shared, "pose")?;
    check_finite("pose", pose)?;
    check_openings("opening", opening)?;
    Ok(extents)
}

fn chunks_from_arrays(pose: &Array<f32>, opening: &Array<f32>) -> Result<Vec<Vec<ActionChunk>>, String> {
    let [episodes, seeds, horizon] = check(pose, opening)?;
    let action = |at: usize| {
        let world_from_gripper = pose_at(&pose.data, at)
            .map_err(|fault| format!("`pose`{} {fault}", describe_index(&[episodes, seeds, horizon], at)))?;
        Ok(Action { world_from_gripper, opening: f64::from(opening.data[at]) })
    };
    let chunk = |chunk: usize| {
        let actions = (chunk * horizon..(chunk + 1) * horizon).map(action);
        actions.collect::<Result<Vec<_>, String>>().map(ActionChunk)
    };
    (0..episodes).map(|episode| (episode * seeds..(episode + 1) * seeds).map(chunk).collect()).collect()
}

fn arrays_from_chunks(chunks: &[Vec<ActionChunk>]) -> Result<(Array<f32>, Array<f32>), String> {
    let seeds = chunks.first().map_or(0, Vec::len);
    let horizon = chunks.first().and_then(|seeds| seeds.first()).map_or(0, ActionChunk::len);
    let shape = vec![chunks.len(), seeds, horizon];
    let mut pose = Array { shape: [&shape[..], &[4, 4]].concat(), data: Vec::new() };
    let mut opening = Array { shape, data: Vec::new() };
    for (index, of_episode) in chunks.iter().enumerate() {
        if of_episode.len() != seeds {
            return Err(format!(
                "episode {index} has {} predictions, expected S = {seeds}",
                of_episode.len()
            ));
        }
        for (seed, chunk) in of_episode.iter().enumerate() {
            if chunk.len() != horizon {
                let got = chunk.len();
                return Err(format!(
                    "prediction [{index}, {seed}] has {got} actions, expected L = {horizon}"
                ));
            }
            for action in chunk.iter() {
                push_pose(&mut pose.data, &action.world_from_gripper);
                opening.data.push(action.opening as f32);
            }
        }
    }
    check(&pose, &opening)?;
    Ok((pose, opening))
}
