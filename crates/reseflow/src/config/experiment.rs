//! The configuration of a whole experiment: what `reseflow run` does, and what `reseflow train` trains.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use reseflow_sim::CameraSettings;
use reseflow_train::{BaselineConfig, DeviceKind, ModelConfig, ReflowConfig, TrainConfig};

use super::counts::check_counts;
use super::{EvalConfig, RolloutSection, SamplersConfig};
use crate::learners::regressor;

/// An experiment on one task. Every key has a default.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ExperimentConfig {
    /// The run's name, and the name of its folder.
    pub name: String,
    /// What sets an ablation apart from the main method, in a few words (`twist`, `one node`). Reports show the run in a row of that
    /// name, and never let it stand for the main method; nothing else depends on it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub variant: Option<String>,
    /// The task's registered name.
    pub task: String,
    /// The folder that holds the run's folder.
    pub output: PathBuf,
    /// Where to compute.
    pub device: DeviceKind,
    /// A folder of trained policies (`flow1`, `flow2`, …, `etseed`, `regressor`), or the name of one that ships, to take instead of
    /// training: the tables `model`, `train`, `reflow` and `baseline` then only say which policies there are.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pretrained: Option<PathBuf>,
    /// The demonstrations.
    pub data: DataConfig,
    /// The network and the flow.
    pub model: ModelConfig,
    /// The optimisation.
    pub train: TrainConfig,
    /// How Flow 2 is made of Flow 1; without this table there is Flow 1 only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reflow: Option<ReflowConfig>,
    /// How the baseline is trained beside; without this table it is not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub baseline: Option<BaselineConfig>,
    /// Whether a deterministic regressor is trained beside, with Flow 1's network and settings.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub regressor: bool,
    /// The scoring on recorded episodes.
    pub eval: EvalConfig,
    /// Which solvers are compared on Flow 1 and the last flow; without this table none are.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub samplers: Option<SamplersConfig>,
    /// The rollouts in the simulator.
    pub rollout: RolloutSection,
}

/// How many demonstrations, and which.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DataConfig {
    /// Episodes to learn from.
    pub train_episodes: usize,
    /// Episodes to watch the training with.
    pub validation_episodes: usize,
    /// Episodes to report on.
    pub test_episodes: usize,
    /// The share of the episodes to learn from whose scene is disturbed meanwhile, so that they show how to begin anew.
    #[serde(skip_serializing_if = "is_zero")]
    pub disturbed_share: f64,
    /// The seed of all three; splits never share an episode.
    pub seed: u64,
    /// How the camera's frames are made, in the rollouts as well.
    #[serde(skip_serializing_if = "CameraSettings::is_default")]
    pub camera: CameraSettings,
}

impl Default for ExperimentConfig {
    fn default() -> Self {
        Self {
            name: "experiment".to_owned(),
            variant: None,
            task: "triangle".to_owned(),
            output: PathBuf::from("runs"),
            device: DeviceKind::default(),
            pretrained: None,
            data: DataConfig::default(),
            model: ModelConfig::default(),
            train: TrainConfig::default(),
            reflow: None,
            baseline: None,
            regressor: false,
            eval: EvalConfig::default(),
            samplers: None,
            rollout: RolloutSection::default(),
        }
    }
}

impl Default for DataConfig {
    fn default() -> Self {
        Self {
            train_episodes: 500,
            validation_episodes: 20,
            test_episodes: 50,
            disturbed_share: 0.0,
            seed: 1,
            camera: CameraSettings::default(),
        }
    }
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde's signature")]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

/// Whether `name` can be that of a folder, or a part of a file's, everywhere.
pub fn is_folder_name(name: &str) -> bool {
    let plain = |c: char| c.is_alphanumeric() || "-_.".contains(c);
    !name.is_empty() && !name.starts_with('.') && name.chars().all(plain)
}

impl ExperimentConfig {
    /// Checks what the types cannot say.
    ///
    /// # Errors
    /// A sentence that names the key, what was expected and what was got.
    pub fn validate(&self) -> Result<(), String> {
        check_counts(&[
            ("data.train_episodes", self.data.train_episodes),
            ("data.test_episodes", self.data.test_episodes),
        ])?;
        let share = self.data.disturbed_share;
        if !(0.0..=1.0).contains(&share) {
            return Err(format!("`data.disturbed_share` is {share}, expected a share from 0 to 1"));
        }
        self.eval.validate()?;
        self.rollout.validate()?;
        self.samplers.as_ref().map_or(Ok(()), SamplersConfig::validate)?;
        if self.output.as_os_str().is_empty() {
            return Err("`output` is empty, expected a folder, `.` for this one".to_owned());
        }
        if !is_folder_name(&self.name) {
            let name = &self.name;
            return Err(format!(
                "`name` is `{name}`, expected letters, digits, `-`, `_` and `.`: it names a folder"
            ));
        }
        if let Some(variant) = &self.variant
            && (variant.trim().is_empty() || variant.chars().any(char::is_control))
        {
            return Err(format!("`variant` is {variant:?}, expected a few words on one line"));
        }
        self.data.camera.validate().map_err(|fault| format!("`data.camera`: {fault}"))?;
        self.model.validate().map_err(|fault| fault.to_string())?;
        self.model.validate_training(&self.train).map_err(|fault| fault.to_string())?;
        if let Some(reflow) = &self.reflow {
            reflow.validate(&self.train).map_err(|fault| fault.to_string())?;
            let training = reflow.training(&self.train, 1);
            self.model
                .validate_training(&training)
                .map_err(|fault| format!("`reflow.objective`: {fault}"))?;
        }
        if let Some(baseline) = &self.baseline {
            baseline.validate(&self.model, &self.train).map_err(|fault| fault.to_string())?;
        }
        if self.regressor {
            let beside = regressor(&self.model).validate();
            beside.map_err(|fault| format!("`regressor` is true: {fault}"))?;
        }
        self.validate_combinations()
    }

