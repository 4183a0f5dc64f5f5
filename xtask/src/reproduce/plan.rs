//! The plan: which configurations run, and with which keys overridden.

use std::collections::BTreeSet;
use std::path::Path;

use anyhow::{Context, Result, bail};
use serde::Deserialize;

/// `configs/reproduce.toml`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Plan {
    /// The folder of the runs' folders.
    output: String,
    /// Overrides of every run.
    set: Vec<String>,
    /// The runs, in order.
    #[serde(rename = "experiment")]
    experiments: Vec<Experiment>,
}

/// One run.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Experiment {
    /// Its name, and its folder's.
    pub(super) name: String,
    /// The configuration.
    config: String,
    /// In which pipeline it runs.
    #[serde(default)]
    when: When,
    /// Overrides of its own, after those of every run.
    set: Vec<String>,
}

/// In which pipelines an experiment runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
enum When {
    /// Wherever something is trained.
    #[default]
    Always,
    /// Only where everything is.
    Full,
    /// Only where nothing is trained.
    Pretrained,
}

/// What is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Pipeline {
    /// The paper's benchmark: one training seed, no ablations.
    Usual,
    /// Everything that is trained.
    Full,
    /// The shipped policies.
    Pretrained,
}

impl Plan {
    /// Reads the plan.
    ///
    /// # Errors
    /// When it cannot be read, or two experiments have one name.
    pub(super) fn read(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
        Self::parse(&text).with_context(|| path.display().to_string())
    }

    fn parse(text: &str) -> Result<Self> {
        let plan: Self = toml::from_str(text)?;
        let mut names = BTreeSet::new();
        for experiment in &plan.experiments {
            if !names.insert(&experiment.name) {
                bail!("two experiments are called `{}`, and would share a folder", experiment.name);
            }
        }
        Ok(plan)
    }

    /// The experiments of a pipeline, in order.
    pub(super) fn of(&self, pipeline: Pipeline) -> Vec<&Experiment> {
        let belongs = |experiment: &&Experiment| match pipeline {
            Pipeline::Usual => experiment.when == When::Always,
            Pipeline::Full => experiment.when != When::Pretrained,
            Pipeline::Pretrained => experiment.when == When::Pretrained,
        };
        self.experiments.iter().filter(belongs).collect()
    }

    /// What follows `reseflow` in the call that runs `experiment`.
    pub(super) fn words(&self, experiment: &Experiment) -> Vec<String> {
        let mut words = vec!["run".to_owned(), experiment.config.clone()];
        let own = [format!("name={}", experiment.name), format!("output={}", self.output)];
        for set in own.iter().chain(&self.set).chain(&experiment.set) {
            words.extend(["--set".to_owned(), set.clone()]);
        }
        words
    }

    /// The folder of the runs' folders.
    pub(super) fn output(&self) -> &str {
        &self.output
    }

    /// The folder of the run, or of the report, called `name`.
    pub(super) fn folder(&self, name: &str) -> String {
        format!("{}/{name}", self.output)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspace;

    const SMALL: &str = r#"
output = "runs/r"
set = ["eval.seeds=10"]
[[experiment]]
name = "a"
config = "configs/a.toml"
set = ["eval.seeds=50"]
[[experiment]]
name = "b"
config = "configs/b.toml"
when = "full"
set = []
[[experiment]]
name = "c"
config = "configs/a.toml"
when = "pretrained"
set = ["pretrained=c"]
"#;

    #[test]
    fn an_experiments_own_overrides_come_last() {
        let plan = Plan::parse(SMALL).unwrap();
        let expected =
            "run configs/a.toml --set name=a --set output=runs/r --set eval.seeds=10 --set eval.seeds=50";
        assert_eq!(plan.words(plan.of(Pipeline::Usual)[0]).join(" "), expected);
    }

    #[test]
    fn each_pipeline_has_its_experiments() {
        let plan = Plan::parse(SMALL).unwrap();
        let names = |pipeline| {
            plan.of(pipeline).iter().map(|experiment| experiment.name.as_str()).collect::<String>()
        };
        assert_eq!(names(Pipeline::Usual), "a");
        assert_eq!(names(Pipeline::Full), "ab");
        assert_eq!(names(Pipeline::Pretrained), "c");
    }

    #[test]
    fn what_cannot_be_meant_is_refused() {
        let twice = SMALL.replace("name = \"b\"", "name = \"a\"");
        assert!(Plan::parse(&twice).unwrap_err().to_string().contains("called `a`"));
        assert!(Plan::parse(&SMALL.replace("when = \"full\"", "when = \"never\"")).is_err());
        assert!(Plan::parse(&SMALL.replace("when = \"full\"", "wen = \"full\"")).is_err());
    }

    #[test]
    fn the_plan_names_configurations_that_exist_and_every_pipeline_has_something_to_do() {
        let root = workspace::root();
        let plan = Plan::read(&root.join("configs/reproduce.toml")).unwrap();
        for experiment in &plan.experiments {
            assert!(root.join(&experiment.config).is_file(), "{}", experiment.config);
        }
        for pipeline in [Pipeline::Usual, Pipeline::Full, Pipeline::Pretrained] {
            let tasks = ["door", "painting", "triangle"];
            let has = |task: &&str| plan.of(pipeline).iter().any(|e| e.name.starts_with(*task));
            assert!(tasks.iter().all(has), "{pipeline:?}");
        }
        assert!(plan.of(Pipeline::Full).len() > plan.of(Pipeline::Usual).len());
    }
}
