//! f64 oracles: values against `reseflow-lie`, gradients against finite differences and closed forms.

#![expect(
    clippy::expect_used,
    clippy::print_stdout,
    reason = "clippy knows test functions, but not what they call"
)]

#[path = "../support/mod.rs"]
mod support;

mod gradient;
mod gram_schmidt;
mod group_gradients;
mod half_turn;
mod vector_gradients;

use burn::tensor::DType;
use support::{Bench, assert_maps_agree, devices};

/// The benches of this suite.
fn benches() -> impl Iterator<Item = (&'static str, Bench)> {
    devices().into_iter().map(|(name, device)| (name, Bench { device, dtype: DType::F64 }))
}

#[test]
fn every_map_agrees_with_the_scalar_group() {
    for (name, bench) in benches() {
        assert_maps_agree(name, &bench, 1e-6, 2e-14);
    }
}
