//! The arguments of `reseflow equiv`.

use std::path::PathBuf;

use clap::Args;

use super::numbers::{above_zero, positive};
use super::{DeviceArg, SolverArgs};

/// `reseflow equiv`
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  reseflow equiv --checkpoint door/flow2 --data test.npz
  reseflow equiv --checkpoint runs/mine --data test.npz --steps 1,10 --seeds 10 --out equiv.json
  reseflow equiv --checkpoint runs/mine --data test.npz --at-most 1e-4

Every episode is moved by a rigid motion g of its own, points, gripper and noise with it, and planned from again: the error is D_geo
between that plan and g times the plan before, action by action. It is rounding where the policy is equivariant to every
rotation, and large where it is told which way is up. How good the plans are is what `reseflow eval` says.")]
pub struct EquivArgs {
    /// The checkpoint's folder, or the name of a policy that ships, for example door/flow2
    #[arg(long, value_name = "DIR")]
    pub checkpoint: PathBuf,
    /// The episodes whose first observations are planned from
    #[arg(long, value_name = "FILE.npz")]
    pub data: PathBuf,
    /// Numbers of integration steps; of the baseline, how many noise levels are visited [default: 1]
    #[arg(long, value_delimiter = ',', value_parser = positive)]
    pub steps: Vec<usize>,
    /// How a flow is integrated
    #[command(flatten)]
    pub solver: SolverArgs,
    /// Noise seeds, from 3407 on
    #[arg(long, default_value = "10", value_parser = positive)]
    pub seeds: usize,
    /// End with exit code 1 where the 99.9th percentile is larger; the result is written all the same
    #[arg(long, value_name = "ERROR", value_parser = above_zero)]
    pub at_most: Option<f64>,
    /// The result to write
    #[arg(long, value_name = "FILE.json")]
    pub out: Option<PathBuf>,
    /// Where to compute
    #[arg(long, value_enum, default_value_t = DeviceArg::Cpu)]
    pub device: DeviceArg,
}
