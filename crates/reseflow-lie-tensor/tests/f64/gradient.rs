//! Jacobians of tensor maps: by autodiff, and by finite differences of the same map.

use burn::tensor::{Tensor, s};
use reseflow_lie::{BodyTwist, SE3, Vector6};
use reseflow_lie_tensor::SE3Tensor;

use crate::support::{Bench, values};

/// The step of a finite difference.
#[derive(Clone, Copy)]
pub(crate) enum Step {
    /// (f(h) − f(−h)) / 2h
    Central(f64),
    /// (−3 f(0) + 4 f(h) − f(2h)) / 2h, h of the sign that the row and direction name.
    OneSided(f64),
}

/// ∂f_m/∂ε_i of ε ↦ f(X Exp(ε)), for each pose: `[N][6][M]`, flat.
pub(crate) fn autodiff_on_group(
    bench: &Bench,
    poses: &[SE3],
    f: impl Fn(SE3Tensor) -> Tensor<2>,
) -> Vec<f64> {
    let n = poses.len();
    let tracked = Bench { device: bench.device.clone().autodiff(), dtype: bench.dtype };
    let outputs = f(tracked.poses(poses)).dims()[1];
    let mut jacobian = vec![0.0; n * 6 * outputs];
    for m in 0..outputs {
        let pose = tracked.poses(poses);
        let rotation = pose.rotation.require_grad();
        let translation = pose.translation.require_grad();
        let output = f(SE3Tensor { rotation: rotation.clone(), translation: translation.clone() });
        let gradients = output.slice(s![.., m..m + 1]).sum().backward();
        let by_rotation = rotation.grad(&gradients).map_or(vec![0.0; n * 9], |gradient| values(&gradient));
        let by_translation =
            translation.grad(&gradients).map_or(vec![0.0; n * 3], |gradient| values(&gradient));
        for (row, pose) in poses.iter().enumerate() {
            for i in 0..6 {
                // The tangent X ε̂ᵢ of the curve X Exp(h εᵢ).
                let tangent = pose.matrix() * BodyTwist::from_vector6(&Vector6::ith(i, 1.0)).hat();
                let mut derivative = 0.0;
                for a in 0..3 {
                    derivative += by_translation[row * 3 + a] * tangent[(a, 3)];
                    for b in 0..3 {
                        derivative += by_rotation[row * 9 + a * 3 + b] * tangent[(a, b)];
                    }
                }
                jacobian[(row * 6 + i) * outputs + m] = derivative;
            }
        }
    }
    jacobian
}

/// The same by finite differences, at matrices X Exp(h εᵢ) made by `reseflow-lie`. `side(row, i)` is ±1.
pub(crate) fn differences_on_group(
    bench: &Bench,
    poses: &[SE3],
    step: Step,
    side: impl Fn(usize, usize) -> f64,
    f: impl Fn(SE3Tensor) -> Tensor<2>,
) -> Vec<f64> {
    let n = poses.len();
    let mut jacobian = vec![];
    for i in 0..6 {
        let at = |length: f64| -> Vec<f64> {
            let moved: Vec<_> = poses
                .iter()
                .enumerate()
                .map(|(row, pose)| {
                    pose.plus(&(BodyTwist::from_vector6(&Vector6::ith(i, 1.0)) * (length * side(row, i))))
                })
                .collect();
            values(&f(bench.poses(&moved)))
        };
        let derivative = difference(step, at);
        let outputs = derivative.len() / n;
        jacobian.resize(n * 6 * outputs, 0.0);
        for row in 0..n {
            for m in 0..outputs {
                jacobian[(row * 6 + i) * outputs + m] = derivative[row * outputs + m] * side(row, i);
            }
        }
    }
    jacobian
}

/// ∂f_m/∂x_k for each row of x: `[N][K][M]`, flat.
pub(crate) fn autodiff_on_vectors(
    bench: &Bench,
    rows: &[Vec<f64>],
    f: impl Fn(Tensor<2>) -> Tensor<2>,
) -> Vec<f64> {
    let (n, width) = (rows.len(), rows[0].len());
    let tracked = Bench { device: bench.device.clone().autodiff(), dtype: bench.dtype };
    let input = || tracked.tensor(&rows.concat(), [n, width]).require_grad();
    let outputs = f(input()).dims()[1];
    let mut jacobian = vec![0.0; n * width * outputs];
    for m in 0..outputs {
        let x = input();
        let gradients = f(x.clone()).slice(s![.., m..m + 1]).sum().backward();
        let gradient = values(&x.grad(&gradients).expect("the input is tracked"));
        for (entry, value) in gradient.into_iter().enumerate() {
            jacobian[entry * outputs + m] = value;
        }
    }
    jacobian
}

/// The same by central differences.
pub(crate) fn differences_on_vectors(
    bench: &Bench,
    rows: &[Vec<f64>],
    h: f64,
    f: impl Fn(Tensor<2>) -> Tensor<2>,
) -> Vec<f64> {
    let (n, width) = (rows.len(), rows[0].len());
    let mut jacobian = vec![];
    for k in 0..width {
        let derivative = difference(Step::Central(h), |length| {
            let mut moved = rows.to_vec();
            moved.iter_mut().for_each(|row| row[k] += length);
            values(&f(bench.tensor(&moved.concat(), [n, width])))
        });
        let outputs = derivative.len() / n;
        jacobian.resize(n * width * outputs, 0.0);
        for row in 0..n {
            for m in 0..outputs {
                jacobian[(row * width + k) * outputs + m] = derivative[row * outputs + m];
            }
        }
    }
    jacobian
}

fn difference(step: Step, at: impl Fn(f64) -> Vec<f64>) -> Vec<f64> {
    let combine = |terms: Vec<(f64, f64)>, divisor: f64| -> Vec<f64> {
        let columns: Vec<_> = terms.into_iter().map(|(weight, length)| (weight, at(length))).collect();
        let sum = |entry: usize| columns.iter().map(|(weight, column)| weight * column[entry]).sum::<f64>();
        (0..columns[0].1.len()).map(|entry| sum(entry) / divisor).collect()
    };
    match step {
        Step::Central(h) => combine(vec![(1.0, h), (-1.0, -h)], 2.0 * h),
        Step::OneSided(h) => combine(vec![(-3.0, 0.0), (4.0, h), (-1.0, 2.0 * h)], 2.0 * h),
    }
}
