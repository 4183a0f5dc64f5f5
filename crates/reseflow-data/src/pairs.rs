//! The pair file of a reflow: noise drawn for training windows, and where a trained flow carried it.
//!
//! | array | type | shape | meaning |
//! |---|---|---|---|
//! | `window` | int32 | \[W, 2\] | the window's episode and action step in the data set |
//! | `noise_pose` | float32 | \[W, M, L, 4, 4\] | Z⁰, world frame |
//! | `noise_opening` | float32 | \[W, M, L\] | its openings, not confined to \[0, 1\] |
//! | `image_pose` | float32 | \[W, M, L, 4, 4\] | Z¹, where the flow carried Z⁰ |
//! | `image_opening` | float32 | \[W, M, L\] | its openings |
//! | `meta` | text | \[\] | JSON, see [`PairMeta`] |
//!
//! W windows, M noises each, horizon L; in one `.npz`.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::dataset::extents::{Axis, check_finite, check_shape, describe_index, leading_extents};
use crate::dataset::pose_array::{pose_at, push_pose};
use crate::npz::{Array, NpzReader, NpzWriter};
use crate::{Action, ActionChunk, DataError, Window, write_atomically};

/// Noise of one observation and where a flow carried it.
#[derive(Debug, Clone, PartialEq)]
pub struct FlowPair {
    /// Z⁰.
    pub noise: ActionChunk,
    /// Z¹.
    pub image: ActionChunk,
}

/// The pairs of one training window.
#[derive(Debug, Clone, PartialEq)]
pub struct WindowPairs {
    /// The window.
    pub window: Window,
    /// M pairs.
    pub pairs: Vec<FlowPair>,
}

/// Where pairs come from: whatever differs here makes other pairs.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct PairMeta {
    /// blake3 over the checkpoint of the flow, in hexadecimal.
    pub checkpoint_hash: String,
    /// The content hash of the data set that the windows are of.
    pub data_hash: String,
    /// How the flow was integrated, and the seed, numbers of windows and of noises.
    pub settings: serde_json::Value,
}

/// A pair file: W windows with M pairs each, all of the same horizon.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PairSet {
    /// The windows.
    pub windows: Vec<WindowPairs>,
    /// Where they come from.
    pub meta: PairMeta,
}

impl PairSet {
    /// Reads and checks a pair file; poses come back as the rotation nearest to the stored `float32` matrix.
    ///
    /// # Errors
    /// When the file is missing or damaged, or when an array or `meta` is missing or is not what it should be.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, DataError> {
        let path = path.as_ref();
        let invalid = |fault: String| DataError::invalid(path, fault);
        let mut npz = NpzReader::open(path)?;
        let arrays = Arrays {
            window: npz.array("window")?,
            noise_pose: npz.array("noise_pose")?,
            noise_opening: npz.array("noise_opening")?,
            image_pose: npz.array("image_pose")?,
            image_opening: npz.array("image_opening")?,
        };
        let windows = arrays.windows().map_err(invalid)?;
        if !npz.contains("meta") {
            return Err(invalid("has no `meta`, expected where the pairs come from".to_owned()));
        }
        let meta = serde_json::from_str(&npz.text("meta")?)
            .map_err(|fault| invalid(format!("`meta` is not the JSON that this program writes: {fault}")))?;
        Ok(Self { windows, meta })
    }

    /// Writes the file: whole or not at all, and the same bytes for the same pairs.
    ///
    /// # Errors
    /// When windows differ in M or chunks in L, when a number is not finite, or when the file cannot be written; what was there
    /// before then stays as it was.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), DataError> {
        let path = path.as_ref();
        let invalid = |fault: String| DataError::invalid(path, fault);
        let arrays = Arrays::new(&self.windows).map_err(invalid)?;
        let meta = serde_json::to_string(&self.meta)
            .map_err(|fault| invalid(format!("`meta` is no JSON: {fault}")))?;
        write_atomically(path, |file| {
            let mut npz = NpzWriter::new(file);
            npz.array("window", &arrays.window)?;
            npz.array("noise_pose", &arrays.noise_pose)?;
            npz.array("noise_opening", &arrays.noise_opening)?;
            npz.array("image_pose", &arrays.image_pose)?;
            npz.array("image_opening", &arrays.image_opening)?;
            npz.text("meta", &meta)?;
            npz.finish().map(drop)
        })
    }
}

/// The pairs as they lie in the file.
struct Arrays {
    window: Array<i32>,
    noise_pose: Array<f32>,
    noise_opening: Array<f32>,
    image_pose: Array<f32>,
    image_opening: Array<f32>,
}

