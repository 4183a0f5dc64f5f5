//! The stages that make a run's policies: by training them, or by taking those that ship.

use std::path::{Path, PathBuf};

use anyhow::Context as _;
use reseflow_data::{Dataset, DatasetFile, PairSet, TrainingNotes, write_training_log};
use reseflow_train::{ReflowConfig, Resume};
use serde_json::{Value, json};

use super::stages::{Context, Stage};
use crate::error::bad_input;
use crate::learners::{Learner, Training};
use crate::learning::find_policies;
use crate::plot::training_curve;
use crate::provenance::content_hash;
use crate::reflow::Round;

/// A policy and the hash of the stage that made it.
pub(super) type Made = (Learner, String);

impl Context<'_> {
    /// The policies that ship, where the configuration asks for them, each with its folder.
    ///
    /// # Errors
    /// Bad input: one of them is not there.
    pub(super) fn shipped(&self) -> anyhow::Result<Option<Vec<(Learner, PathBuf)>>> {
        let Some(given) = &self.config.pretrained else { return Ok(None) };
        let folder = find_policies(given)?;
        let found = Learner::all(self.config).map(|learner| {
            let path = folder.join(learner.shipped_name());
            if path.is_dir() {
                return Ok((learner, path));
            }
            Err(bad_input(format!(
                "{}: there is no such folder, expected a shipped policy's",
                path.display()
            )))
        });
        found.collect::<anyhow::Result<_>>().map(Some)
    }

    /// Takes the policies that ship.
    pub(super) fn adopt(
        &self,
        stage: &mut Stage<'_>,
        shipped: &[(Learner, PathBuf)],
    ) -> anyhow::Result<Vec<Made>> {
        let mut policies = Vec::new();
        for (learner, from) in shipped {
            let inputs = json!(["shipped", content_hash(from).with_context(|| from.display().to_string())?]);
            let to = self.layout.checkpoint(*learner);
            let outputs = [to.clone()];
            let hash = stage(&learner.name("train"), inputs, &outputs, &mut || copy_folder(from, &to))?;
            policies.push((*learner, hash));
        }
        Ok(policies)
    }

    /// Trains every policy of the run; `train_data` and `validation_data` are the hashes of their stages.
    pub(super) fn learn(
        &self,
        stage: &mut Stage<'_>,
        train_data: &str,
        validation_data: Option<&str>,
    ) -> anyhow::Result<Vec<Made>> {
        let config = self.config;
        let inputs = json!([train_data, validation_data, config.model, config.train, config.device]);
        let mut learners = vec![(Learner::Flow(1), inputs.clone())];
        learners.extend(Learner::references(config).map(|reference| match reference {
            Learner::Baseline => (reference, json!([inputs, config.baseline])),
            _ => (reference, inputs.clone()),
        }));
        let mut policies = Vec::new();
        for (learner, inputs) in learners {
            let outputs = self.leaves(learner);
            let hash = stage(&learner.name("train"), inputs, &outputs, &mut || self.train(learner))?;
            policies.push((learner, hash));
        }
        let mut last = policies[0].1.clone();
        for (reflow, round) in
            config.reflow.iter().flat_map(|reflow| (1..=reflow.rounds).map(move |n| (reflow, n)))
        {
            let (learner, start) = (Learner::Flow(round + 1), last);
            let inputs = json!([start, train_data, reflow.pairs_of(round), config.device]);
            let work = &mut || self.pairs(reflow, round);
            let pairs = stage(&learner.name("pairs"), inputs, &[self.layout.pairs(round + 1)], work)?;

            let training = reflow.training(&config.train, round);
            let inputs =
                json!([start, pairs, train_data, validation_data, training, reflow.mixture, config.device]);
            let work = &mut || self.reflow(reflow, round);
            last = stage(&learner.name("train"), inputs, &self.leaves(learner), work)?;
            policies.push((learner, last.clone()));
        }
        Ok(policies)
    }

    /// Puts what the trainers noted into one log.
    pub(super) fn log_trainings(&self, learned: &[Made]) -> anyhow::Result<()> {
        let notes = |(learner, _): &Made| {
            let path = self.layout.metrics(*learner);
            let lines = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
            anyhow::Ok(TrainingNotes { name: learner.name("training"), lines })
        };
        let notes = learned.iter().map(notes).collect::<anyhow::Result<Vec<_>>>()?;
        Ok(write_training_log(self.layout.training_log(), &notes)?)
    }

    /// What a training leaves.
    fn leaves(&self, learner: Learner) -> [PathBuf; 2] {
        [self.layout.checkpoint(learner), self.layout.picture(&learner.name("training"))]
    }

    fn train(&self, learner: Learner) -> anyhow::Result<()> {
        let demonstrations = Dataset::read(self.layout.data("train"))?;
        let validation = self.validation()?;
        let training = Training {
            config: self.config,
            demonstrations: &demonstrations,
            validation: validation.as_ref(),
            out: &self.layout.checkpoint(learner),
            resume: self.resume(),
        };
        training.run(learner, self.terminal)?;
        self.draw_training(learner)
    }

    fn pairs(&self, reflow: &ReflowConfig, round: usize) -> anyhow::Result<()> {
        let data = DatasetFile::read(self.layout.data("train"))?;
        let (flow, checkpoint) = (round + 1, self.layout.checkpoint(Learner::Flow(round)));
        let round =
            Round { config: self.config, reflow, number: round, checkpoint: &checkpoint, data: &data };
        round.make_pairs(&self.layout.pairs(flow), self.terminal).map(drop)
    }

    fn reflow(&self, reflow: &ReflowConfig, round: usize) -> anyhow::Result<()> {
        let data = DatasetFile::read(self.layout.data("train"))?;
        let (flow, checkpoint) = (round + 1, self.layout.checkpoint(Learner::Flow(round)));
        let pairs = PairSet::read(self.layout.pairs(flow))?;
        let validation = self.validation()?;
        let round =
            Round { config: self.config, reflow, number: round, checkpoint: &checkpoint, data: &data };
        let out = self.layout.checkpoint(Learner::Flow(flow));
        round.train(&pairs, validation.as_ref(), &out, self.resume(), self.terminal)?;
        self.draw_training(Learner::Flow(flow))
    }

    fn validation(&self) -> anyhow::Result<Option<Dataset>> {
        let watch = self.config.data.validation_episodes > 0;
        Ok(watch.then(|| Dataset::read(self.layout.data("validation"))).transpose()?)
    }

    fn resume(&self) -> Resume {
        if self.fresh { Resume::Never } else { Resume::IfSame }
    }

    fn draw_training(&self, learner: Learner) -> anyhow::Result<()> {
        let metrics = std::fs::read_to_string(self.layout.metrics(learner))?;
        let curves = [("loss", curve(&metrics, "loss")), ("D_geo, validation", curve(&metrics, "d_geo"))];
        let title = format!("{}: {}", self.config.name, learner.name("training"));
        self.draw(&learner.name("training"), &training_curve(&title, &curves))
    }
}

