//! What a data set holds, in figures: for `inspect` and for reports.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::{DatasetFile, DatasetMeta};
use crate::{DataError, Window};

/// Whether the arrays are those that `meta.content_hash` was computed from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HashCheck {
    /// There is no hash to compare with.
    Absent,
    /// They are.
    Matches,
    /// They were changed after the hash was taken.
    Differs,
}

/// Where gripper poses lie.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PoseRange {
    /// Smallest position, world frame, metres.
    pub position_min_m: [f64; 3],
    /// Largest position, world frame, metres.
    pub position_max_m: [f64; 3],
    /// Largest angle of a rotation to the identity, radians.
    pub angle_max_rad: f64,
    /// Smallest and largest opening.
    pub opening: [f64; 2],
}

/// The figures of one data-set file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DatasetSummary {
    /// Episodes, E.
    pub episodes: usize,
    /// Action steps per episode, T.
    pub steps: usize,
    /// Points per frame, N.
    pub points: usize,
    /// Smallest coordinates of any point, world frame, metres.
    pub points_min_m: [f32; 3],
    /// Largest coordinates of any point, world frame, metres.
    pub points_max_m: [f32; 3],
    /// Reached poses and openings.
    pub gripper: PoseRange,
    /// Commanded poses and openings.
    pub action: PoseRange,
    /// The share of training targets that repeat the last action, at a horizon of T: (T − 1)/(2T).
    pub padded_share: f64,
    /// Whether every episode holds the poses of another expert too.
    pub has_alternative: bool,
    /// Episodes whose scene was disturbed.
    pub disturbed: usize,
    /// blake3 over the arrays, in hexadecimal.
    pub content_hash: String,
    /// How that compares with the provenance.
    pub hash_check: HashCheck,
    /// The provenance, where the file has it.
    pub meta: Option<DatasetMeta>,
    /// Why the file's provenance was ignored, where it was.
    pub meta_fault: Option<String>,
}

impl DatasetSummary {
    /// Reads a data set and sums it up.
    ///
    /// # Errors
    /// As [`Dataset::read`](crate::Dataset::read).
    pub fn read(path: impl AsRef<Path>) -> Result<Self, DataError> {
        Ok(Self::of(&DatasetFile::read(path)?))
    }

    /// Sums up a data set that was read from a file.
    pub fn of(file: &DatasetFile) -> Self {
        let dataset = &file.dataset;
        let observations = || dataset.episodes.iter().flat_map(|episode| &episode.observations);
        let actions = || dataset.episodes.iter().flat_map(|episode| &episode.actions);
        let positions = || observations().flat_map(|observation| &observation.cloud.points);
        let fold = |start: f32, choose: fn(f32, f32) -> f32| {
            positions().fold([start; 3], |bound, point| std::array::from_fn(|i| choose(bound[i], point[i])))
        };
        let stored_hash = dataset.meta.as_ref().and_then(|meta| meta.content_hash.as_ref());
        let hash_check = match stored_hash {
            None => HashCheck::Absent,
            Some(stored) if *stored == file.content_hash => HashCheck::Matches,
            Some(_) => HashCheck::Differs,
        };
        Self {
            episodes: dataset.len(),
            steps: dataset.steps(),
            points: dataset.points(),
            points_min_m: fold(f32::INFINITY, f32::min),
            points_max_m: fold(f32::NEG_INFINITY, f32::max),
            gripper: PoseRange::of(observations().map(|o| (&o.world_from_gripper, o.gripper_opening))),
            action: PoseRange::of(actions().map(|a| (&a.world_from_gripper, a.opening))),
            padded_share: padded_share(file),
            has_alternative: dataset.episodes.iter().all(|episode| episode.alternative.is_some()),
            disturbed: dataset.episodes.iter().filter(|episode| episode.disturbance.is_some()).count(),
            content_hash: file.content_hash.clone(),
            hash_check,
            meta: dataset.meta.clone(),
            meta_fault: file.meta_fault.clone(),
        }
    }
}

impl PoseRange {
    fn of<'a>(poses: impl Iterator<Item = (&'a reseflow_lie::SE3, f64)>) -> Self {
        let start = Self {
            position_min_m: [f64::INFINITY; 3],
            position_max_m: [f64::NEG_INFINITY; 3],
            angle_max_rad: 0.0,
            opening: [f64::INFINITY, f64::NEG_INFINITY],
        };
        poses.fold(start, |range, (pose, opening)| Self {
            position_min_m: std::array::from_fn(|i| range.position_min_m[i].min(pose.translation[i])),
            position_max_m: std::array::from_fn(|i| range.position_max_m[i].max(pose.translation[i])),
            angle_max_rad: range.angle_max_rad.max(pose.rotation.angle()),
            opening: [range.opening[0].min(opening), range.opening[1].max(opening)],
        })
    }
}

fn padded_share(file: &DatasetFile) -> f64 {
    let episodes = &file.dataset.episodes;
    let horizon = file.dataset.steps();
    let targets = || Window::all(episodes).into_iter().flat_map(|window| window.targets(episodes, horizon));
    let padded = targets().filter(|target| target.padded).count();
    padded as f64 / targets().count().max(1) as f64
}
