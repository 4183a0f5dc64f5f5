//! Equivariance in f32 from clouds to poses over thousands of random clouds, before and after training, and how often moving a scene
//! changes its graph.
//!
//! `cargo run --release -p reseflow-net --example equivariance -- [SCENES] [UPDATES]`
#![allow(clippy::expect_used, clippy::print_stdout, reason = "an example that reports to the terminal")]
#![allow(dead_code, reason = "the test suites use the rest of their support")]

#[path = "../tests/support/mod.rs"]
mod support;

use burn::tensor::FloatDType;
use reseflow_net::DriftNetConfig;
use support::devices;
use support::statistics::{Storage, measure, trained, worst_and_99_9th};

/// The float type of the tensors.
const FLOAT: FloatDType = FloatDType::F32;

fn main() {
    let mut arguments = std::env::args().skip(1).map(|argument| argument.parse().expect("a number"));
    let (scenes, updates) = (arguments.next().unwrap_or(2000), arguments.next().unwrap_or(300));
    let [(name, device), _] = devices();
    let config = DriftNetConfig::default();
    println!(
        "{scenes} scenes of {} frames on {name}; errors in radians and metres over 0.15 m",
        config.decoder.frames
    );
    for updates in [0, updates] {
        let net = trained(&config, updates, &device);
        for storage in [Storage::Exact, Storage::Single] {
            let found = measure(&net, scenes, storage, &device);
            println!(
                "{updates} updates, coordinates {storage:?}: of {} clouds {} with other centres, {} with other neighbours",
                found.clouds, found.changed_centres, found.changed_neighbors
            );
            for (what, errors) in [("fixed", &found.graph_fixed), ("built again", &found.graph_rebuilt)] {
                let (worst, most) = worst_and_99_9th(errors);
                println!("  graph {what:12} worst {worst:9.2e}, 99.9th percentile {most:9.2e}");
            }
        }
    }
}
