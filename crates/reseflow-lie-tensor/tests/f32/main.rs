//! f32: values against `reseflow-lie`, and gradients against closed forms, to f32 rounding.

#![expect(
    clippy::expect_used,
    clippy::print_stdout,
    reason = "clippy knows test functions, but not what they call"
)]

#[path = "../support/mod.rs"]
mod support;

use burn::tensor::{DType, Tensor, s};
use reseflow_lie::{SE3, SO3, Vector3};
use reseflow_lie_tensor::{SE3Tensor, geodesic_distance, gram_schmidt, so3};
use std::f64::consts::PI;
use support::{Bench, assert_close, assert_maps_agree, devices, direction, rng, row_major, values};

fn benches() -> impl Iterator<Item = (&'static str, Bench)> {
    devices().into_iter().map(|(name, device)| (name, Bench { device, dtype: DType::F32 }))
}

#[test]
fn every_map_agrees_with_the_scalar_group() {
    for (name, bench) in benches() {
        assert_maps_agree(name, &bench, 1e-3, 2e-6);
    }
}

#[test]
fn log_gradient_is_the_inverse_right_jacobian() {
    let mut rng = rng(51);
    let axes: Vec<_> = (0..20).map(|_| direction(&mut rng)).collect();
    for (name, bench) in benches() {
        let tracked = Bench { device: bench.device.clone().autodiff(), dtype: bench.dtype };
        for angle in [0.0, 1e-8, 1e-4, 0.0499, 0.0501, 1.7, PI - 1e-3, PI] {
            let rotations: Vec<_> = axes.iter().map(|axis| SO3::exp(&(axis * angle))).collect();
            for m in 0..3 {
                let rotation = tracked.rotations(&rotations).require_grad();
                let gradients = so3::log(rotation.clone()).slice(s![.., m..m + 1]).sum().backward();
                let gradient = values(&rotation.grad(&gradients).expect("the input is tracked"));
                let mut actual = vec![];
                let mut expected = vec![];
                for (rotation, gradient) in rotations.iter().zip(gradient.chunks_exact(9)) {
                    let jacobian = SO3::right_jacobian_inverse(&rotation.log());
                    for i in 0..3 {
                        let tangent =
                            row_major::<3, 3>(&(rotation.matrix() * Vector3::ith(i, 1.0).cross_matrix()));
                        actual.push(gradient.iter().zip(&tangent).map(|(g, t)| g * t).sum());
                        expected.push(jacobian[(m, i)]);
                    }
                }
                assert_close(&format!("{name} f32 log gradient at {angle:.4}"), &actual, &expected, 2e-6);
            }
        }
    }
}

#[test]
fn a_loss_through_every_map_stays_finite() {
    // A network's head at its worst: no direction, or the target exactly hit, or missed by a half-turn.
    let (zero, x, y) = (Vector3::zeros(), Vector3::x(), Vector3::y());
    let tilted = Vector3::new(0.3, -0.8, 0.52);
    let (first, second): (Vec<_>, Vec<_>) = [
        (zero, zero),
        (x, y),
        (-x, -y),
        (-x, y),
        (x, -y),
        (x, x),
        (x, x * 2.0 + y * 1e-5),
        (x * 1e-15, y * 1e-15),
        (tilted, tilted * -3.0),
        (tilted, tilted * 2.0 + x * 1e-4),
    ]
    .into_iter()
    .unzip();
    for (_, bench) in benches() {
        let tracked = Bench { device: bench.device.clone().autodiff(), dtype: bench.dtype };
        let a = tracked.vectors(&first).require_grad();
        let b = tracked.vectors(&second).require_grad();
        let rotation = gram_schmidt(a.clone(), b.clone());
        let deviation = rotation.clone().swap_dims(1, 2).matmul(rotation.clone());
        let identity: Vec<f64> =
            first.iter().flat_map(|_| row_major::<3, 3>(&SO3::identity().matrix())).collect();
        assert_close("f32 gram schmidt is orthonormal", &values(&deviation), &identity, 1e-6);

        let target = tracked.poses(&vec![SE3::identity(); first.len()]);
        let pose = SE3Tensor { rotation, translation: target.translation.clone() };
        let distance = geodesic_distance(&pose, &target).d_geo;
        let twist = pose.between(&target).log();
        let loss: Tensor<1> = distance.sum() + twist.powi_scalar(2).sum();
        let gradients = loss.backward();
        for input in [a, b] {
            let gradient = values(&input.grad(&gradients).expect("the inputs are tracked"));
            assert!(gradient.iter().all(|value| value.is_finite()), "{gradient:?}");
        }
    }
}

#[test]
fn a_pose_is_at_distance_zero_from_itself() {
    // Exactly, and with gradient exactly 0: RᵀR is symmetric to the last bit, however R was rounded.
    let mut rng = rng(52);
    let poses: Vec<_> = (0..50).map(|_| SE3::new(SO3::sample_haar(&mut rng), direction(&mut rng))).collect();
    for (_, bench) in benches() {
        let tracked = Bench { device: bench.device.clone().autodiff(), dtype: bench.dtype };
        let target = tracked.poses(&poses);
        let rotation = target.rotation.clone().require_grad();
        let translation = target.translation.clone().require_grad();
        let pose = SE3Tensor { rotation: rotation.clone(), translation: translation.clone() };
        let distance = geodesic_distance(&pose, &target);
        let sum = distance.d_geo + distance.rotation_rad + distance.translation_m;
        assert_eq!(values(&sum), vec![0.0; poses.len()]);
        let gradients = sum.sum().backward();
        let rotation = values(&rotation.grad(&gradients).expect("the rotation is tracked"));
        let translation = values(&translation.grad(&gradients).expect("the translation is tracked"));
        assert!(rotation.iter().chain(&translation).all(|gradient| *gradient == 0.0));
    }
}
