//! The command line: raw arguments in, checked options out.

mod args;
mod bench;
mod camera;
mod equiv;
mod numbers;
mod parse;
mod report;
mod solver;

pub use args::{
    Cli, Command, DeviceArg, EvalArgs, GenArgs, InspectArgs, PredictArgs, ReflowArgs, RolloutArgs, RunArgs,
    SplitArg, TrainArgs,
};
pub use bench::BenchArgs;
pub use camera::CameraArgs;
pub use equiv::EquivArgs;
pub use parse::{Parsed, parse};
pub use report::ReportArgs;
pub use solver::SolverArgs;
