//! What runs left in their folders, read and sorted.

use std::path::{Path, PathBuf};

use reseflow_train::{AdaptiveConfig, Solver, WEIGHTS};
use serde::de::DeserializeOwned;
use serde_json::Value;

use super::shipped;
use crate::error::bad_input;
use crate::evaluation::{EvalReport, LatencyReport, LatencyRow, SamplersReport};
use crate::learners::Learner;
use crate::pipeline::Layout;
use crate::provenance::{Provenance, content_hash};
use crate::rollouts::RolloutReport;

/// A policy's scores on recorded episodes.
#[derive(Debug)]
pub(super) struct Eval {
    pub(super) learner: Learner,
    pub(super) split: String,
    pub(super) report: EvalReport,
}

impl Eval {
    /// Puts what single plans took beside what they scored, as far as the weights in `checkpoint` are those that were timed.
    fn take_times(&mut self, timed: &LatencyReport, checkpoint: &Path) {
        let weights = content_hash(&checkpoint.join(WEIGHTS)).ok();
        let name = self.learner.shipped_name();
        let times = timed.rows.iter().filter(|row| row.policy == name);
        let times: Vec<_> =
            times.filter(|row| weights.as_ref().is_none_or(|weights| *weights == row.weights)).collect();
        for row in &mut self.report.rows {
            // A solver that chooses its steps takes more for some scenes than for others, and has one row.
            let chooses = row.solver == Solver::DormandPrince(AdaptiveConfig::default()).name();
            let same =
                |time: &&&LatencyRow| time.solver == row.solver && (chooses || time.steps == row.steps);
            row.latency = times.iter().find(same).map(|time| time.latency.clone()).or(row.latency.take());
        }
    }
}

/// A policy acting in the simulator.
#[derive(Debug)]
pub(super) struct Acting {
    pub(super) learner: Learner,
    pub(super) report: RolloutReport,
}

/// A run's folder.
#[derive(Debug)]
pub(super) struct Run {
    pub(super) folder: PathBuf,
    pub(super) name: String,
    pub(super) task: String,
    /// What sets it apart from the main method, where it is an ablation.
    pub(super) variant: Option<String>,
    /// Training demonstrations, where the configuration says.
    pub(super) demonstrations: Option<usize>,
    /// The seed of Flow 1's training, where a configuration says.
    pub(super) training_seed: Option<u64>,
    /// Whether its policies ship, and were not trained in it.
    pub(super) shipped: bool,
    /// The resolved configuration as it stands in its file.
    pub(super) config: Option<String>,
    pub(super) evals: Vec<Eval>,
    pub(super) acting: Vec<Acting>,
    /// What timed single plans, where that was done apart from scoring.
    pub(super) timed_with: Option<Provenance>,
    /// Solvers at equal cost.
    pub(super) samplers: Option<SamplersReport>,
    /// The names of stages and the seconds that they took.
    pub(super) stages: Vec<(String, f64)>,
    /// What is not there, a sentence each.
    pub(super) missing: Vec<String>,
}

