//! The report's tables, by what they are about.

mod ablations;
mod acting;
mod demonstrations;
mod errors;
mod flows;
mod origin;
mod paper;
mod seeds;

pub(super) use ablations::ablations;
pub(super) use acting::{closed_loop, latency};
pub(super) use demonstrations::by_demonstrations;
pub(super) use errors::{paired, scores};
pub(super) use flows::{modes, nodes, samplers, straightness, turned};
pub(super) use origin::{origin, stages};
pub(super) use paper::beside_the_paper;
pub(super) use seeds::over_training_seeds;
