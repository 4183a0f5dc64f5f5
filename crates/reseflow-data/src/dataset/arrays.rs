//! A data set as it lies in the file: six flat arrays and up to two optional ones, and the way to episodes and back.

use std::io::{self, Seek, Write};

use super::disturbance;
use super::extents::{Axis, check_finite, check_openings, check_shape, describe_index, leading_extents};
use super::pose_array::{pose_at, push_pose};
use crate::npz::{Array, Element, NpzReader, NpzWriter};
use crate::{Action, DataError, Episode, Observation, PointCloud};

/// E episodes, T steps, N points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Extents {
    episodes: usize,
    steps: usize,
    points: usize,
}

/// The arrays in the order in which they are written and hashed.
pub(super) struct DatasetArrays {
    points: Array<f32>,
    rgb: Array<u8>,
    gripper_pose: Array<f32>,
    gripper_opening: Array<f32>,
    action_pose: Array<f32>,
    action_opening: Array<f32>,
    /// Older files, and most tasks, do not have it.
    action_pose_alt: Option<Array<f32>>,
    /// For each episode the step before which it was disturbed and the one from which that was answered; both 0 where it was not.
    disturbed: Option<Array<i32>>,
}

impl DatasetArrays {
    /// Reads the arrays; their shapes are unchecked.
    pub(super) fn read(npz: &mut NpzReader) -> Result<Self, DataError> {
        let action_pose_alt =
            if npz.contains("action_pose_alt") { Some(npz.array("action_pose_alt")?) } else { None };
        let disturbed = if npz.contains("disturbed") { Some(npz.array("disturbed")?) } else { None };
        Ok(Self {
            points: npz.array("points")?,
            rgb: npz.array("rgb")?,
            gripper_pose: npz.array("gripper_pose")?,
            gripper_opening: npz.array("gripper_opening")?,
            action_pose: npz.array("action_pose")?,
            action_opening: npz.array("action_opening")?,
            action_pose_alt,
            disturbed,
        })
    }

    pub(super) fn write<W: Write + Seek>(&self, npz: &mut NpzWriter<W>) -> io::Result<()> {
        npz.array("points", &self.points)?;
        npz.array("rgb", &self.rgb)?;
        npz.array("gripper_pose", &self.gripper_pose)?;
        npz.array("gripper_opening", &self.gripper_opening)?;
        npz.array("action_pose", &self.action_pose)?;
        npz.array("action_opening", &self.action_opening)?;
        self.action_pose_alt.as_ref().map_or(Ok(()), |array| npz.array("action_pose_alt", array))?;
        self.disturbed.as_ref().map_or(Ok(()), |array| npz.array("disturbed", array))
    }

    /// blake3 over every array's name, type, shape and little-endian elements, in hexadecimal.
    pub(super) fn hash(&self) -> String {
        let mut hasher = blake3::Hasher::new_derive_key("reseflow data set arrays v1");
        hash_array(&mut hasher, "points", &self.points);
        hash_array(&mut hasher, "rgb", &self.rgb);
        hash_array(&mut hasher, "gripper_pose", &self.gripper_pose);
        hash_array(&mut hasher, "gripper_opening", &self.gripper_opening);
        hash_array(&mut hasher, "action_pose", &self.action_pose);
        hash_array(&mut hasher, "action_opening", &self.action_opening);
        if let Some(array) = &self.action_pose_alt {
            hash_array(&mut hasher, "action_pose_alt", array);
        }
        if let Some(array) = &self.disturbed {
            hash_array(&mut hasher, "disturbed", array);
        }
        hasher.finalize().to_hex().to_string()
    }

    /// Checks shapes, that every number is finite, and the openings. Whether matrices are rigid shows in the conversion.
    pub(super) fn check(&self) -> Result<Extents, String> {
        let [episodes, steps, points] =
            leading_extents("points", &self.points, ["E (episodes)", "T (steps)", "N (points)"], &[3])?;
        let (e, t, n) = (Axis::Shared("E", episodes), Axis::Shared("T", steps), Axis::Shared("N", points));
        let matrix = [e, t, Axis::Fixed(4), Axis::Fixed(4)];
        check_shape("rgb", &self.rgb, &[e, t, n, Axis::Fixed(3)], "points")?;
        check_shape("gripper_pose", &self.gripper_pose, &matrix, "points")?;
        check_shape("gripper_opening", &self.gripper_opening, &[e, t], "points")?;
        check_shape("action_pose", &self.action_pose, &matrix, "points")?;
        check_shape("action_opening", &self.action_opening, &[e, t], "points")?;
        check_finite("points", &self.points)?;
        check_finite("gripper_pose", &self.gripper_pose)?;
        check_finite("action_pose", &self.action_pose)?;
        if let Some(array) = &self.action_pose_alt {
            check_shape("action_pose_alt", array, &matrix, "points")?;
            check_finite("action_pose_alt", array)?;
        }
        if let Some(array) = &self.disturbed {
            check_shape("disturbed", array, &[e, Axis::Fixed(2)], "points")?;
            disturbance::check(&array.data, steps)?;
        }
        check_openings("gripper_opening", &self.gripper_opening)?;
        check_openings("action_opening", &self.action_opening)?;
        Ok(Extents { episodes, steps, points })
    }