/// Copies the files of a folder, whole or not at all.
fn copy_folder(from: &Path, to: &Path) -> anyhow::Result<()> {
    let about = || format!("copying {} to {}", from.display(), to.display());
    let around = to.parent().unwrap_or(Path::new("."));
    let beside = tempfile::tempdir_in(around).with_context(about)?;
    for entry in std::fs::read_dir(from).with_context(about)? {
        let entry = entry.with_context(about)?;
        if entry.path().is_file() {
            std::fs::copy(entry.path(), beside.path().join(entry.file_name())).with_context(about)?;
        }
    }
    if to.exists() {
        std::fs::remove_dir_all(to).with_context(about)?;
    }
    std::fs::rename(beside.keep(), to).with_context(about)
}

/// The points (`update`, `key`) of the lines that hold both.
fn curve(json_lines: &str, key: &str) -> Vec<(f64, f64)> {
    let point = |line: &str| -> Option<(f64, f64)> {
        let line: Value = serde_json::from_str(line).ok()?;
        Some((line.get("update")?.as_f64()?, line.get(key)?.as_f64()?))
    };
    json_lines.lines().filter_map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_are_read_from_the_lines_that_hold_them() {
        let lines = "{\"update\": 1, \"loss\": 2.5}\n{\"update\": 1, \"d_geo\": 0.5}\nhalf a li";
        assert_eq!(curve(lines, "loss"), [(1.0, 2.5)]);
        assert_eq!(curve(lines, "d_geo"), [(1.0, 0.5)]);
        assert!(curve(lines, "other").is_empty());
    }
}
