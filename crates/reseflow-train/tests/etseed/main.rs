//! The baseline as its users see it: demonstrations in, a checkpoint out, and the policy that it holds.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

mod checkpoints;
mod equivariance;
mod learning;
mod resume;
mod support;
