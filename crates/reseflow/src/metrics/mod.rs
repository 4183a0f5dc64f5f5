//! Figures: distances between trajectories, how they are aggregated, intervals, and the predictors any policy must beat.

mod bootstrap;
mod calibration;
mod mean_trajectory;
mod nearest_demonstration;
mod paired;
mod scores;
mod statistics;
mod trajectory_error;
mod wilson;

pub use bootstrap::bootstrap_mean_interval;
pub use calibration::{Calibration, CalibrationBin};
pub use mean_trajectory::MeanTrajectory;
pub use nearest_demonstration::{NEAREST_BY, NearestDemonstration};
pub use paired::PairedDifference;
pub use scores::Scores;
pub use statistics::{mean, quantile, std_ddof1};
pub use trajectory_error::TrajectoryError;
pub use wilson::wilson_interval;

use serde::Serialize;

/// A 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Interval {
    /// Its lower end.
    pub low: f64,
    /// Its upper end.
    pub high: f64,
}
