//! The laws of the flow: where noise comes from, how it travels, how a field is integrated, and what the objective asks.

// All of this binary is test code; clippy's own exception for tests covers only the functions marked #[test].
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::print_stdout)]

mod adaptive;
mod answers;
mod config;
mod coupling;
mod diffusion;
mod fixed;
mod haar;
mod known;
mod objective;
mod order;
mod path;
mod prior;
mod straightness;
mod time;
mod twist_objective;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use reseflow_data::{Action, ActionChunk};
use reseflow_flow::Path;
use reseflow_lie::{SE3, SO3, Vector3, geodesic_distance};

const PATHS: [Path; 2] = [Path::Screw, Path::Product];

fn rng(stream: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(stream)
}

/// A pose anywhere within about a metre.
fn pose(rng: &mut ChaCha8Rng) -> SE3 {
    SE3::new(SO3::sample_haar(rng), Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0)))
}

/// A trajectory of random actions.
fn chunk(horizon: usize, rng: &mut ChaCha8Rng) -> ActionChunk {
    let action = |_| Action { world_from_gripper: pose(rng), opening: rng.random() };
    ActionChunk((0..horizon).map(action).collect())
}

/// The largest distance between corresponding actions: radians, metres and openings alike.
#[track_caller]
fn apart(a: &ActionChunk, b: &ActionChunk) -> f64 {
    assert_eq!(a.len(), b.len(), "horizons differ");
    let pairs = a.iter().zip(b.iter());
    pairs.fold(0.0, |worst: f64, (a, b)| {
        let error = geodesic_distance(&a.world_from_gripper, &b.world_from_gripper).d_geo();
        let error = error.max((a.opening - b.opening).abs());
        if error.is_finite() { worst.max(error) } else { f64::INFINITY }
    })
}

/// The trajectory in a world moved by `world`.
fn moved(world: &SE3, trajectory: &ActionChunk) -> ActionChunk {
    let action = |action: &Action| Action {
        world_from_gripper: world * action.world_from_gripper,
        opening: action.opening,
    };
    ActionChunk(trajectory.iter().map(action).collect())
}
