//! Scoring a policy on recorded episodes: from each episode's first observation, over noise seeds and numbers of steps.

mod latency;
mod modes;
mod report;
mod run;
mod samplers;
mod scoring;
mod trivial;
mod turned;

pub use latency::{LatencyReport, LatencyRow, PlanLatency, time_plans};
pub use modes::ModeScores;
pub use report::{EvalReport, StepRow, StepsDifference, StraightnessRow};
pub use run::{EvalInputs, Loaded, checkpoint_config, evaluate, note_task};
pub use samplers::{FlowSamplers, SamplerRow, SamplersReport, compare_samplers};
pub use scoring::{SamplePolicy, noise_seeds, predict_first, score_steps};
pub use trivial::{TrivialScores, trivial_scores};
pub use turned::{EquivarianceError, TurnedScores, compare_turned, equivariance_error, turned};
