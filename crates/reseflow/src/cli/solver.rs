//! The options that say how a flow is integrated.

use clap::Args;

use crate::config::{SolverChoice, SolverKind};
use crate::error::bad_input;

/// `--solver`, `--rtol` and `--atol`
#[derive(Debug, Clone, Copy, Args)]
pub struct SolverArgs {
    /// How a flow is integrated
    #[arg(long, value_enum, default_value_t = SolverKind::Euler)]
    pub solver: SolverKind,
    /// The relative tolerance of rk45 [default: 1e-4]
    #[arg(long)]
    pub rtol: Option<f64>,
    /// The absolute tolerance of rk45 [default: 1e-6]
    #[arg(long)]
    pub atol: Option<f64>,
}

impl SolverArgs {
    /// The solver; `steps` is whether their number was given as well.
    ///
    /// # Errors
    /// Bad input: tolerances of a solver that has none, or steps for the one that chooses them itself.
    pub fn choice(&self, steps: bool) -> anyhow::Result<SolverChoice> {
        let Self { solver: kind, rtol, atol } = *self;
        let choice = SolverChoice { kind, rtol, atol };
        choice.validate().map_err(|fault| bad_input(format!("--solver {}: {fault}", self.name())))?;
        if choice.is_adaptive() && steps {
            return Err(bad_input(
                "--steps has no meaning with --solver rk45, which chooses its own; say --rtol and --atol",
            ));
        }
        Ok(choice)
    }

    fn name(&self) -> String {
        let named = clap::ValueEnum::to_possible_value(&self.solver);
        named.map(|value| value.get_name().to_owned()).unwrap_or_default()
    }
}
