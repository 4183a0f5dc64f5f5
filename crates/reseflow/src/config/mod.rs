//! Configuration: strict TOML files and overrides on the command line.

mod acting;
mod combinations;
mod counts;
mod experiment;
mod nearest;
mod overrides;
mod samplers;
mod scoring;
mod solver;
mod strict;

use std::path::Path;

pub use acting::{PlanChoice, RolloutSection, RolloutVariant};
pub use experiment::{DataConfig, ExperimentConfig, is_folder_name};
pub use nearest::nearest;
pub use overrides::Override;
pub use samplers::SamplersConfig;
pub use scoring::{EVAL_STEPS, EvalConfig, EvalSplit, UNIMODAL_D_GEO};
pub use solver::{SolverChoice, SolverKind};
pub use strict::{load, parse};

use crate::error::bad_input;

/// Reads, overrides and checks an experiment's configuration.
///
/// # Errors
/// Bad input that names the file, the key and what was expected.
pub fn load_experiment(path: &Path, overrides: &[Override]) -> anyhow::Result<ExperimentConfig> {
    let config: ExperimentConfig = load(path, overrides)?;
    config.validate().map_err(|fault| bad_input(format!("{}: {fault}", path.display())))?;
    Ok(config)
}
