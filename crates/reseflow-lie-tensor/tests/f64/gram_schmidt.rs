//! Gram–Schmidt: agreement with the scalar one, equivariance, and degenerate inputs.

use burn::tensor::Tensor;
use reseflow_lie::{Matrix3, SO3, Vector3};
use reseflow_lie_tensor::{gram_schmidt, rotation_angle};

use crate::benches;
use crate::support::{Bench, assert_close, direction, flat_rotations, rng, row_major, values};

/// Pairs of vectors down to an angle of 1e-4 between them, of very different lengths.
fn pairs() -> (Vec<Vector3<f64>>, Vec<Vector3<f64>>) {
    let mut rng = rng(31);
    let mut pairs = (vec![], vec![]);
    for (length, sine) in [(1.0, 1.0), (1e-4, 0.3), (1e4, 1e-2), (1.0, 1e-4)] {
        for _ in 0..16 {
            let first = direction(&mut rng);
            let across = first.cross(&direction(&mut rng)).normalize();
            pairs.0.push(first * length);
            pairs.1.push((first + across * sine) * 2.0);
        }
    }
    pairs
}

#[test]
fn agrees_with_the_scalar_one() {
    let (first, second) = pairs();
    let expected: Vec<_> = first
        .iter()
        .zip(&second)
        .map(|(a, b)| SO3::gram_schmidt(a, b).expect("the pairs span planes"))
        .collect();
    for (name, bench) in benches() {
        let actual = gram_schmidt(bench.vectors(&first), bench.vectors(&second));
        // Rounding of the inputs, divided by the smallest sine.
        assert_close(&format!("{name} gram schmidt"), &values(&actual), &flat_rotations(&expected), 1e-11);
        assert_orthonormal(&values(&actual), 1e-15 * 8.0);
    }
}

#[test]
fn turns_with_its_inputs() {
    let (first, second) = pairs();
    let turn = SO3::sample_haar(&mut rng(32));
    let turned = |vectors: &[Vector3<f64>]| vectors.iter().map(|v| turn.act(v)).collect::<Vec<_>>();
    for (name, bench) in benches() {
        let plain = read_rotations(&values(&gram_schmidt(bench.vectors(&first), bench.vectors(&second))));
        let expected: Vec<_> = plain.iter().map(|rotation| turn * rotation).collect();
        let actual = gram_schmidt(bench.vectors(&turned(&first)), bench.vectors(&turned(&second)));
        assert_close(&format!("{name} turned"), &values(&actual), &flat_rotations(&expected), 1e-11);
    }
}

#[test]
fn degenerate_inputs_give_rotations_and_finite_gradients() {
    let (zero, x, y) = (Vector3::zeros(), Vector3::x(), Vector3::y());
    let tilted = Vector3::new(0.3, -0.8, 0.52);
    let cases = [
        (zero, zero),
        (zero, x),
        (x, zero),
        (x, x),
        (y, y * -3.0),
        (x * -1.0, x * 1e6),
        (tilted, tilted),
        (tilted * 1e-9, tilted),
        (tilted * 1e-4, tilted * 1e-4 + y * 1e-9),
        (tilted, tilted * 1e3 + y * 1e-9),
        (x * 1e-20, y * 1e-20),
    ];
    let (first, second): (Vec<_>, Vec<_>) = cases.into_iter().unzip();
    for (_, bench) in benches() {
        let tracked = Bench { device: bench.device.clone().autodiff(), dtype: bench.dtype };
        let a = tracked.vectors(&first).require_grad();
        let b = tracked.vectors(&second).require_grad();
        let rotation = gram_schmidt(a.clone(), b.clone());
        assert_orthonormal(&values(&rotation), 1e-14);
        let identity = tracked.rotations(&vec![SO3::identity(); first.len()]);
        let gradients = rotation_angle(rotation, identity).sum().backward();
        for gradient in [a.grad(&gradients), b.grad(&gradients)] {
            let gradient: Tensor<2> = gradient.expect("the inputs are tracked");
            let largest = values(&gradient)
                .iter()
                .fold(0.0, |worst: f64, g| if g.is_nan() { f64::NAN } else { worst.max(g.abs()) });
            assert!(largest < 1e7, "the gradient reaches {largest:e}");
        }
    }
}

/// The rotations nearest to these matrices.
fn read_rotations(flat: &[f64]) -> Vec<SO3> {
    flat.chunks_exact(9)
        .map(|entries| {
            SO3::from_matrix(&Matrix3::from_row_slice(entries)).expect("a rotation up to rounding")
        })
        .collect()
}

fn assert_orthonormal(flat: &[f64], tolerance: f64) {
    for entries in flat.chunks_exact(9) {
        let matrix = Matrix3::from_row_slice(entries);
        let deviation = row_major::<3, 3>(&(matrix.transpose() * matrix - Matrix3::identity()));
        assert_close("orthonormal", &deviation, &[0.0; 9], tolerance);
        assert!(matrix.determinant() > 0.0, "a reflection");
    }
}