impl Run {
    /// Reads the folder.
    ///
    /// # Errors
    /// Bad input: there is no such folder, it holds neither a configuration nor a result, or a file in it is broken.
    pub(super) fn read(folder: &Path) -> anyhow::Result<Self> {
        let place = folder.display();
        if !folder.is_dir() {
            return Err(bad_input(format!(
                "{place}: there is no such folder, expected one that `reseflow run` made"
            )));
        }
        let config = text(&folder.join("config.toml"))?;
        let settings = match &config {
            Some(text) => text.parse::<toml::Table>().map_err(|fault| {
                let reason = fault.message().to_owned();
                bad_input(format!("{place}/config.toml: not a configuration: {reason}"))
            })?,
            None => toml::Table::new(),
        };
        let stages = stages(folder)?;
        let (mut evals, mut acting, mut samplers) = (Vec::new(), Vec::new(), None);
        for (name, path) in results(folder)? {
            // What an earlier configuration left is not this run's.
            if !stages.is_empty() && !stages.iter().any(|(stage, _)| *stage == name) {
                continue;
            }
            let words: Vec<&str> = name.split('-').collect();
            match words[0] {
                "eval" => {
                    let report: EvalReport = json(&path)?;
                    if report.rows.is_empty() {
                        return Err(bad_input(format!(
                            "{}: `rows` is empty, expected scores",
                            path.display()
                        )));
                    }
                    let learner = learner_of(&words, &report.checkpoint, &report.config);
                    let named = ["wide", "turned"].into_iter().find(|split| words.contains(split));
                    let split = named.map(str::to_owned).or(report.split.map(|split| split.to_string()));
                    evals.push(Eval { learner, split: split.unwrap_or_else(|| "test".to_owned()), report });
                }
                "rollout" => {
                    let report: RolloutReport = json(&path)?;
                    acting
                        .push(Acting { learner: learner_of(&words, &report.policy, &report.config), report });
                }
                "samplers" => samplers = Some(json(&path)?),
                _ => {}
            }
        }
        let layout = Layout::new(folder.to_owned());
        let mut timed_with = None;
        if layout.latency().exists() {
            let timed: LatencyReport = json(&layout.latency())?;
            for eval in evals.iter_mut().filter(|eval| eval.split == "test") {
                eval.take_times(&timed, &layout.checkpoint(eval.learner));
            }
            timed_with = Some(timed.provenance);
        }
        evals.sort_by_key(|eval| {
            (rank(eval.learner), ["test", "wide"].iter().position(|s| *s == eval.split).unwrap_or(2))
        });
        acting.sort_by_key(|acting| rank(acting.learner));
        if config.is_none() && evals.is_empty() && acting.is_empty() {
            return Err(bad_input(format!(
                "{place}: holds neither config.toml nor a result, expected a folder that `reseflow run` made"
            )));
        }
        let word = |key: &str| settings.get(key).and_then(|value| value.as_str()).map(str::to_owned);
        let told = evals.iter().find_map(|eval| eval.report.task.clone());
        let told = told.or_else(|| acting.first().map(|acting| acting.report.task.clone()));
        let file_name = folder.file_name().map(|name| name.to_string_lossy().into_owned());
        // Policies that were not trained here learned from whatever their card says.
        let shipped = settings.get("pretrained").and_then(|given| given.as_str());
        let (demonstrations, training_seed) = match shipped {
            Some(given) => {
                let card = shipped::card(folder, given)?;
                (card.as_ref().and_then(|card| card.demonstrations), card.and_then(|card| card.seed))
            }
            None => {
                let number = |table: &str, key: &str| settings.get(table)?.get(key)?.as_integer();
                let count = number("data", "train_episodes").and_then(|count| usize::try_from(count).ok());
                (count, number("train", "seed").and_then(|seed| u64::try_from(seed).ok()))
            }
        };
        let mut run = Self {
            folder: folder.to_owned(),
            name: word("name").or(file_name).unwrap_or_else(|| "run".to_owned()),
            task: word("task").or(told).unwrap_or_else(|| "unknown task".to_owned()),
            variant: word("variant"),
            demonstrations,
            training_seed,
            shipped: shipped.is_some(),
            config,
            evals,
            acting,
            timed_with,
            samplers,
            stages,
            missing: Vec::new(),
        };
        run.note_missing(&settings);
        Ok(run)
    }

    /// The scores of `learner` on the test split.
    pub(super) fn on_test(&self, learner: Learner) -> Option<&EvalReport> {
        let found = self.evals.iter().find(|eval| eval.learner == learner && eval.split == "test");
        found.map(|eval| &eval.report)
    }

    /// What scored it.
    pub(super) fn provenance(&self) -> Option<&Provenance> {
        let eval = self.evals.first().map(|eval| &eval.report.provenance);
        eval.or(self.acting.first().map(|acting| &acting.report.provenance))
    }

    /// Whether episodes have two experts, so that the distance to one of them says little.
    pub(super) fn has_modes(&self) -> bool {
        self.evals.iter().any(|eval| eval.report.rows.iter().any(|row| row.modes.is_some()))
    }

    /// The path of something in the folder, where it is there.
    pub(super) fn find(&self, name: &str) -> Option<PathBuf> {
        Some(self.folder.join(name)).filter(|path| path.exists())
    }

    /// The folder of a policy: the run's own, or the one that its evaluation names.
    pub(super) fn checkpoint(&self, learner: Learner) -> Option<PathBuf> {
        let named =
            || Some(PathBuf::from(&self.on_test(learner)?.checkpoint)).filter(|folder| folder.is_dir());
        let trained =
            self.stages.is_empty() || self.stages.iter().any(|(name, _)| *name == learner.name("train"));
        trained.then(|| self.find(&learner.name("checkpoint"))).flatten().or_else(named)
    }

    /// Flow 2 and the baseline are missed only where the configuration has them.
    fn note_missing(&mut self, settings: &toml::Table) {
        let trained_none = self.shipped || self.config.is_none();
        let asked = |table: &str| trained_none || settings.contains_key(table);
        let wanted = [
            (self.config.is_some(), "config.toml"),
            (!self.stages.is_empty(), "summary.json"),
            (!self.evals.is_empty(), "eval.json"),
            (
                !asked("reflow") || self.evals.iter().any(|eval| matches!(eval.learner, Learner::Flow(2..))),
                "eval-2.json (Flow 2)",
            ),
            (
                !asked("baseline") || self.evals.iter().any(|eval| eval.learner == Learner::Baseline),
                "eval-baseline.json (ET-SEED)",
            ),
            (!self.acting.is_empty(), "rollout.json"),
            (self.find("data/train.npz").is_some(), "data/train.npz"),
            (self.find("data/test.npz").is_some(), "data/test.npz"),
        ];
        let absent: Vec<&str> =
            wanted.into_iter().filter(|(there, _)| !there).map(|(_, name)| name).collect();
        if !absent.is_empty() {
            self.missing.push(format!(
                "{}: there is no {}; what needs it is left out.",
                self.name,
                absent.join(", ")
            ));
        }
    }
}

