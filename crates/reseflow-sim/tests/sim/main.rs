//! The simulator's integration tests: one binary, every registered task through one conformance suite.
#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

mod camera;
mod conformance;
mod determinism;
mod disturbed;
mod door;
mod halts;
mod painting;
mod physics;
mod settings;
mod support;
mod triangle;
