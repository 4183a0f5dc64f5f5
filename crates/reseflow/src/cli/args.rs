//! The arguments of every command. The calls in the examples are a contract.

use std::path::PathBuf;

use clap::{ArgAction, Args, Parser, Subcommand, ValueEnum};
use reseflow_data::Split;

use super::numbers::{above_zero, positive, share};
use super::{BenchArgs, CameraArgs, EquivArgs, ReportArgs, SolverArgs};
use crate::config::{Override, PlanChoice, UNIMODAL_D_GEO};

/// Simulate, train, evaluate and look at SE(3)-equivariant rectified-flow policies.
#[derive(Debug, Parser)]
#[command(name = "reseflow", version, arg_required_else_help = true)]
#[command(after_help = "Examples:
  reseflow run configs/quickstart.toml
  reseflow gen --task triangle --episodes 100 --seed 1 --out demos.npz
  reseflow rollout --policy expert --task triangle --episodes 20 --seed 1 --steps 1 --mcap log.mcap --out expert.json

Exit codes: 0 done, 2 something given cannot be used (one sentence says what), 1 anything else.")]
pub struct Cli {
    /// What to do
    #[command(subcommand)]
    pub command: Command,
    /// Print the result as JSON on standard output
    #[arg(long, global = true)]
    pub json: bool,
    /// Say more on standard error (-vv: everything)
    #[arg(short, long, global = true, action = ArgAction::Count)]
    pub verbose: u8,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Record expert demonstrations of a task in the simulator
    Gen(GenArgs),
    /// Say what a data set, a prediction file, a pair file or an MCAP log holds
    Inspect(InspectArgs),
    /// Train a policy on a data set
    Train(TrainArgs),
    /// Make pairs with a trained flow and train the next, straighter one on them (Flow 2)
    Reflow(ReflowArgs),
    /// Predict trajectories from each episode's first observation
    Predict(PredictArgs),
    /// Score a policy against held-out demonstrations
    Eval(EvalArgs),
    /// Let a policy act in the simulator
    Rollout(RolloutArgs),
    /// Do everything that a configuration says: data, training, evaluation, rollouts, pictures
    Run(RunArgs),
    /// Move scenes, and compare a policy's plans with the moved plans
    Equiv(EquivArgs),
    /// Time single plans of a policy, or of every policy of finished runs
    Bench(BenchArgs),
    /// Put finished runs into one report: tables and figures beside the paper's
    Report(ReportArgs),
}

/// Which part of a task's distribution.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SplitArg {
    /// To learn from
    Train,
    /// To choose settings with
    Validation,
    /// For reported figures
    Test,
    /// Poses, sizes and viewpoints outside the training distribution
    Wide,
    /// The test split with the whole world turned, gravity included, episode by episode
    Turned,
}

impl std::fmt::Display for SplitArg {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            SplitArg::Turned => f.write_str("turned"),
            other => Split::from(*other).fmt(f),
        }
    }
}

impl From<SplitArg> for Split {
    /// The split that episodes are drawn from: `turned` is paired with `test`.
    fn from(split: SplitArg) -> Self {
        match split {
            SplitArg::Train => Split::Train,
            SplitArg::Validation => Split::Validation,
            SplitArg::Test | SplitArg::Turned => Split::Test,
            SplitArg::Wide => Split::Wide,
        }
    }
}

/// Where tensors live.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum DeviceArg {
    /// The processor, with the backend that is fastest there
    Cpu,
    /// The processor, through burn's flex backend
    Flex,
    /// The processor, through burn's ndarray backend
    Ndarray,
}

/// `reseflow gen`
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  reseflow gen --task triangle --episodes 500 --seed 1 --out train.npz
  reseflow gen --task triangle --episodes 50 --seed 1 --split test --out test.npz --preview test.png --verify-replay
  reseflow gen --task door --episodes 50 --seed 1 --out far.npz --camera points=64 --camera selection=farthest

