//! The laws of the diffusion baseline: its schedule, its noise, its way back, and what moves with the scene.

mod forward;
mod sampler;
mod schedule;

use rand_chacha::ChaCha8Rng;
use reseflow_flow::{AnchoredAction, AnchoredChunk, Diffusion, DiffusionConfig};
use reseflow_lie::geodesic_distance;

use crate::{chunk, pose};

fn diffusion() -> Diffusion {
    Diffusion::new(&DiffusionConfig::default()).unwrap()
}

/// A trajectory of random actions relative to an anchor.
fn anchored(horizon: usize, rng: &mut ChaCha8Rng) -> AnchoredChunk {
    let actions = chunk(horizon, rng);
    let see = |action: &reseflow_data::Action| AnchoredAction {
        anchor_from_gripper: action.world_from_gripper,
        opening: action.opening - 0.5,
    };
    AnchoredChunk(actions.iter().map(see).collect())
}

/// A random action relative to an anchor.
fn action(rng: &mut ChaCha8Rng) -> AnchoredAction {
    AnchoredAction { anchor_from_gripper: pose(rng), opening: 0.3 }
}

/// Radians, metres and opening alike.
fn between(a: &AnchoredAction, b: &AnchoredAction) -> f64 {
    let poses = geodesic_distance(&a.anchor_from_gripper, &b.anchor_from_gripper).d_geo();
    poses.max((a.opening - b.opening).abs())
}
