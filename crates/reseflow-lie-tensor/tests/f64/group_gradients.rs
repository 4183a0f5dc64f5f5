//! Gradients along X Exp(ε) at every angle the crate makes a promise for.

use burn::tensor::Tensor;
use reseflow_lie::{SE3, SO3, Vector3};
use reseflow_lie_tensor::geodesic::Geodesic;
use reseflow_lie_tensor::{
    SE3Tensor, chordal_distance_squared, geodesic_distance, quaternion, rotation_angle, so3,
};
use std::f64::consts::PI;
use std::iter::repeat_with;

use crate::benches;
use crate::gradient::{Step, autodiff_on_group, differences_on_group};
use crate::support::{Bench, assert_close, direction, rng};

/// What a difference quotient can tell: its own truncation and rounding.
struct Case {
    angle: f64,
    step: Step,
    tolerance: f64,
}

/// The step must not cross the kink of a norm at 0 nor the cut at π.
const CASES: [Case; 8] = [
    Case { angle: 0.0, step: Step::Central(1e-5), tolerance: 3e-9 },
    Case { angle: 1e-8, step: Step::Central(1e-10), tolerance: 1e-4 },
    Case { angle: 0.0499, step: Step::Central(1e-6), tolerance: 3e-9 },
    Case { angle: 0.0501, step: Step::Central(1e-6), tolerance: 3e-9 },
    Case { angle: 1.7, step: Step::Central(1e-5), tolerance: 3e-9 },
    Case { angle: PI - 1e-3, step: Step::Central(1e-5), tolerance: 3e-9 },
    Case { angle: PI - 1e-6, step: Step::Central(2e-7), tolerance: 1e-7 },
    Case { angle: PI, step: Step::OneSided(1e-5), tolerance: 1e-8 },
];

/// Axes with no small component, so that a step along any of them leaves the cut cleanly, in every octant; at π the
/// documented branch is the one with a positive first component.
fn axes() -> Vec<Vector3<f64>> {
    let mut rng = rng(11);
    let mut axes: Vec<_> = repeat_with(|| direction(&mut rng)).take(64).collect();
    axes.retain(|axis| axis.iter().all(|component| component.abs() > 0.05));
    assert!(axes.len() > 30, "too few examples");
    axes
}

fn poses(angle: f64) -> Vec<SE3> {
    let mut rng = rng(12);
    axes().iter().map(|axis| SE3::new(SO3::exp(&(axis * angle)), direction(&mut rng) * 0.7)).collect()
}

/// The direction in which a step along εᵢ shrinks the angle of the documented branch of Log R.
fn into_the_branch(poses: &[SE3]) -> impl Fn(usize, usize) -> f64 {
    let logs: Vec<_> = poses.iter().map(|pose| pose.rotation.log()).collect();
    move |row, i| if i < 3 && logs[row][i] > 0.0 { -1.0 } else { 1.0 }
}

fn assert_gradients(what: &str, f: impl Fn(&Bench, SE3Tensor) -> Tensor<2>) {
    assert_gradients_on(what, 1.0, f);
}

/// `branch` is −1 where f takes the logarithm of X⁻¹: that leaves the cut on the other side.
fn assert_gradients_on(what: &str, branch: f64, f: impl Fn(&Bench, SE3Tensor) -> Tensor<2>) {
    for (name, bench) in benches() {
        let tracked = Bench { device: bench.device.clone().autodiff(), dtype: bench.dtype };
        for case in CASES {
            let poses = poses(case.angle);
            let actual = autodiff_on_group(&bench, &poses, |pose| f(&tracked, pose));
            let into = into_the_branch(&poses);
            let side = |row, i| if case.angle == PI { branch * into(row, i) } else { 1.0 };
            let expected = differences_on_group(&bench, &poses, case.step, side, |pose| f(&bench, pose));
            assert_close(&format!("{name} {what} at {:.6}", case.angle), &actual, &expected, case.tolerance);
        }
    }
}

fn flat<const D: usize>(tensor: Tensor<D>) -> Tensor<2> {
    let n = tensor.dims()[0];
    let width = tensor.shape().num_elements() / n;
    tensor.reshape([n, width])
}

/// As many fixed poses, all the same, as there are rows.
fn other(bench: &Bench, like: &SE3Tensor, pose: SE3) -> SE3Tensor {
    bench.poses(&vec![pose; like.len()])
}

