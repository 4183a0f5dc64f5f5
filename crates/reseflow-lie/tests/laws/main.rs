//! The laws of SO(3) and SE(3). Each law is written once, over the [`group::LieGroup`] trait, and every group goes
//! through it on uniform, near-identity and near-half-turn samples; what only one group has is tested by itself.

// All of this binary is test code; clippy's own exception for tests covers only the functions marked #[test].
#![allow(clippy::unwrap_used)]

mod axioms;
mod draw;
mod exponential;
mod geodesics;
mod golden;
mod group;
mod half_turn;
mod jacobians;
mod mean;
mod metric;
mod negative_controls;
mod reading;
mod sampling;
mod twists;