    /// How many flows a run trains: Flow 1, and one for each round of reflow.
    pub fn flows(&self) -> usize {
        1 + self.reflow.as_ref().map_or(0, |reflow| reflow.rounds)
    }

    /// The run's folder.
    pub fn folder(&self) -> PathBuf {
        self.output.join(&self.name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{EVAL_STEPS, Override, SolverKind, load, parse};
    use reseflow_train::{Optimizer, PairConfig, Solver};

    /// What the paper says of data, training and sampling ("Training Configuration" and the figures over steps), capped at 50 000 and
    /// 30 000 updates, and everything that its table and figures compare.
    fn has_the_papers_protocol(config: &ExperimentConfig) {
        let (name, train) = (&config.name, &config.train);
        let reflow = config.reflow.as_ref().unwrap();
        let demonstrations = [("triangle", 500), ("door", 10), ("painting", 31)];
        assert!(demonstrations.contains(&(config.task.as_str(), config.data.train_episodes)), "{name}");
        let epochs = |count: usize, most: usize| most.min(count * config.data.train_episodes);
        assert_eq!((train.updates, reflow.updates), (epochs(5000, 50_000), epochs(3000, 30_000)), "{name}");
        assert_eq!((train.optimizer, train.learning_rate), (Optimizer::AdamW, 2e-4), "{name}");
        let of_flow_2 = reflow.training(train, 1);
        assert_eq!((train.batch_size, train.accumulate), (1, 1), "{name}");
        assert_eq!((of_flow_2.optimizer, of_flow_2.learning_rate), (Optimizer::AdamW, 8e-5), "{name}");
        assert_eq!((train.time.zero_share, of_flow_2.time.zero_share), (0.0, 0.0), "{name}");
        let mixed = toml::Table::try_from(reflow.mixture).unwrap();
        assert_eq!(mixed["coupling"].as_str(), Some("independent"), "{name}");
        assert_eq!((mixed["pair_share"].as_float(), reflow.rounds), (Some(0.5), 1), "{name}");
        let Solver::DormandPrince(adaptive) = reflow.pairs.solver else { panic!("{name}: {reflow:?}") };
        let enough = PairConfig::default().solver;
        assert!(
            matches!(enough, Solver::DormandPrince(own) if own.max_steps == adaptive.max_steps),
            "{name}"
        );
        let decoder = &config.model.network.decoder;
        assert_eq!(
            (decoder.horizon, decoder.frames, config.model.network.encoder.nodes),
            (10, 2, 4),
            "{name}"
        );
        let baseline = config.baseline.as_ref().unwrap();
        assert_eq!((baseline.diffusion.steps, baseline.learning_rate), (100, train.learning_rate), "{name}");
        assert_eq!((config.eval.steps.as_slice(), config.eval.seeds), (&EVAL_STEPS[..], 10), "{name}");
        assert_eq!((config.data.test_episodes, config.eval.splits.len()), (100, 3), "{name}");
        assert!(config.samplers.as_ref().unwrap().kinds.contains(&SolverKind::Rk45), "{name}");
    }

    #[test]
    fn every_configuration_that_is_shipped_is_valid() {
        let mut folders = vec![PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../configs"))];
        let mut read = 0;
        while let Some(path) = folders.pop() {
            if path.is_dir() {
                folders.extend(std::fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path()));
            } else if path.extension().is_some_and(|extension| extension == "toml") {
                if path.ends_with("reproduce.toml") {
                    continue;
                }
                let config: ExperimentConfig = load(&path, &[]).unwrap();
                config.validate().and_then(|()| config.validate_run()).unwrap();
                assert!(reseflow_sim::tasks().contains(&config.task.as_str()), "{}", path.display());
                if path.parent().is_some_and(|folder| folder.ends_with("paper")) {
                    has_the_papers_protocol(&config);
                }
                read += 1;
            }
        }
        assert!(read > 3, "{read} configurations were found, expected the quick start's and the paper's");
    }

    #[test]
    fn every_experiment_of_the_reproduction_is_valid() {
        let root = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
        let plan: toml::Table =
            std::fs::read_to_string(root.join("configs/reproduce.toml")).unwrap().parse().unwrap();
        let sets = |value: &toml::Value| -> Vec<Override> {
            value.as_array().unwrap().iter().map(|set| set.as_str().unwrap().parse().unwrap()).collect()
        };
        let experiments = plan["experiment"].as_array().unwrap();
        let mut trained: Vec<ExperimentConfig> = Vec::new();
        for experiment in experiments {
            let name = experiment["name"].as_str().unwrap();
            let mut overrides = vec![format!("name={name}").parse().unwrap()];
            overrides.extend(sets(&plan["set"]));
            overrides.extend(sets(&experiment["set"]));
            let path = root.join(experiment["config"].as_str().unwrap());
            let config: ExperimentConfig = load(&path, &overrides).unwrap();
            let verdict = config.validate().and_then(|()| config.validate_run());
            verdict.unwrap_or_else(|fault| panic!("{name}: {fault}"));
            assert_eq!(config.name, name);
            assert_eq!(Some(config.task.as_str()), name.split('-').next(), "the name begins with the task");
            trained.extend(config.pretrained.is_none().then_some(config));
        }
        assert!(experiments.len() > 10);
        is_an_ablation_or_the_main_method(&trained);
    }

    /// Runs of one task and number of demonstrations are trained alike but for the seed, unless a `variant` says that they are not.
    fn is_an_ablation_or_the_main_method(runs: &[ExperimentConfig]) {
        for (place, run) in runs.iter().enumerate() {
            for other in &runs[..place] {
                if run.task != other.task || run.data != other.data {
                    continue;
                }
                let seeded = TrainConfig { seed: run.train.seed, ..other.train.clone() };
                let reflow_alike =
                    run.reflow.is_none() || other.reflow.is_none() || run.reflow == other.reflow;
                let alike = run.model == other.model && run.train == seeded && reflow_alike;
                let named_alike = run.variant == other.variant;
                assert_eq!(alike, named_alike, "`variant` of {} and {}", run.name, other.name);
            }
        }
    }

    #[test]
    fn a_resolved_configuration_reads_back_as_itself() {
        let config = ExperimentConfig::default();
        let text = toml::to_string(&config).unwrap();
        assert_eq!(parse::<ExperimentConfig>(&text, "resolved", &[]).unwrap(), config);
        config.validate().unwrap();
        assert!(!text.contains("reflow"), "without the table there is none");
        let config = ExperimentConfig {
            reflow: Some(ReflowConfig::default()),
            baseline: Some(BaselineConfig::default()),
            regressor: true,
            ..config
        };
        config.validate().unwrap();
        let text = toml::to_string(&config).unwrap();
        assert_eq!(parse::<ExperimentConfig>(&text, "resolved", &[]).unwrap(), config);
    }

    #[test]
    fn values_out_of_range_are_named() {
        for (set, key) in [
            ("data.test_episodes=0", "data.test_episodes"),
            ("eval.steps=[1, 0]", "eval.steps"),
            ("eval.steps=[]", "eval.steps"),
            ("eval.steps=[1, 2, 1]", "eval.steps"),
            ("eval.seeds=0", "eval.seeds"),
            ("rollout.steps=0", "rollout.steps"),
            ("rollout.picture_episodes=0", "rollout.picture_episodes"),
            ("rollout.variants=[]", "rollout.variants"),
            ("rollout.variants=[\"replan\", \"disturbed\", \"replan\"]", "rollout.variants"),
            ("eval.splits=[\"wide\"]", "eval.splits"),
            ("eval.splits=[\"test\", \"wide\", \"wide\"]", "eval.splits"),
            ("eval.baseline_episodes=0", "eval.baseline_episodes"),
            ("samplers.kinds=[]", "samplers.kinds"),
            ("samplers.evaluations=[1, 0]", "samplers.evaluations"),
            ("samplers.tolerances=[-1.0]", "samplers.tolerances"),
            ("samplers.kinds=[\"heun\", \"heun\"]", "samplers.kinds"),
            ("samplers.evaluations=[]", "samplers.evaluations"),
            ("samplers.evaluations=[2, 2]", "samplers.evaluations"),
            ("samplers.tolerances=[]", "samplers.tolerances"),
            ("samplers.tolerances=[0.1, 0.1]", "samplers.tolerances"),
            ("output=", "output"),
            ("data.camera.drop_fraction=2", "data.camera"),
            ("name=../elsewhere", "name"),
            ("variant=\" \"", "variant"),
            ("variant=\"one\\nnode\"", "variant"),
            ("eval.unimodal_d_geo=0", "eval.unimodal_d_geo"),
            ("eval.solver={kind=\"heun\", rtol=1e-3}", "eval.solver"),
            ("rollout.solver={kind=\"rk45\", atol=-1}", "rollout.solver"),
            ("baseline.diffusion.steps=50", "eval.steps"),
            ("model.regression=true", "model.regression"),
        ] {
            let config: ExperimentConfig = parse("", "a.toml", &[set.parse().unwrap()]).unwrap();
            assert!(config.validate().unwrap_err().contains(&format!("`{key}`")), "{set}");
        }
    }
}
