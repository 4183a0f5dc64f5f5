//! Configuration: strict TOML files and overrides on the command line.

mod experiment;
mod nearest;
mod overrides;
mod solver;
mod strict;

use std::path::Path;

pub use experiment::{DataConfig, EVAL_STEPS, EvalConfig, ExperimentConfig, RolloutSection, UNIMODAL_D_GEO};
pub use nearest::nearest;
pub use overrides::Override;
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
