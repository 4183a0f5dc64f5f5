//! Anchored coupling: the noise is that of the nearest image.

use reseflow_data::{Action, ActionChunk, FlowPair};
use reseflow_flow::{FlowError, LENGTH_SCALE_M, nearest_image};
use reseflow_lie::{BodyTwist, Vector3};

use crate::known::mapped;
use crate::{chunk, moved, pose, rng};

const HORIZON: usize = 4;

/// The chunk turned by `rad`, shifted by `metres` in each gripper's own frame and opened by `opening`.
fn off(from: &ActionChunk, rad: f64, metres: f64, opening: f64) -> ActionChunk {
    let twist = BodyTwist::new(Vector3::new(0.0, rad, 0.0), Vector3::new(0.0, metres, 0.0));
    mapped(from, |action| Action {
        world_from_gripper: action.world_from_gripper.plus(&twist),
        opening: action.opening + opening,
    })
}

fn anchored(
    images: &[ActionChunk],
    demonstration: &ActionChunk,
    weights: &[f64],
) -> Result<usize, FlowError> {
    let mut stream = rng(51);
    let pair = |image: &ActionChunk| FlowPair { noise: chunk(HORIZON, &mut stream), image: image.clone() };
    let pairs: Vec<_> = images.iter().map(pair).collect();
    nearest_image(&pairs, demonstration, weights)
}

#[test]
fn anchored_noise_is_that_of_the_nearest_image() {
    let wanted = chunk(HORIZON, &mut rng(53));
    let weights = [1.0; HORIZON];
    // Radians, metres over ℓ and openings count alike.
    let [near, far] = [0.1, 0.2];
    let kinds =
        [|by: f64| (by, 0.0, 0.0), |by: f64| (0.0, by * LENGTH_SCALE_M, 0.0), |by: f64| (0.0, 0.0, by)];
    for nearer in kinds {
        for farther in kinds {
            let [near, far] = [nearer(near), farther(far)].map(|by| off(&wanted, by.0, by.1, by.2));
            let images = [far.clone(), far.clone(), near.clone(), far.clone()];
            assert_eq!(anchored(&images, &wanted, &weights), Ok(2));
            assert_eq!(anchored(&[near, far], &wanted, &weights), Ok(0));
        }
    }
}

#[test]
fn it_goes_by_the_image_and_not_by_the_noise() {
    let mut stream = rng(54);
    let wanted = chunk(HORIZON, &mut stream);
    let pairs = [
        FlowPair { noise: wanted.clone(), image: off(&wanted, 1.0, 0.0, 0.0) },
        FlowPair { noise: off(&wanted, 1.0, 0.0, 0.0), image: off(&wanted, 0.1, 0.0, 0.0) },
    ];
    assert_eq!(nearest_image(&pairs, &wanted, &[1.0; HORIZON]), Ok(1));
}

#[test]
fn actions_without_weight_do_not_count() {
    let wanted = chunk(HORIZON, &mut rng(55));
    let (mut spoilt_end, second) = (wanted.clone(), off(&wanted, 0.1, 0.0, 0.0));
    spoilt_end.0[HORIZON - 1] = off(&wanted, 2.0, 0.0, 0.0).0[HORIZON - 1];
    let images = [spoilt_end, second];
    assert_eq!(anchored(&images, &wanted, &[1.0, 1.0, 1.0, 0.0]), Ok(0));
    assert_eq!(anchored(&images, &wanted, &[1.0, 1.0, 1.0, 1.0]), Ok(1), "control");
}

#[test]
fn the_choice_moves_with_the_world() {
    let mut stream = rng(56);
    let weights = [1.0; HORIZON];
    let mut chosen = Vec::new();
    for _ in 0..20 {
        let wanted = chunk(HORIZON, &mut stream);
        let images: Vec<_> = (0..8).map(|_| chunk(HORIZON, &mut stream)).collect();
        let world = pose(&mut stream);
        let there: Vec<_> = images.iter().map(|image| moved(&world, image)).collect();
        let here = anchored(&images, &wanted, &weights);
        assert_eq!(here, anchored(&there, &moved(&world, &wanted), &weights));
        chosen.extend(here);
    }
    chosen.sort_unstable();
    chosen.dedup();
    assert!(chosen.len() > 3, "not always the same: {chosen:?}");
}

#[test]
fn nothing_to_couple_with_and_other_horizons_are_refused() {
    let mut stream = rng(58);
    let wanted = chunk(HORIZON, &mut stream);
    let found = nearest_image(&[], &wanted, &[1.0; HORIZON]);
    assert!(matches!(found, Err(FlowError::Mismatch { got: 0, .. })), "{found:?}");
    let short = chunk(HORIZON - 1, &mut stream);
    assert!(anchored(&[short], &wanted, &[1.0; HORIZON]).is_err());
    assert!(anchored(std::slice::from_ref(&wanted), &wanted, &[1.0; HORIZON + 1]).is_err());
}