    /// Cuts arrays of the given, checked extents into episodes.
    pub(super) fn into_episodes(self, extents: Extents) -> Result<Vec<Episode>, String> {
        let Extents { episodes, steps, points } = extents;
        let (positions, _) = self.points.data.as_chunks::<3>();
        let (colors, _) = self.rgb.data.as_chunks::<3>();
        let pose = |name: &str, array: &Array<f32>, at: usize| {
            pose_at(&array.data, at)
                .map_err(|fault| format!("`{name}`{} {fault}", describe_index(&[episodes, steps], at)))
        };
        let episode = |episode: usize| {
            let frames = episode * steps..(episode + 1) * steps;
            let observations = frames.clone().map(|frame| {
                let cloud = frame * points..(frame + 1) * points;
                Ok(Observation {
                    cloud: PointCloud {
                        points: positions[cloud.clone()].to_vec(),
                        colors: colors[cloud].to_vec(),
                    },
                    world_from_gripper: pose("gripper_pose", &self.gripper_pose, frame)?,
                    gripper_opening: f64::from(self.gripper_opening.data[frame]),
                })
            });
            let observations = observations.collect::<Result<_, String>>()?;
            let alternative = |array: &Array<f32>| {
                frames
                    .clone()
                    .map(|frame| pose("action_pose_alt", array, frame))
                    .collect::<Result<_, String>>()
            };
            let alternative = self.action_pose_alt.as_ref().map(alternative).transpose()?;
            let actions = frames.map(|frame| {
                Ok(Action {
                    world_from_gripper: pose("action_pose", &self.action_pose, frame)?,
                    opening: f64::from(self.action_opening.data[frame]),
                })
            });
            let disturbance =
                self.disturbed.as_ref().and_then(|array| disturbance::of_episode(&array.data, episode));
            Ok(Episode {
                observations,
                actions: actions.collect::<Result<_, String>>()?,
                alternative,
                disturbance,
            })
        };
        (0..episodes).map(episode).collect()
    }

    /// Lays episodes out as arrays; they must agree on T and N.
    pub(super) fn from_episodes(episodes: &[Episode]) -> Result<Self, String> {
        let first = episodes.first().ok_or("holds no episode, expected at least 1")?;
        let steps = first.actions.len();
        let points = first.observations.first().map_or(0, |observation| observation.cloud.len());
        let count = episodes.len();
        let empty = |shape: &[usize]| Array {
            data: Vec::with_capacity(shape.iter().product()),
            shape: shape.to_vec(),
        };
        let mut arrays = Self {
            points: empty(&[count, steps, points, 3]),
            rgb: Array {
                shape: vec![count, steps, points, 3],
                data: Vec::with_capacity(count * steps * points * 3),
            },
            gripper_pose: empty(&[count, steps, 4, 4]),
            gripper_opening: empty(&[count, steps]),
            action_pose: empty(&[count, steps, 4, 4]),
            action_opening: empty(&[count, steps]),
            action_pose_alt: first.alternative.is_some().then(|| empty(&[count, steps, 4, 4])),
            disturbed: disturbance::array(episodes),
        };
        for (index, episode) in episodes.iter().enumerate() {
            arrays.push(episode, steps, points).map_err(|fault| format!("episode {index} {fault}"))?;
        }
        Ok(arrays)
    }

    fn push(&mut self, episode: &Episode, steps: usize, points: usize) -> Result<(), String> {
        let (frames, actions) = (episode.observations.len(), episode.actions.len());
        if frames != steps || actions != steps {
            return Err(format!(
                "has {frames} observations and {actions} actions, expected T = {steps} of each"
            ));
        }
        for (step, observation) in episode.observations.iter().enumerate() {
            let cloud = &observation.cloud;
            if cloud.points.len() != points || cloud.colors.len() != points {
                let (got, colors) = (cloud.points.len(), cloud.colors.len());
                return Err(format!(
                    "has {got} points and {colors} colours at step {step}, expected N = {points} of each"
                ));
            }
            self.points.data.extend_from_slice(cloud.points.as_flattened());
            self.rgb.data.extend_from_slice(cloud.colors.as_flattened());
            push_pose(&mut self.gripper_pose.data, &observation.world_from_gripper);
            self.gripper_opening.data.push(observation.gripper_opening as f32);
        }
        for action in &episode.actions {
            push_pose(&mut self.action_pose.data, &action.world_from_gripper);
            self.action_opening.data.push(action.opening as f32);
        }
        match (&mut self.action_pose_alt, &episode.alternative) {
            (None, None) => Ok(()),
            (Some(array), Some(poses)) if poses.len() == steps => {
                poses.iter().for_each(|pose| push_pose(&mut array.data, pose));
                Ok(())
            }
            (Some(_), Some(poses)) => {
                Err(format!("has {} alternative poses, expected T = {steps}", poses.len()))
            }
            (Some(_), None) => Err("has no alternative poses, unlike the first".to_owned()),
            (None, Some(_)) => Err("has alternative poses, unlike the first".to_owned()),
        }
    }
}

fn hash_array<T: Element>(hasher: &mut blake3::Hasher, name: &str, array: &Array<T>) {
    for text in [name, T::DESCR] {
        hasher.update(&(text.len() as u64).to_le_bytes());
        hasher.update(text.as_bytes());
    }
    hasher.update(&(array.shape.len() as u64).to_le_bytes());
    for &extent in &array.shape {
        hasher.update(&(extent as u64).to_le_bytes());
    }
    array.for_each_batch(|bytes| {
        hasher.update(bytes);
    });
}
