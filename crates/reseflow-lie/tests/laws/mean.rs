//! Fréchet means: they minimise, move with the frame, and refuse what has no mean.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use reseflow_lie::{BodyTwist, LieError, SE3, SO3, Vector3, geodesic_distance};

/// Scatters tried, in radian on each axis; metres are a tenth of it.
const SCATTERS: [f64; 4] = [1e-6, 0.05, 0.3, 0.6];

struct Cloud {
    poses: Vec<SE3>,
    weights: Vec<f64>,
}

fn clouds() -> Vec<Cloud> {
    let mut rng = ChaCha8Rng::seed_from_u64(3407);
    let mut clouds = Vec::new();
    for scatter in SCATTERS {
        for count in 2..22 {
            let centre = SE3::new(SO3::sample_haar(&mut rng), Vector3::new(1.0, -2.0, 0.5));
            let poses =
                (0..count).map(|_| SE3::sample_gaussian(&centre, scatter, 0.1 * scatter, &mut rng)).collect();
            let weights = (0..count).map(|index| 0.2 + (index % 5) as f64).collect();
            clouds.push(Cloud { poses, weights });
        }
    }
    clouds
}

fn objective(mean: &SE3, cloud: &Cloud) -> f64 {
    cloud
        .poses
        .iter()
        .zip(&cloud.weights)
        .map(|(pose, w)| w * geodesic_distance(mean, pose).d_geo().powi(2))
        .sum()
}

#[test]
fn the_mean_minimises_the_sum_of_squared_distances() {
    let clouds = clouds();
    assert_eq!(clouds.len(), 80);
    for cloud in clouds {
        let mean = SE3::frechet_mean(&cloud.poses, &cloud.weights).unwrap();
        let least = objective(&mean, &cloud);
        for axis in 0..6 {
            for step in [1e-4, -1e-4, 0.3, -0.3] {
                let mut change = BodyTwist::zero().vector6();
                change[axis] = step;
                let other = objective(&mean.plus_product(&BodyTwist::from_vector6(&change)), &cloud);
                assert!(other > least, "axis {axis} step {step}: {other} against {least}");
            }
        }
    }
}

#[test]
fn at_the_mean_the_weighted_logarithms_cancel() {
    for cloud in clouds() {
        let mean = SE3::frechet_mean(&cloud.poses, &cloud.weights).unwrap();
        let sum = cloud
            .poses
            .iter()
            .zip(&cloud.weights)
            .map(|(pose, weight)| mean.product_displacement_to(pose) * *weight)
            .fold(BodyTwist::zero(), |sum, term| sum + term);
        assert!(sum.vector6().norm() < 1e-10, "{}", sum.vector6().norm());
    }
}

#[test]
fn the_mean_moves_with_the_frame_and_ignores_order_and_scale() {
    let g = SE3::new(SO3::exp(&Vector3::new(1.0, -2.0, 0.3)), Vector3::new(0.4, 5.0, -1.0));
    for cloud in clouds() {
        let mean = SE3::frechet_mean(&cloud.poses, &cloud.weights).unwrap();
        let moved: Vec<SE3> = cloud.poses.iter().rev().map(|pose| g * pose).collect();
        let weights: Vec<f64> = cloud.weights.iter().rev().map(|weight| weight * 17.0).collect();
        let moved_mean = SE3::frechet_mean(&moved, &weights).unwrap();
        assert!(geodesic_distance(&(g * mean), &moved_mean).d_geo() < 1e-10);
        let rotations: Vec<SO3> = cloud.poses.iter().map(|pose| pose.rotation).collect();
        let rotation_mean = SO3::frechet_mean(&rotations, &cloud.weights).unwrap();
        assert_eq!(rotation_mean, mean.rotation);
    }
}

#[test]
fn the_mean_of_two_lies_on_their_product_geodesic() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for _ in 0..50 {
        let [x, y] = [0; 2].map(|_| SE3::new(SO3::sample_haar(&mut rng), Vector3::zeros()));
        if geodesic_distance(&x, &y).rotation_rad > 3.0 {
            continue;
        }
        let mean = SE3::frechet_mean(&[x, y], &[0.7, 0.3]).unwrap();
        assert!(geodesic_distance(&mean, &x.interpolate_product(&y, 0.3)).d_geo() < 1e-9);
    }
}

#[test]
fn an_element_of_no_weight_does_not_count() {
    let x = SO3::exp(&Vector3::x());
    let mean = SO3::frechet_mean(&[x, SO3::exp(&Vector3::y())], &[2.0, 0.0]).unwrap();
    assert!((x.inverse() * mean).angle() < 1e-12);
}

/// Uniform rotations have no mean to speak of; what comes back is a stationary point or an error, never a guess.
#[test]
fn uniform_rotations_give_a_stationary_point_or_an_error() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let mut converged = 0;
    for _ in 0..100 {
        let rotations: Vec<SO3> = (0..12).map(|_| SO3::sample_haar(&mut rng)).collect();
        match SO3::frechet_mean(&rotations, &[1.0; 12]) {
            Ok(mean) => {
                let sum: Vector3<f64> = rotations.iter().map(|r| (mean.inverse() * r).log()).sum();
                assert!(sum.norm() < 1e-9);
                converged += 1;
            }
            Err(error) => assert!(matches!(error, LieError::MeanNotConverged { .. }), "{error}"),
        }
    }
    assert!(converged >= 90, "only {converged} of 100 uniform sets converged");
}

#[test]
fn what_has_no_mean_is_refused() {
    let x = SO3::identity();
    assert_eq!(SO3::frechet_mean(&[], &[]), Err(LieError::EmptyMean));
    assert_eq!(SO3::frechet_mean(&[x], &[]), Err(LieError::WeightCount { elements: 1, weights: 0 }));
    for weights in [[1.0, -0.5], [f64::NAN, 1.0], [0.0, 0.0], [f64::INFINITY, 1.0]] {
        let refusal = SO3::frechet_mean(&[x, x], &weights).unwrap_err();
        assert!(matches!(refusal, LieError::InvalidWeight { .. }), "{refusal}");
    }
    let broken = SE3::new(x, Vector3::new(f64::NAN, 0.0, 0.0));
    assert!(matches!(SE3::frechet_mean(&[broken], &[1.0]), Err(LieError::NonFinite { .. })));
    let broken = SO3::exp(&Vector3::new(f64::NAN, 0.0, 0.0));
    assert!(matches!(SO3::frechet_mean(&[broken], &[1.0]), Err(LieError::NonFinite { .. })));
}