impl Arrays {
    fn new(windows: &[WindowPairs]) -> Result<Self, String> {
        let noises = windows.first().map_or(0, |of| of.pairs.len());
        let horizon = windows.first().and_then(|of| of.pairs.first()).map_or(0, |pair| pair.noise.len());
        let shape = vec![windows.len(), noises, horizon];
        let pose = || Array { shape: [&shape[..], &[4, 4]].concat(), data: Vec::new() };
        let opening = || Array { shape: shape.clone(), data: Vec::new() };
        let mut arrays = Self {
            window: Array { shape: vec![windows.len(), 2], data: Vec::new() },
            noise_pose: pose(),
            noise_opening: opening(),
            image_pose: pose(),
            image_opening: opening(),
        };
        for (index, of) in windows.iter().enumerate() {
            if of.pairs.len() != noises {
                return Err(format!("window {index} has {} pairs, expected M = {noises}", of.pairs.len()));
            }
            for at in [of.window.episode, of.window.step] {
                let at = i32::try_from(at).map_err(|_| format!("window {index} lies at {at}, too far"))?;
                arrays.window.data.push(at);
            }
            for FlowPair { noise, image } in &of.pairs {
                for (chunk, pose, opening) in [
                    (noise, &mut arrays.noise_pose, &mut arrays.noise_opening),
                    (image, &mut arrays.image_pose, &mut arrays.image_opening),
                ] {
                    if chunk.len() != horizon {
                        let got = chunk.len();
                        return Err(format!("window {index} has {got} actions, expected L = {horizon}"));
                    }
                    for action in chunk.iter() {
                        push_pose(&mut pose.data, &action.world_from_gripper);
                        opening.data.push(action.opening as f32);
                    }
                }
            }
        }
        arrays.check()?;
        Ok(arrays)
    }

    fn check(&self) -> Result<[usize; 3], String> {
        let letters = ["W (windows)", "M (noises)", "L (horizon)"];
        let [w, m, l] = leading_extents("noise_pose", &self.noise_pose, letters, &[4, 4])?;
        let shared = [Axis::Shared("W", w), Axis::Shared("M", m), Axis::Shared("L", l)];
        let matrix = [shared[0], shared[1], shared[2], Axis::Fixed(4), Axis::Fixed(4)];
        check_shape("window", &self.window, &[shared[0], Axis::Fixed(2)], "noise_pose")?;
        check_shape("noise_opening", &self.noise_opening, &shared, "noise_pose")?;
        check_shape("image_pose", &self.image_pose, &matrix, "noise_pose")?;
        check_shape("image_opening", &self.image_opening, &shared, "noise_pose")?;
        check_finite("noise_pose", &self.noise_pose)?;
        check_finite("noise_opening", &self.noise_opening)?;
        check_finite("image_pose", &self.image_pose)?;
        check_finite("image_opening", &self.image_opening)?;
        if let Some(at) = self.window.data.iter().position(|index| *index < 0) {
            let index = describe_index(&self.window.shape, at);
            return Err(format!("`window`{index} is {}, expected 0 or more", self.window.data[at]));
        }
        Ok([w, m, l])
    }

    fn windows(&self) -> Result<Vec<WindowPairs>, String> {
        let [windows, noises, horizon] = self.check()?;
        let chunk = |name: &str, pose: &Array<f32>, opening: &Array<f32>, chunk: usize| {
            let action = |at: usize| {
                let world_from_gripper = pose_at(&pose.data, at).map_err(|fault| {
                    format!("`{name}`{} {fault}", describe_index(&[windows, noises, horizon], at))
                })?;
                Ok(Action { world_from_gripper, opening: f64::from(opening.data[at]) })
            };
            let actions = (chunk * horizon..(chunk + 1) * horizon).map(action);
            actions.collect::<Result<Vec<_>, String>>().map(ActionChunk)
        };
        let pair = |at: usize| {
            Ok(FlowPair {
                noise: chunk("noise_pose", &self.noise_pose, &self.noise_opening, at)?,
                image: chunk("image_pose", &self.image_pose, &self.image_opening, at)?,
            })
        };
        let of_window = |index: usize| {
            let at = |column: usize| self.window.data[2 * index + column] as usize;
            let pairs = (index * noises..(index + 1) * noises).map(pair);
            Ok(WindowPairs {
                window: Window { episode: at(0), step: at(1) },
                pairs: pairs.collect::<Result<_, String>>()?,
            })
        };
        (0..windows).map(of_window).collect()
    }
}
