//! A data set's provenance: the JSON text in `meta`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::{EpisodeKey, Split};

/// The version of the file's layout that this library writes.
pub const DATASET_VERSION: u32 = 1;

/// Where a data set comes from. Every field is optional on reading, and unknown ones are kept.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct DatasetMeta {
    /// The version of the file's layout.
    pub version: u32,
    /// The task's registered name.
    pub task: String,
    /// The split that the episodes were drawn for.
    pub split: Option<Split>,
    /// Each quantity's unit.
    pub units: BTreeMap<String, String>,
    /// What each array of poses and points is expressed in.
    pub frames: BTreeMap<String, String>,
    /// The key that each episode was drawn from, in the order of the arrays.
    pub seeds: Vec<EpisodeKey>,
    /// Attempts that were drawn and dropped because the expert did not succeed.
    pub attempts_dropped: u64,
    /// The physics engine and its version.
    pub engine: String,
    /// The task's resolved configuration.
    pub config: serde_json::Value,
    /// blake3 over the arrays, in hexadecimal; filled in on writing.
    pub content_hash: Option<String>,
    /// Whatever else the text holds.
    #[serde(flatten)]
    pub extra: BTreeMap<String, serde_json::Value>,
}

impl Default for DatasetMeta {
    fn default() -> Self {
        let table = |rows: &[(&str, &str)]| {
            rows.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect()
        };
        Self {
            version: DATASET_VERSION,
            task: String::new(),
            split: None,
            units: table(&[
                ("length", "metre"),
                ("angle", "radian"),
                ("time", "second"),
                ("opening", "0 closed to 1 open"),
            ]),
            frames: table(&[
                ("points", "world, right-handed, z up"),
                ("gripper_pose", "world_from_gripper, reached at the start of the action step"),
                ("action_pose", "world_from_gripper, commanded for the end of the action step"),
                ("action_pose_alt", "as action_pose, of another expert that is as good; not in every file"),
            ]),
            seeds: Vec::new(),
            attempts_dropped: 0,
            engine: String::new(),
            config: serde_json::Value::Null,
            content_hash: None,
            extra: BTreeMap::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknown_keys_survive_and_missing_ones_have_defaults() {
        let meta: DatasetMeta = serde_json::from_str(r#"{"task": "door", "robot": {"arm": 7}}"#).unwrap();
        assert_eq!((meta.task.as_str(), meta.version), ("door", DATASET_VERSION));
        assert_eq!(meta.extra["robot"]["arm"], 7);
        let text = serde_json::to_string(&meta).unwrap();
        assert_eq!(serde_json::from_str::<DatasetMeta>(&text).unwrap(), meta);
        assert!(serde_json::from_str::<DatasetMeta>("[1, 2]").is_err());
    }
}
