//! Random rotations and poses have the law they claim, from a fixed stream.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use reseflow_lie::{Matrix3, Matrix6, SE3, SO3, Vector3, Vector6};
use std::f64::consts::{FRAC_2_PI, FRAC_PI_2, PI};

const DRAWS: usize = 20_000;

/// Largest distance between the empirical distribution of `values` and `cumulative` (Kolmogorov–Smirnov).
fn largest_gap(mut values: Vec<f64>, cumulative: impl Fn(f64) -> f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let count = values.len() as f64;
    values
        .iter()
        .enumerate()
        .map(|(rank, value)| {
            let want = cumulative(*value);
            (want - rank as f64 / count).abs().max(((rank + 1) as f64 / count - want).abs())
        })
        .fold(0.0, f64::max)
}

/// The critical value of Kolmogorov–Smirnov's test at the level 1e-4.
fn critical_gap() -> f64 {
    2.226 / (DRAWS as f64).sqrt()
}

/// Under Haar's measure the angle has the density (1 − cos θ)/π, whichever rotation it is measured from.
#[test]
fn haar_rotations_are_uniform_seen_from_anywhere() {
    let mut rng = ChaCha8Rng::seed_from_u64(3407);
    let rotations: Vec<SO3> = (0..DRAWS).map(|_| SO3::sample_haar(&mut rng)).collect();
    for origin in [Vector3::zeros(), Vector3::new(0.5, -2.0, 1.0), Vector3::new(PI, 0.0, 0.0)] {
        let origin = SO3::exp(&origin);
        for left in [true, false] {
            let seen = |r: &SO3| if left { origin * r } else { r * origin };
            let angles: Vec<f64> = rotations.iter().map(|r| seen(r).angle()).collect();
            let mean = angles.iter().sum::<f64>() / DRAWS as f64;
            assert!((mean - FRAC_PI_2 - FRAC_2_PI).abs() < 0.02, "mean angle {mean}");
            let gap = largest_gap(angles, |angle| (angle - angle.sin()) / PI);
            assert!(gap < critical_gap(), "Kolmogorov–Smirnov gap {gap}");
        }
    }
    let mean_matrix = rotations.iter().map(SO3::matrix).sum::<Matrix3<f64>>() / DRAWS as f64;
    assert!(mean_matrix.amax() < 4.0 / (3.0 * DRAWS as f64).sqrt(), "{mean_matrix}");
}

/// Negative control: rotation vectors drawn normally are not uniform, and the test above would see it.
#[test]
fn concentrated_rotations_are_not_uniform() {
    let mut rng = ChaCha8Rng::seed_from_u64(3407);
    let angles =
        (0..DRAWS).map(|_| SO3::sample_gaussian(&SO3::identity(), 1.0, &mut rng).angle()).collect::<Vec<_>>();
    assert!(largest_gap(angles, |angle| (angle - angle.sin()) / PI) > 2.0 * critical_gap());
}

#[test]
fn gaussian_poses_scatter_by_their_deviations_in_the_body_frame() {
    let mean = SE3::new(SO3::exp(&Vector3::new(0.4, 1.0, -2.0)), Vector3::new(3.0, -1.0, 2.0));
    let (sigma_angular, sigma_linear) = (0.5, 0.1);
    let mut rng = ChaCha8Rng::seed_from_u64(3408);
    let noise: Vec<Vector6<f64>> = (0..DRAWS)
        .map(|_| SE3::sample_gaussian(&mean, sigma_angular, sigma_linear, &mut rng))
        .map(|pose| mean.body_twist_to(&pose).vector6())
        .collect();
    let count = DRAWS as f64;
    let scaled = |v: &Vector6<f64>| {
        Vector6::from_fn(|row, _| v[row] / if row < 3 { sigma_angular } else { sigma_linear })
    };
    let average = noise.iter().map(scaled).sum::<Vector6<f64>>() / count;
    let covariance = noise.iter().map(scaled).map(|v| v * v.transpose()).sum::<Matrix6<f64>>() / count
        - Matrix6::identity();
    assert!(average.amax() < 4.0 / count.sqrt(), "{average}");
    assert!(covariance.amax() < 4.0 * (2.0 / count).sqrt(), "{covariance}");
}

/// The noise is in body coordinates: the same stream about g·mean gives g times the sample.
#[test]
fn gaussian_poses_move_with_their_mean() {
    let g = SE3::new(SO3::exp(&Vector3::new(1.0, -2.0, 0.3)), Vector3::new(0.4, 5.0, -1.0));
    let mean = SE3::new(SO3::exp(&Vector3::new(0.4, 1.0, -2.0)), Vector3::new(3.0, -1.0, 2.0));
    let [mut here, mut there] = [0; 2].map(|_| ChaCha8Rng::seed_from_u64(7));
    for _ in 0..100 {
        let moved = g * SE3::sample_gaussian(&mean, 0.5, 0.1, &mut here);
        let sample = SE3::sample_gaussian(&(g * mean), 0.5, 0.1, &mut there);
        assert!((moved.matrix() - sample.matrix()).amax() < 1e-13);
    }
}

#[test]
fn one_seed_one_stream() {
    let draw = |seed| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        (SO3::sample_haar(&mut rng), SE3::sample_gaussian(&SE3::identity(), 0.5, 0.1, &mut rng))
    };
    assert_eq!(draw(1), draw(1));
    assert_ne!(draw(1), draw(2));
}
