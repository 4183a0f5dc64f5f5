//! Shared by both suites: devices of the suite's float type, random streams, and tensors on the host.
//!
//! A device's float type can be set once per process, so there are two suites; each names its own as `crate::FLOAT`.

pub(crate) mod degenerate;
pub(crate) mod degree_laws;
pub(crate) mod degree_layers;
pub(crate) mod edge_messages;
pub(crate) mod fading;
pub(crate) mod features;
pub(crate) mod fibers;
pub(crate) mod gradients;
pub(crate) mod laws;
pub(crate) mod layers;
pub(crate) mod mani_net;
pub(crate) mod messages;
pub(crate) mod plain;
pub(crate) mod scene;
pub(crate) mod statistics;
pub(crate) mod trajectory;
pub(crate) mod twists;
pub(crate) mod views;
pub(crate) mod weights;
pub(crate) mod world;

use burn::tensor::{DType, Device, Tensor, TensorData};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use reseflow_net::{DecoderConfig, DriftNetConfig, EncoderConfig, GraphConfig};
use std::sync::Once;

/// The CPU devices by name, making tensors of the suite's float type.
pub(crate) fn devices() -> [(&'static str, Device); 2] {
    static CONFIGURED: Once = Once::new();
    let devices = || [("flex", Device::flex()), ("ndarray", ndarray())];
    CONFIGURED.call_once(|| {
        for (_, mut device) in devices() {
            device.configure(crate::FLOAT).expect("no tensor was made before");
        }
    });
    devices()
}

#[expect(deprecated, reason = "burn keeps ndarray until 0.23, and we promise that it works until then")]
fn ndarray() -> Device {
    Device::ndarray()
}

pub(crate) fn rng(stream: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(stream)
}

/// Independent standard normal draws.
pub(crate) fn normals(count: usize, rng: &mut ChaCha8Rng) -> Vec<f64> {
    (0..count).map(|_| StandardNormal.sample(rng)).collect()
}

pub(crate) fn tensor<const D: usize>(values: Vec<f64>, shape: [usize; D], device: &Device) -> Tensor<D> {
    Tensor::from_data(TensorData::new(values, shape), device)
}

/// The tensor's values in row-major order.
pub(crate) fn values<const D: usize>(tensor: &Tensor<D>) -> Vec<f64> {
    tensor.clone().cast(DType::F64).try_into_vec_as::<f64>().expect("a float tensor can be read")
}

/// The largest |a − b|; a value that is not finite counts as infinite.
#[track_caller]
pub(crate) fn worst_difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len(), "lengths differ");
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, worse)
}

/// The larger of two errors, infinite where either is not finite.
pub(crate) fn worse(a: f64, b: f64) -> f64 {
    if a.is_finite() && b.is_finite() { a.max(b) } else { f64::INFINITY }
}

/// Asserts that an error is small, and prints how small (`--nocapture` shows it).
#[track_caller]
pub(crate) fn assert_small(what: &str, error: f64, tolerance: f64) {
    println!("{what:64} {error:9.2e} (allowed {tolerance:.0e})");
    assert!(error <= tolerance, "{what}: off by {error:e}, allowed {tolerance:e}");
}

/// Asserts that a control fails the check that it is a control of.
#[track_caller]
pub(crate) fn assert_caught(what: &str, error: f64, threshold: f64) {
    println!("{what:64} {error:9.2e} (must exceed {threshold:.0e})");
    assert!(error > threshold, "{what}: off by {error:e} only, the check cannot tell");
}

/// `config` with features up to this degree.
pub(crate) fn of_degree(max_degree: usize, mut config: DriftNetConfig) -> DriftNetConfig {
    config.encoder.max_degree = max_degree;
    config
}

/// A network small enough to be evaluated hundreds of times, with three of what the default has two or four of.
pub(crate) fn small() -> DriftNetConfig {
    DriftNetConfig {
        encoder: EncoderConfig {
            graph: GraphConfig { centres: 10, point_neighbors: 6, centre_neighbors: 4, color_m: 0.05 },
            channels: 8,
            nodes: 3,
            ..EncoderConfig::default()
        },
        decoder: DecoderConfig {
            horizon: 5,
            frames: 3,
            layers: 2,
            token_scalars: 12,
            token_vectors: 8,
            pointers: 2,
            grasp_memory: true,
            ..DecoderConfig::default()
        },
        ..DriftNetConfig::default()
    }
}
