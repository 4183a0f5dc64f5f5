//! The real binary: recording, learning, scoring, acting, all of it as one pipeline, and every kind of bad input.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

mod bad_checkpoints;
mod bad_input;
mod camera;
mod choices;
mod equivariance;
#[cfg(unix)]
mod full_disk;
mod pipeline;
mod policies;
mod recording;
mod references;
mod reflow;
mod report;
mod report_results;
mod resume;
mod shipped;
mod splits;
mod support;
mod timing;
mod twists;