fn elsewhere() -> SE3 {
    SE3::new(SO3::exp(&Vector3::new(0.3, -0.2, 0.5)), Vector3::new(0.1, 0.4, -0.3))
}

#[test]
fn so3_log() {
    assert_gradients("so3 log", |_, pose| so3::log(pose.rotation));
}

#[test]
fn quaternion_from_matrix() {
    assert_gradients("quaternion", |_, pose| quaternion::from_matrix(pose.rotation));
}

#[test]
fn se3_log() {
    assert_gradients("se3 log", |_, pose| pose.log());
}

#[test]
fn rotation_angle_from_the_identity() {
    assert_gradients("angle", |bench, pose| {
        let identity = other(bench, &pose, SE3::identity());
        flat(rotation_angle(identity.rotation, pose.rotation))
    });
}

#[test]
fn distances() {
    assert_gradients("d_geo", |bench, pose| {
        let identity = other(bench, &pose, SE3::identity());
        let distance = geodesic_distance(&identity, &pose);
        let chordal = chordal_distance_squared(pose.rotation, identity.rotation);
        Tensor::stack(vec![distance.d_geo, distance.rotation_rad, distance.translation_m, chordal], 1)
    });
}

#[test]
fn group_operations() {
    assert_gradients("operations", |bench, pose| {
        let other = other(bench, &pose, elsewhere());
        let product = pose.inverse().compose(&other).to_matrix();
        let point = pose.act(other.translation.clone());
        Tensor::cat(vec![flat(product), flat(pose.adjoint()), point], 1)
    });
}

#[test]
fn geodesics() {
    // Between a fixed pose and one at the listed angle from it, which is the end and then the start.
    for geodesic in [Geodesic::Screw, Geodesic::Product] {
        for (way, branch) in [("to", 1.0), ("from", -1.0)] {
            assert_gradients_on(&format!("{geodesic:?} {way}"), branch, |bench, pose| {
                let fixed = other(bench, &pose, elsewhere());
                let moving = fixed.compose(&pose);
                let (start, end) = if way == "to" { (fixed, moving) } else { (moving, fixed) };
                let time = Tensor::full([pose.len()], 0.3, (&bench.device, bench.dtype));
                let middle = geodesic.interpolate(&start, &end, time).to_matrix();
                Tensor::cat(vec![geodesic.displacement(&start, &end), flat(middle)], 1)
            });
        }
    }
}

#[test]
fn log_gradient_is_the_inverse_right_jacobian() {
    // The closed form, which a difference quotient is too blunt to test: Log(R Exp(ε)) ≈ Log R + J_r⁻¹(Log R) ε.
    for (name, bench) in benches() {
        for angle in [0.0, 1e-8, 1e-4, 0.0499, 0.0501, 1.7, PI - 1e-3, PI - 1e-6, PI] {
            let poses = poses(angle);
            let actual = autodiff_on_group(&bench, &poses, |pose| so3::log(pose.rotation));
            let mut expected = vec![];
            for pose in &poses {
                let jacobian = SO3::right_jacobian_inverse(&pose.rotation.log());
                expected.extend(jacobian.iter().copied()); // column i is the derivative along εᵢ
                expected.extend([0.0; 9]);
            }
            assert_close(&format!("{name} log against J_r⁻¹ at {angle:.8}"), &actual, &expected, 1e-12);
        }
    }
}

#[test]
fn angle_gradient_is_the_axis_and_zero_at_zero() {
    for (name, bench) in benches() {
        let tracked = Bench { device: bench.device.clone().autodiff(), dtype: bench.dtype };
        for angle in [0.0, 1e-12, 1e-8, 1e-4, 1.7, PI - 1e-6, PI] {
            let poses = poses(angle);
            let actual = autodiff_on_group(&bench, &poses, |pose| {
                let identity = other(&tracked, &pose, SE3::identity());
                flat(rotation_angle(identity.rotation, pose.rotation))
            });
            let mut expected = vec![];
            for pose in &poses {
                let log = pose.rotation.log();
                let axis = if angle == 0.0 { Vector3::zeros() } else { log.normalize() };
                expected.extend([axis.x, axis.y, axis.z, 0.0, 0.0, 0.0]);
            }
            assert_close(&format!("{name} angle against the axis at {angle:.12}"), &actual, &expected, 1e-12);
        }
    }
}
