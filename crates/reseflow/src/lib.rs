//! Simulate, train, evaluate and look at SE(3)-equivariant rectified-flow policies: the parts that the `reseflow` command is made of.

pub mod cli;
pub mod commands;
pub mod config;
pub mod demonstrations;
pub mod error;
pub mod evaluation;
pub mod learners;
pub mod learning;
pub mod metrics;
pub mod output;
pub mod pipeline;
pub mod plot;
pub mod provenance;
pub mod reflow;
pub mod report;
pub mod rollouts;
