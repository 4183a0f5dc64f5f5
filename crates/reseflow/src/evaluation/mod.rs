//! Scoring a policy on recorded episodes: from each episode's first observation, over noise seeds and numbers of steps.

mod modes;
mod report;
mod run;
mod scoring;
mod trivial;

pub use modes::ModeScores;
pub use report::{EvalReport, StepRow, StraightnessRow};
pub use run::{EvalInputs, Loaded, checkpoint_config, evaluate, note_task};
pub use scoring::{SamplePolicy, noise_seeds, predict_first, score_steps};
pub use trivial::{TrivialScores, trivial_scores};