The camera's settings are written into the data set's `meta`; in a configuration they are the table `data.camera`.")]
pub struct GenArgs {
    /// The task's name
    #[arg(long)]
    pub task: String,
    /// How many episodes
    #[arg(long, value_parser = positive)]
    pub episodes: usize,
    /// The same seed gives the same episodes
    #[arg(long)]
    pub seed: u64,
    /// Splits never share an episode, whatever the seeds
    #[arg(long, value_enum, default_value_t = SplitArg::Train)]
    pub split: SplitArg,
    /// Which share of the episodes is disturbed, so that a policy can learn to begin anew; from 0 to 1
    #[arg(long, default_value_t = 0.0, value_name = "SHARE", value_parser = share)]
    pub disturbed_share: f64,
    /// How frames are made
    #[command(flatten)]
    pub camera: CameraArgs,
    /// The data set to write (an older file is replaced once the new one is complete)
    #[arg(long, value_name = "FILE.npz")]
    pub out: PathBuf,
    /// A picture of the first episodes; beside it, with the ending .gif, the first one as a film
    #[arg(long, value_name = "FILE.png")]
    pub preview: Option<PathBuf>,
    /// Replay the stored actions open loop in the simulator and report how many episodes that solves
    #[arg(long)]
    pub verify_replay: bool,
}

/// `reseflow inspect`
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  reseflow inspect train.npz
  reseflow inspect predictions.npz --json
  reseflow inspect flow-2.pairs.npz
  reseflow inspect log.mcap")]
pub struct InspectArgs {
    /// A data set, a prediction file or a pair file (.npz), or a log (.mcap)
    pub file: PathBuf,
}

/// `reseflow train`
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  reseflow train --config configs/quickstart.toml --data train.npz --validation validation.npz --out runs/mine
  reseflow train --config configs/quickstart.toml --data train.npz --out runs/small --set train.batch_size=8
  reseflow train --config configs/quickstart.toml --data train.npz --out runs/small --set train.batch_size=8 --resume
  reseflow train --config configs/quickstart.toml --data train.npz --out runs/et-seed --baseline
  reseflow train --config configs/quickstart.toml --data train.npz --out runs/regressor --set model.regression=true

