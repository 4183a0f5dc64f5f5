//! The cut of the logarithm, and matrices that are no rotations at all.

use reseflow_lie::{SE3, SO3, Vector3};
use reseflow_lie_tensor::geodesic::Geodesic;
use reseflow_lie_tensor::{SE3Tensor, so3};
use std::f64::consts::PI;

use crate::benches;
use crate::support::{Bench, assert_close, direction, rng, values};

#[test]
fn the_branch_at_a_half_turn_does_not_depend_on_the_world_frame() {
    let mut rng = rng(41);
    let axes: Vec<_> = [
        Vector3::new(0.0, -1.0, 0.0),
        Vector3::new(-1.0, 1.0, 0.0),
        Vector3::new(0.0, 1.0, -1.0),
        Vector3::new(-1.0, -1.0, -1.0),
    ]
    .into_iter()
    .chain((0..20).map(|_| direction(&mut rng)))
    .map(|axis| axis.normalize())
    .collect();
    let starts: Vec<_> =
        axes.iter().map(|_| SE3::new(SO3::sample_haar(&mut rng), direction(&mut rng))).collect();
    let half_turns: Vec<_> =
        axes.iter().map(|axis| SE3::new(SO3::exp(&(axis * PI)), Vector3::zeros())).collect();
    let ends: Vec<_> = starts.iter().zip(&half_turns).map(|(start, turn)| start * turn).collect();
    let expected: Vec<f64> = axes
        .iter()
        .flat_map(|axis| {
            let first = axis.iter().copied().find(|c| c.abs() > 1e-6).expect("an axis is not zero");
            let omega = axis * (PI * first.signum());
            [omega.x, omega.y, omega.z, 0.0, 0.0, 0.0]
        })
        .collect();
    for (name, bench) in benches() {
        for _ in 0..8 {
            let world = SE3::new(SO3::sample_haar(&mut rng), direction(&mut rng));
            let moved =
                |poses: &[SE3]| bench.poses(&poses.iter().map(|pose| world * pose).collect::<Vec<_>>());
            let displacement = Geodesic::Product.displacement(&moved(&starts), &moved(&ends));
            assert_close(&format!("{name} branch"), &values(&displacement), &expected, 1e-13);
        }
    }
}

#[test]
fn anything_finite_has_a_finite_log_and_gradient() {
    let mut rng = rng(42);
    let mut entries = vec![0.0; 9];
    entries.extend([1.0; 9]);
    entries.extend([-1.0; 9]);
    entries.extend([1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0]);
    entries.extend([-1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0]);
    entries.extend((0..30).flat_map(|_| (direction(&mut rng) * 5.0).data.0[0]));
    let n = entries.len() / 9;
    for (_, bench) in benches() {
        let tracked = Bench { device: bench.device.clone().autodiff(), dtype: bench.dtype };
        let rotation = tracked.tensor(&entries, [n, 3, 3]).require_grad();
        let translation = tracked.tensor(&vec![1.0; 3 * n], [n, 3]).require_grad();
        let pose = SE3Tensor { rotation: rotation.clone(), translation };
        let log = pose.log();
        assert!(values(&log).iter().all(|value| value.is_finite()));
        assert!(
            values(&so3::log(rotation.clone()))
                .chunks(3)
                .all(|w| w.iter().map(|c| c * c).sum::<f64>() < 9.87)
        );
        let gradients = log.sum().backward();
        let gradient = rotation.grad(&gradients).expect("the input is tracked");
        assert!(values(&gradient).iter().all(|value| value.is_finite()));
    }
}
