//! Shared by both suites: devices, samples from `reseflow-lie`, and host arrays to tensors and back.
//!
//! A device's default float type can be set once per process, so the suites are two binaries; neither sets it, and
//! every tensor is made with an explicit type, which is what the crate promises to follow.

use burn::tensor::{DType, Device, Tensor, TensorData};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use reseflow_lie::{Matrix3, SE3, SO3, Vector3};
use std::f64::consts::PI;

/// The CPU devices, by name.
pub(crate) fn devices() -> [(&'static str, Device); 2] {
    [("flex", Device::flex()), ("ndarray", ndarray())]
}

#[expect(deprecated, reason = "burn keeps ndarray until 0.23, and we promise that it works until then")]
fn ndarray() -> Device {
    Device::ndarray()
}

/// Where and in which float type tensors are made.
#[derive(Clone)]
pub(crate) struct Bench {
    pub(crate) device: Device,
    pub(crate) dtype: DType,
}

impl Bench {
    pub(crate) fn tensor<const D: usize>(&self, values: &[f64], shape: [usize; D]) -> Tensor<D> {
        Tensor::from_data(TensorData::new(values.to_vec(), shape), (&self.device, self.dtype))
    }

    pub(crate) fn vectors(&self, vectors: &[Vector3<f64>]) -> Tensor<2> {
        self.tensor(&flat_vectors(vectors), [vectors.len(), 3])
    }

    pub(crate) fn rotations(&self, rotations: &[SO3]) -> Tensor<3> {
        self.tensor(&flat_rotations(rotations), [rotations.len(), 3, 3])
    }

    pub(crate) fn poses(&self, poses: &[SE3]) -> reseflow_lie_tensor::SE3Tensor {
        let rotations: Vec<_> = poses.iter().map(|pose| pose.rotation).collect();
        let translations: Vec<_> = poses.iter().map(|pose| pose.translation).collect();
        reseflow_lie_tensor::SE3Tensor {
            rotation: self.rotations(&rotations),
            translation: self.vectors(&translations),
        }
    }
}

/// The tensor's values in row-major order.
pub(crate) fn values<const D: usize>(tensor: &Tensor<D>) -> Vec<f64> {
    tensor.clone().cast(DType::F64).try_into_vec_as::<f64>().expect("a float tensor can be read")
}

pub(crate) fn row_major<const R: usize, const C: usize>(
    matrix: &reseflow_lie::nalgebra::SMatrix<f64, R, C>,
) -> Vec<f64> {
    matrix.transpose().iter().copied().collect()
}

pub(crate) fn flat_vectors(vectors: &[Vector3<f64>]) -> Vec<f64> {
    vectors.iter().flat_map(|vector| vector.iter().copied()).collect()
}

pub(crate) fn flat_rotations(rotations: &[SO3]) -> Vec<f64> {
    rotations.iter().flat_map(|rotation| row_major::<3, 3>(&rotation.matrix())).collect()
}

pub(crate) fn flat_poses(poses: &[SE3]) -> Vec<f64> {
    poses.iter().flat_map(|pose| row_major::<4, 4>(&pose.matrix())).collect()
}

/// The largest |actual − expected|, at most `tolerance`; a NaN counts as infinite.
#[track_caller]
pub(crate) fn assert_close(what: &str, actual: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(actual.len(), expected.len(), "{what}: lengths differ");
    let error = actual
        .iter()
        .zip(expected)
        .map(|(a, e)| (a - e).abs())
        .fold(0.0, |worst: f64, error| if error.is_finite() { worst.max(error) } else { f64::INFINITY });
    println!("{what:60} {error:9.2e} (allowed {tolerance:.0e})");
    assert!(error <= tolerance, "{what}: off by {error:e}, allowed {tolerance:e}");
}

pub(crate) fn rng(stream: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(stream)
}

/// A direction drawn uniformly.
pub(crate) fn direction(rng: &mut ChaCha8Rng) -> Vector3<f64> {
    SO3::sample_haar(rng).act(&Vector3::z())
}

/// Rotation vectors: uniform, near the identity, near a half-turn, and exactly at both, with every branch of the
/// quaternion among them. `gap` is the smallest distance from π that is not π itself.
pub(crate) fn rotation_vectors(gap: f64) -> Vec<Vector3<f64>> {
    let mut rng = rng(1);
    let angles = [0.0, 1e-12, 1e-8, 1e-7, 1e-4, 0.0499, 0.0501, 0.3, 1.5, 3.0, PI - 1e-3, PI - gap, PI];
    let mut vectors = vec![];
    for _ in 0..6 {
        vectors.extend(angles.map(|angle| direction(&mut rng) * angle));
    }
    for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
        vectors.extend(angles.map(|angle| -axis * angle));
    }
    for axis in [Vector3::new(-1.0, 1.0, 0.0), Vector3::new(0.0, 1.0, -1.0), Vector3::new(-1.0, -1.0, -1.0)] {
        vectors.push(axis.normalize() * PI);
    }
    vectors.extend((0..40).map(|_| SO3::sample_haar(&mut rng).log()));
    vectors
}