Every `train.save_every` updates the training's state goes to DIR.partial, which disappears once DIR is whole.")]
pub struct TrainArgs {
    /// A configuration; its `model` and `train` tables count, for the baseline its `baseline` table as well
    #[arg(long, value_name = "FILE.toml")]
    pub config: PathBuf,
    /// The demonstrations
    #[arg(long, value_name = "FILE.npz")]
    pub data: PathBuf,
    /// Held-out demonstrations, scored during training
    #[arg(long, value_name = "FILE.npz")]
    pub validation: Option<PathBuf>,
    /// The checkpoint's folder
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Train the baseline (ET-SEED's diffusion) instead of a flow
    #[arg(long)]
    pub baseline: bool,
    /// Go on where an interrupted training of the same configuration and data stopped, to the same bytes
    #[arg(long)]
    pub resume: bool,
    /// Where to compute; overrides the configuration
    #[arg(long, value_enum)]
    pub device: Option<DeviceArg>,
    /// Override a key of the configuration, for example train.batch_size=8
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<Override>,
}

/// `reseflow reflow`
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  reseflow reflow --config configs/coin_toss.toml --checkpoint runs/flow-1 --data train.npz --out runs/flow-2
  reseflow reflow --config configs/coin_toss.toml --checkpoint runs/flow-1 --data train.npz --out runs/flow-2 \\
    --set reflow.mixture.pair_share=1 --pairs pairs.npz

The pair file says which checkpoint, data and settings it was made with, and is used again where these are the same. For another
round, call it with the new checkpoint.")]
pub struct ReflowArgs {
    /// A configuration, as a rule the one that the flow was trained with; its `train` and `reflow` tables count, augmentation included,
    /// and the network is the checkpoint's
    #[arg(long, value_name = "FILE.toml")]
    pub config: PathBuf,
    /// The folder of the trained flow
    #[arg(long, value_name = "DIR")]
    pub checkpoint: PathBuf,
    /// The demonstrations that it has learned from
    #[arg(long, value_name = "FILE.npz")]
    pub data: PathBuf,
    /// Held-out demonstrations, scored during training
    #[arg(long, value_name = "FILE.npz")]
    pub validation: Option<PathBuf>,
    /// The pair file to use or to write [default: beside the folder of --out, with the ending .pairs.npz]
    #[arg(long, value_name = "FILE.npz")]
    pub pairs: Option<PathBuf>,
    /// The new checkpoint's folder
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Go on where an interrupted training of the same configuration and data stopped, to the same bytes
    #[arg(long)]
    pub resume: bool,
    /// Where to compute; overrides the configuration
    #[arg(long, value_enum)]
    pub device: Option<DeviceArg>,
    /// Override a key of the configuration, for example reflow.updates=500
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<Override>,
}

/// `reseflow predict`
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  reseflow predict --checkpoint runs/mine --data test.npz --steps 1 --seeds 10 --out predictions.npz
  reseflow predict --checkpoint runs/mine --data test.npz --solver rk45 --rtol 1e-3 --out predictions.npz

Writes `pose` [episodes, seeds, L, 4, 4] and `opening` [episodes, seeds, L] for the noise seeds 3407, 3408, …")]
pub struct PredictArgs {
    /// The checkpoint's folder, or the name of a policy that ships, for example door/flow2
    #[arg(long, value_name = "DIR")]
    pub checkpoint: PathBuf,
    /// The episodes
    #[arg(long, value_name = "FILE.npz")]
    pub data: PathBuf,
    /// Integration steps; of the baseline, how many noise levels are visited [default: 1]
    #[arg(long, value_parser = positive)]
    pub steps: Option<usize>,
    /// How a flow is integrated
    #[command(flatten)]
    pub solver: SolverArgs,
    /// Noise seeds, from 3407 on
    #[arg(long, default_value = "10", value_parser = positive)]
    pub seeds: usize,
    /// The prediction file to write
    #[arg(long, value_name = "FILE.npz")]
    pub out: PathBuf,
    /// Where to compute
    #[arg(long, value_enum, default_value_t = DeviceArg::Cpu)]
    pub device: DeviceArg,
}

/// `reseflow eval`
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  reseflow eval --checkpoint runs/mine --data test.npz --steps 1,2,10,50,100 --seeds 10 --out eval.json
  reseflow eval --checkpoint runs/mine --data test.npz --train-data train.npz --out eval.json
  reseflow eval --checkpoint runs/et-seed --data test.npz --steps 1,2,10,50,100 --out et-seed.json
  reseflow eval --checkpoint runs/mine --data test.npz --solver rk45 --rtol 1e-3 --out eval.json")]
pub struct EvalArgs {
    /// The checkpoint's folder, or the name of a policy that ships, for example door/flow2
    #[arg(long, value_name = "DIR")]
    pub checkpoint: PathBuf,
    /// The held-out episodes
    #[arg(long, value_name = "FILE.npz")]
    pub data: PathBuf,
    /// Numbers of integration steps; of the baseline, how many noise levels are visited [default: 1,2,10,50,100; a regressor's: 1]
    #[arg(long, value_delimiter = ',', value_parser = positive)]
    pub steps: Vec<usize>,
    /// How a flow is integrated
    #[command(flatten)]
    pub solver: SolverArgs,
    /// What D_geo is where there is one mode only: samples three times as far from both experts count as between them
    #[arg(long, default_value_t = UNIMODAL_D_GEO, value_parser = above_zero)]
    pub unimodal_d_geo: f64,
    /// Noise seeds, from 3407 on
    #[arg(long, default_value = "10", value_parser = positive)]
    pub seeds: usize,
    /// The training episodes, for the two trivial predictors
    #[arg(long, value_name = "FILE.npz")]
    pub train_data: Option<PathBuf>,
    /// The result to write
    #[arg(long, value_name = "FILE.json")]
    pub out: PathBuf,
    /// Where to compute
    #[arg(long, value_enum, default_value_t = DeviceArg::Cpu)]
    pub device: DeviceArg,
}

/// `reseflow rollout`
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  reseflow rollout --policy expert --task triangle --episodes 100 --seed 1 --steps 1 --out expert.json
  reseflow rollout --policy runs/mine --task triangle --episodes 50 --seed 1 --steps 1 --mcap log.mcap --out mine.json
  reseflow rollout --policy runs/mine --task triangle --episodes 50 --seed 1 --steps 5 --solver heun --out heun.json
  reseflow rollout --policy runs/mine --task door --episodes 50 --seed 1 --camera points=64 --out few-points.json

A policy whose checkpoint says that it has learned another task is refused, unless --any-task is given.")]
pub struct RolloutArgs {
    /// `expert`, `still`, a checkpoint's folder, or the name of a policy that ships, for example door/flow2
    #[arg(long, value_name = "expert|still|DIR|NAME")]
    pub policy: String,
    /// The task's name
    #[arg(long)]
    pub task: String,
    /// How many episodes
    #[arg(long, value_parser = positive)]
    pub episodes: usize,
    /// The same seed gives the same scenes
    #[arg(long)]
    pub seed: u64,
    /// Integration steps of a learned policy; of the baseline, how many noise levels are visited [default: 1]
    #[arg(long, value_parser = positive)]
    pub steps: Option<usize>,
    /// How a flow is integrated
    #[command(flatten)]
    pub solver: SolverArgs,
    /// Let a policy act on a task that it has not learned
    #[arg(long)]
    pub any_task: bool,
    /// Which part of the task's distribution
    #[arg(long, value_enum, default_value_t = SplitArg::Test)]
    pub split: SplitArg,
    /// How frames are made
    #[command(flatten)]
    pub camera: CameraArgs,
    /// Actions executed before the policy looks and plans again
    #[arg(long, default_value = "3", value_parser = positive)]
    pub n_action_steps: usize,
    /// Which of the plans that a learned policy has made in an episode is carried out
    #[arg(long, value_enum, default_value_t)]
    pub plan_choice: PlanChoice,
    /// Disturb each episode at the action step where it matters for the task
    #[arg(long)]
    pub disturb: bool,
    /// A log of the first episodes, for Foxglove or Rerun
    #[arg(long, value_name = "FILE.mcap")]
    pub mcap: Option<PathBuf>,
    /// How many episodes the log holds
    #[arg(long, default_value = "5", value_parser = positive)]
    pub mcap_episodes: usize,
    /// A picture of the first episodes; beside it, with the ending .gif, the first one as a film
    #[arg(long, value_name = "FILE.png")]
    pub preview: Option<PathBuf>,
    /// The result to write
    #[arg(long, value_name = "FILE.json")]
    pub out: PathBuf,
    /// Where to compute
    #[arg(long, value_enum, default_value_t = DeviceArg::Cpu)]
    pub device: DeviceArg,
}

/// `reseflow run`
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  reseflow run configs/quickstart.toml
  reseflow run configs/quickstart.toml --set train.batch_size=8 --set name=small-batches

A stage whose inputs have not changed since it was finished is skipped, and an interrupted training goes on where its last state was
saved; run it again after any interruption.")]
pub struct RunArgs {
    /// The configuration
    #[arg(value_name = "CONFIG.toml")]
    pub config: PathBuf,
    /// Override a key of the configuration, for example train.batch_size=8
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<Override>,
    /// Where to compute; overrides the configuration
    #[arg(long, value_enum)]
    pub device: Option<DeviceArg>,
    /// Redo every stage
    #[arg(long)]
    pub fresh: bool,
}
