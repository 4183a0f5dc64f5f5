//! The arguments of `reseflow bench`.

use std::path::PathBuf;

use clap::Args;

use super::numbers::positive;
use super::{DeviceArg, SolverArgs};

/// `reseflow bench`
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  reseflow bench --checkpoint door/flow2 --data test.npz
  reseflow bench --checkpoint runs/mine --data test.npz --steps 1,10,100 --out bench.json
  reseflow bench runs/quickstart runs/door

A plan is one call for one scene: graph, encoder, noise, integration. The first ones warm up and do not count. For folders of finished
runs every policy is timed with the steps that it was scored with, and the result is the file latency.json in each, which `reseflow
report` reads. Time while nothing else runs.")]
pub struct BenchArgs {
    /// Folders of runs that `reseflow run` has finished
    #[arg(value_name = "RUN_FOLDER", conflicts_with_all = ["checkpoint", "data", "steps", "solver", "rtol", "atol", "out", "device"])]
    pub runs: Vec<PathBuf>,
    /// The checkpoint's folder, or the name of a policy that ships, for example door/flow2
    #[arg(long, value_name = "DIR", requires = "data")]
    pub checkpoint: Option<PathBuf>,
    /// The episodes whose first observations are planned from
    #[arg(long, value_name = "FILE.npz", requires = "checkpoint")]
    pub data: Option<PathBuf>,
    /// Numbers of integration steps; of the baseline, how many noise levels are visited [default: 1,2,10,50,100; a regressor's: 1]
    #[arg(long, value_delimiter = ',', value_parser = positive)]
    pub steps: Vec<usize>,
    /// How a flow is integrated
    #[command(flatten)]
    pub solver: SolverArgs,
    /// The result to write
    #[arg(long, value_name = "FILE.json")]
    pub out: Option<PathBuf>,
    /// Where to compute
    #[arg(long, value_enum, default_value_t = DeviceArg::Cpu)]
    pub device: DeviceArg,
}
