//! Episodes to write and compare.

use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use reseflow_data::{Action, Dataset, Episode, Observation, PointCloud};
use reseflow_lie::{SE3, SO3, Vector3};

/// A random pose within a metre of the origin.
pub(crate) fn pose(rng: &mut impl Rng) -> SE3 {
    let translation = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0));
    SE3::new(SO3::sample_haar(rng), translation)
}

/// A random action; its opening is a `float32`, as files hold it.
pub(crate) fn action(rng: &mut impl Rng) -> Action {
    Action { world_from_gripper: pose(rng), opening: f64::from(rng.random::<f32>()) }
}

/// A random frame of `points` points.
pub(crate) fn observation(rng: &mut impl Rng, points: usize) -> Observation {
    Observation {
        cloud: PointCloud {
            points: (0..points).map(|_| std::array::from_fn(|_| rng.random_range(-2.0..2.0))).collect(),
            colors: (0..points).map(|_| rng.random()).collect(),
        },
        world_from_gripper: pose(rng),
        gripper_opening: f64::from(rng.random::<f32>()),
    }
}

/// E random episodes of T steps with N points, without provenance.
pub(crate) fn dataset(seed: u64, episodes: usize, steps: usize, points: usize) -> Dataset {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let episodes = (0..episodes).map(|_| Episode {
        observations: (0..steps).map(|_| observation(&mut rng, points)).collect(),
        actions: (0..steps).map(|_| action(&mut rng)).collect(),
        alternative: None,
        disturbance: None,
    });
    Dataset { episodes: episodes.collect(), meta: None }
}

/// The largest difference between entries of two poses' matrices.
pub(crate) fn pose_error(left: &SE3, right: &SE3) -> f64 {
    (left.matrix() - right.matrix()).amax()
}