/// The order of policies: flows, the baseline, the regressor.
fn rank(learner: Learner) -> usize {
    match learner {
        Learner::Flow(flow) => flow,
        Learner::Baseline => 1000,
        Learner::Regressor => 1001,
    }
}

/// Whose result it is: by the kind in the checkpoint's configuration; a flow's number stands in the file's name or the checkpoint's.
fn learner_of(words: &[&str], checkpoint: &str, config: &Value) -> Learner {
    if config["kind"] == "et_seed" || words.contains(&"baseline") {
        return Learner::Baseline;
    }
    if config["model"]["regression"] == true || words.contains(&"regressor") {
        return Learner::Regressor;
    }
    let number = |word: &str| {
        word.trim_start_matches("flow").parse::<usize>().ok().filter(|number| (1..10).contains(number))
    };
    let checkpoint = checkpoint.rsplit('/').next().unwrap_or_default();
    let of_checkpoint =
        || checkpoint.strip_prefix("checkpoint-").or(checkpoint.strip_prefix("flow")).and_then(number);
    let last = words.last().filter(|_| words.len() > 1);
    Learner::Flow(last.and_then(|word| number(word)).or_else(of_checkpoint).unwrap_or(1))
}

/// The JSON files of results in a folder, by name without ending.
fn results(folder: &Path) -> anyhow::Result<Vec<(String, PathBuf)>> {
    let unreadable = |fault: std::io::Error| bad_input(format!("{}: {fault}", folder.display()));
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        let name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        if path.extension().is_some_and(|ending| ending == "json") {
            found.push((name, path));
        }
    }
    found.sort();
    Ok(found)
}

/// The stages that `summary.json` tells of.
fn stages(folder: &Path) -> anyhow::Result<Vec<(String, f64)>> {
    let path = folder.join("summary.json");
    if !path.exists() {
        return Ok(Vec::new());
    }
    let summary: Value = json(&path)?;
    let stage = |stage: &Value| Some((stage["name"].as_str()?.to_owned(), stage["secs"].as_f64()?));
    Ok(summary["stages"]
        .as_array()
        .map(|stages| stages.iter().filter_map(stage).collect())
        .unwrap_or_default())
}

/// The text of a file; `None` where there is none.
pub(super) fn text(path: &Path) -> anyhow::Result<Option<String>> {
    match std::fs::read_to_string(path) {
        Ok(text) => Ok(Some(text)),
        Err(fault) if fault.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(fault) => Err(bad_input(format!("{}: {fault}", path.display()))),
    }
}

/// The value in a JSON file.
pub(super) fn json<T: DeserializeOwned>(path: &Path) -> anyhow::Result<T> {
    let text = text(path)?.unwrap_or_default();
    let mut reader = serde_json::Deserializer::from_str(&text);
    serde_path_to_error::deserialize(&mut reader).map_err(|fault| {
        let place = match fault.path().to_string().as_str() {
            "." => String::new(),
            key => format!("`{key}`: "),
        };
        bad_input(format!("{}: {place}{}", path.display(), fault.inner()))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_result_belongs_to_the_policy_that_its_configuration_and_names_tell() {
        let flow = json!({"kind": "flow", "model": {"regression": false}});
        let of = |name: &str, checkpoint: &str, config: &Value| {
            learner_of(&name.split('-').collect::<Vec<_>>(), checkpoint, config)
        };
        assert_eq!(of("eval", "runs/a/checkpoint", &flow), Learner::Flow(1));
        assert_eq!(of("eval-2", "runs/a/checkpoint-2", &flow), Learner::Flow(2));
        assert_eq!(of("eval-wide-3", "elsewhere", &flow), Learner::Flow(3));
        assert_eq!(of("rollout", "runs/a-1999/checkpoint-2", &flow), Learner::Flow(2), "the last flow acts");
        assert_eq!(of("eval", "runs/door-5", &flow), Learner::Flow(1), "a run's number is no flow's");
        assert_eq!(of("eval", "assets/pretrained/door/flow2", &flow), Learner::Flow(2));
        assert_eq!(of("rollout-flow1", "runs/a/checkpoint", &flow), Learner::Flow(1));
        assert_eq!(of("eval", "x", &json!({"kind": "et_seed"})), Learner::Baseline);
        assert_eq!(
            of("eval", "x", &json!({"kind": "flow", "model": {"regression": true}})),
            Learner::Regressor
        );
    }
}
