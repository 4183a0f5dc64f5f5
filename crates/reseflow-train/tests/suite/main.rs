//! The trainer as its users see it: demonstrations in, a checkpoint out, and the policy that it holds.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

mod checkpoints;
mod configuration;
mod damage;
mod equivariance;
mod flows;
mod half_turns;
mod learning;
mod reflow;
mod regressor;
mod replacement;
mod resume;
mod sampler;
mod schedule;
mod support;
mod turned_scenes;
mod twists;