/// Poses with those rotations and translations of about a metre.
pub(crate) fn poses(gap: f64) -> Vec<SE3> {
    let mut rng = rng(2);
    rotation_vectors(gap).iter().map(|omega| SE3::new(SO3::exp(omega), direction(&mut rng) * 1.3)).collect()
}

/// Every map of the crate against `reseflow-lie`, element by element.
///
/// `exact` are the poses that the tensors hold up to rounding; `gap` keeps f32 away from the cut, where one rounding
/// decides the branch, except at π itself, where the branch is documented.
pub(crate) fn assert_maps_agree(name: &str, bench: &Bench, gap: f64, tolerance: f64) {
    use reseflow_lie::{BodyTwist, geodesic_distance};
    use reseflow_lie_tensor::geodesic::Geodesic;
    use reseflow_lie_tensor::{SE3Tensor, quaternion, so3};

    let check = |what: &str, actual: Vec<f64>, expected: Vec<f64>| {
        assert_close(&format!("{name} {what}"), &actual, &expected, tolerance);
    };

    let omegas = rotation_vectors(gap);
    let n = omegas.len();
    assert!(n > 100, "too few examples");
    let rotations: Vec<_> = omegas.iter().map(SO3::exp).collect();
    let poses = poses(gap);
    let omega = bench.vectors(&omegas);
    let rotation = bench.rotations(&rotations);
    let pose = bench.poses(&poses);

    let per_omega = |f: fn(&Vector3<f64>) -> Matrix3<f64>| -> Vec<f64> {
        omegas.iter().flat_map(|omega| row_major::<3, 3>(&f(omega))).collect()
    };
    check("hat", values(&so3::hat(omega.clone())), per_omega(Vector3::cross_matrix));
    check("so3 exp", values(&so3::exp(omega.clone())), flat_rotations(&rotations));
    check(
        "so3 log",
        values(&so3::log(rotation.clone())),
        rotations.iter().flat_map(|r| r.log().data.0[0]).collect(),
    );
    check("left jacobian", values(&so3::left_jacobian(omega.clone())), per_omega(SO3::left_jacobian));
    check(
        "left jacobian inverse",
        values(&so3::left_jacobian_inverse(omega.clone())),
        per_omega(SO3::left_jacobian_inverse),
    );
    let quaternions: Vec<f64> = rotations.iter().flat_map(SO3::quaternion_xyzw).collect();
    check("quaternion from matrix", values(&quaternion::from_matrix(rotation.clone())), quaternions.clone());
    check(
        "quaternion to matrix",
        values(&quaternion::to_matrix(bench.tensor(&quaternions, [n, 4]))),
        flat_rotations(&rotations),
    );

    let twists: Vec<_> = poses.iter().map(SE3::log).collect();
    let flat_twists: Vec<f64> = twists.iter().flat_map(|twist| twist.vector6().data.0[0]).collect();
    check("se3 log", values(&pose.log()), flat_twists.clone());
    check(
        "se3 exp",
        values(&SE3Tensor::exp(bench.tensor(&flat_twists, [n, 6])).to_matrix()),
        flat_poses(&poses),
    );
    check("se3 matrix", values(&SE3Tensor::from_matrix(pose.to_matrix()).to_matrix()), flat_poses(&poses));
    check(
        "se3 inverse",
        values(&pose.inverse().to_matrix()),
        poses.iter().flat_map(|p| row_major(&p.inverse().matrix())).collect(),
    );
    check(
        "se3 adjoint",
        values(&pose.adjoint()),
        poses.iter().flat_map(|p| row_major(&p.adjoint())).collect(),
    );
    let acted: Vec<_> = poses.iter().zip(&omegas).map(|(pose, point)| pose.act(point)).collect();
    check("se3 act", values(&pose.act(omega.clone())), flat_vectors(&acted));

    // Pairs with a generic relative pose: a shift of the list would put two half-turns side by side.
    let mut rng = rng(3);
    let steps: Vec<_> =
        poses.iter().map(|_| SE3::sample_gaussian(&SE3::identity(), 0.6, 0.3, &mut rng)).collect();
    let ends: Vec<_> = poses.iter().zip(&steps).map(|(pose, step)| pose * step).collect();
    let end = bench.poses(&ends);
    check("se3 compose", values(&pose.compose(&bench.poses(&steps)).to_matrix()), flat_poses(&ends));
    check("se3 between", values(&pose.between(&end).to_matrix()), flat_poses(&steps));

    type Displace = fn(&SE3, &SE3) -> BodyTwist;
    type Retract = fn(&SE3, &BodyTwist) -> SE3;
    type Interpolate = fn(&SE3, &SE3, f64) -> SE3;
    let geodesics: [(Geodesic, Displace, Retract, Interpolate); 2] = [
        (Geodesic::Screw, SE3::body_twist_to, SE3::plus, SE3::interpolate_screw),
        (Geodesic::Product, SE3::product_displacement_to, SE3::plus_product, SE3::interpolate_product),
    ];
    let times: Vec<f64> = (0..n).map(|i| i as f64 / (n - 1) as f64).collect();
    for (geodesic, displace, retract, interpolate) in geodesics {
        let pairs = || poses.iter().zip(&ends);
        let displacement: Vec<f64> =
            pairs().flat_map(|(start, end)| displace(start, end).vector6().data.0[0]).collect();
        check(
            &format!("{geodesic:?} displacement"),
            values(&geodesic.displacement(&pose, &end)),
            displacement,
        );
        let retracted: Vec<_> =
            pairs().zip(&twists).map(|((start, _), twist)| retract(start, twist)).collect();
        let twist = bench.tensor(&flat_twists, [n, 6]);
        check(
            &format!("{geodesic:?} retract"),
            values(&geodesic.retract(&pose, twist).to_matrix()),
            flat_poses(&retracted),
        );
        let between: Vec<_> =
            pairs().zip(&times).map(|((start, end), time)| interpolate(start, end, *time)).collect();
        check(
            &format!("{geodesic:?} interpolate"),
            values(&geodesic.interpolate(&pose, &end, bench.tensor(&times, [n])).to_matrix()),
            flat_poses(&between),
        );
    }

    // From the identity, so that every angle of the list occurs as a distance.
    let origin = bench.poses(&vec![SE3::identity(); n]);
    let distances: Vec<_> = poses.iter().map(|pose| geodesic_distance(&SE3::identity(), pose)).collect();
    let distance = reseflow_lie_tensor::geodesic_distance(&origin, &pose);
    check("d_geo", values(&distance.d_geo), distances.iter().map(|d| d.d_geo()).collect());
    check(
        "d_geo rotation",
        values(&distance.rotation_rad),
        distances.iter().map(|d| d.rotation_rad).collect(),
    );
    check(
        "d_geo translation",
        values(&distance.translation_m),
        distances.iter().map(|d| d.translation_m).collect(),
    );
    let chordal = reseflow_lie_tensor::chordal_distance_squared(origin.rotation, pose.rotation);
    let expected = distances.iter().map(|d| 8.0 * (d.rotation_rad / 2.0).sin().powi(2)).collect();
    check("chordal distance squared", values(&chordal), expected);
}
