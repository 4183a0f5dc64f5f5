//! What trainers noted, as a log whose curves a viewer plots; a second of the log is an update.
//!
//! | topic | schema | when |
//! |---|---|---|
//! | `/NAME/updates` | JSON | every update of the training NAME: `loss`, `learning_rate`, `gradient_norm`, `samples_per_sec` |
//! | `/NAME/validations` | JSON | every validation: `d_geo`, `rotation_rad`, `translation_m` |

use std::path::Path;

use serde_json::Value;

use super::file::{LogFile, Topic};
use crate::DataError;

/// A training's name, and its notes: one JSON object a line, each with its `update` and, but for validations, its `loss`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TrainingNotes {
    /// What its topics begin with.
    pub name: String,
    /// The lines.
    pub lines: String,
}

/// Writes the trainings' notes to the log `path`, in the order of the updates.
///
/// # Errors
/// [`DataError`] where a line is no such object or comes out of order, or where the file cannot be written; `path` then stays as it was.
pub fn write_training_log(path: impl AsRef<Path>, trainings: &[TrainingNotes]) -> Result<(), DataError> {
    let path = path.as_ref();
    let mut file = LogFile::create(path)?;
    let mut topics: Vec<Topic> = Vec::new();
    let mut messages: Vec<(i64, usize, Value)> = Vec::new();
    for TrainingNotes { name, lines } in trainings {
        let mut of_kind = [None; 2];
        for (index, line) in lines.lines().enumerate() {
            let note: Option<Value> = serde_json::from_str(line).ok();
            let update = note.as_ref().and_then(|note| note["update"].as_u64()?.try_into().ok());
            let (Some(note), Some(update)) = (note, update) else {
                let fault =
                    format!("line {} of {name} is `{line}`, expected an object with `update`", index + 1);
                return Err(DataError::invalid(path, fault));
            };
            let is_validation = note.get("loss").is_none();
            let topic = match of_kind[usize::from(is_validation)] {
                Some(topic) => topic,
                None => {
                    let (kind, schema) = if is_validation {
                        ("validations", "reseflow.Validation")
                    } else {
                        ("updates", "reseflow.Update")
                    };
                    let numbers: Vec<&str> =
                        note.as_object().into_iter().flatten().map(|(key, _)| key.as_str()).collect();
                    topics.push(file.add_json_topic(&format!("/{name}/{kind}"), schema, &numbers)?);
                    topics.len() - 1
                }
            };
            of_kind[usize::from(is_validation)] = Some(topic);
            messages.push((1_000_000_000_i64.saturating_mul(update), topic, note));
        }
    }
    messages.sort_by_key(|(nanos, ..)| *nanos);
    for (nanos, topic, note) in &messages {
        file.log_json(&mut topics[*topic], *nanos, note)?;
    }
    file.finish()
}
