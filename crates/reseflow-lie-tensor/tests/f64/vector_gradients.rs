//! Gradients of the maps that start from vectors.

use burn::tensor::{Tensor, s};
use reseflow_lie::{SE3, SO3};
use reseflow_lie_tensor::geodesic::Geodesic;
use reseflow_lie_tensor::{SE3Tensor, gram_schmidt, quaternion, so3};

use crate::benches;
use crate::gradient::{autodiff_on_vectors, differences_on_vectors};
use crate::support::{Bench, assert_close, direction, rng, rotation_vectors};

const STEP: f64 = 1e-5;
const TOLERANCE: f64 = 1e-9;

fn assert_gradients(what: &str, rows: &[Vec<f64>], f: impl Fn(&Bench, Tensor<2>) -> Tensor<2>) {
    for (name, bench) in benches() {
        let tracked = Bench { device: bench.device.clone().autodiff(), dtype: bench.dtype };
        let actual = autodiff_on_vectors(&bench, rows, |x| f(&tracked, x));
        let expected = differences_on_vectors(&bench, rows, STEP, |x| f(&bench, x));
        assert_close(&format!("{name} {what}"), &actual, &expected, TOLERANCE);
    }
}

fn omegas() -> Vec<Vec<f64>> {
    rotation_vectors(1e-6).iter().map(|omega| omega.iter().copied().collect()).collect()
}

/// The rotation vectors with a linear part of about a metre.
fn twists() -> Vec<Vec<f64>> {
    let mut rng = rng(21);
    let mut rows = omegas();
    rows.iter_mut().for_each(|row| row.extend(direction(&mut rng).iter()));
    rows
}

fn flat(tensor: Tensor<3>) -> Tensor<2> {
    let [n, a, b] = tensor.dims();
    tensor.reshape([n, a * b])
}

#[test]
fn so3_maps() {
    assert_gradients("hat", &omegas(), |_, omega| flat(so3::hat(omega)));
    assert_gradients("so3 exp", &omegas(), |_, omega| flat(so3::exp(omega)));
    assert_gradients("left jacobian", &omegas(), |_, omega| flat(so3::left_jacobian(omega)));
    assert_gradients("left jacobian inverse", &omegas(), |_, omega| flat(so3::left_jacobian_inverse(omega)));
    let quaternions: Vec<_> =
        rotation_vectors(1e-6).iter().map(|omega| SO3::exp(omega).quaternion_xyzw().to_vec()).collect();
    assert_gradients("quaternion to matrix", &quaternions, |_, quaternion| {
        flat(quaternion::to_matrix(quaternion))
    });
}

#[test]
fn se3_maps() {
    assert_gradients("se3 exp", &twists(), |_, twist| flat(SE3Tensor::exp(twist).to_matrix()));
    for geodesic in [Geodesic::Screw, Geodesic::Product] {
        assert_gradients(&format!("{geodesic:?} retract"), &twists(), |bench, twist| {
            let start = SE3::sample_gaussian(&SE3::identity(), 0.5, 0.5, &mut rng(22));
            let start = bench.poses(&vec![start; twist.dims()[0]]);
            flat(geodesic.retract(&start, twist).to_matrix())
        });
    }
}

#[test]
fn gram_schmidt_of_generic_vectors() {
    let mut rng = rng(23);
    let mut rows: Vec<Vec<f64>> = vec![];
    while rows.len() < 40 {
        let (first, second) = (direction(&mut rng) * 1.4, direction(&mut rng) * 0.8);
        if first.cross(&second).norm() > 0.6 {
            rows.push(first.iter().chain(second.iter()).copied().collect());
        }
    }
    assert_gradients("gram schmidt", &rows, |_, x| {
        flat(gram_schmidt(x.clone().slice(s![.., 0..3]), x.slice(s![.., 3..6])))
    });
}
