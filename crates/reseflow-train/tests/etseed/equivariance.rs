//! The whole sampler of a trained baseline: a moved scene gives the moved trajectory, draw by draw, and in the world's frame it does not.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use reseflow_data::{Action, ActionChunk, Observation, ObservationHistory, Split};
use reseflow_flow::DiffusionFrame;
use reseflow_lie::{SE3, SO3, Vector3};
use reseflow_train::EtSeedPolicy;

use crate::support::{Shelf, demonstrations, errors, histories, tiny_config, tiny_training};

/// Moved in f64 and rounded to the f32 of files, as users would.
fn moved(world: &SE3, observation: &Observation) -> Observation {
    let mut moved = observation.clone();
    for point in &mut moved.cloud.points {
        let place: [f64; 3] = world.act(&Vector3::from(point.map(f64::from))).into();
        *point = place.map(|coordinate| coordinate as f32);
    }
    moved.world_from_gripper = *world * observation.world_from_gripper;
    moved
}

/// D_geo between the prediction on moved scenes and the moved prediction, ascending.
fn sorted_errors(policy: &EtSeedPolicy, seen: &[ObservationHistory], steps: usize) -> Vec<f64> {
    let plain = policy.predict(seen, &[3407, 3408], steps).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(99);
    let mut all = Vec::new();
    for _ in 0..4 {
        let rotation = SO3::sample_haar(&mut rng);
        let world = SE3::new(rotation, Vector3::from_fn(|_, _| StandardNormal.sample(&mut rng)));
        let turned: Vec<_> = seen
            .iter()
            .map(|history| history.map(|frame| moved(&world, frame), |pose| world * *pose))
            .collect();
        let drawn = policy.predict(&turned, &[3407, 3408], steps).unwrap();
        for (before, after) in plain.iter().flatten().zip(drawn.iter().flatten()) {
            let expected = before.consensus.iter().map(|action| Action {
                world_from_gripper: world * action.world_from_gripper,
                opening: action.opening,
            });
            all.extend(errors(&after.consensus, &ActionChunk(expected.collect())));
        }
    }
    all.sort_by(f64::total_cmp);
    all
}

#[test]
fn a_moved_scene_gives_the_moved_trajectory_of_a_trained_policy_unless_it_diffuses_in_the_world() {
    let shelf = Shelf::new();
    let data = demonstrations(Split::Train, 4);
    let held_out = demonstrations(Split::Validation, 4);
    let seen = histories(&held_out, 1);
    for (name, frame, stochastic) in [
        ("mean", DiffusionFrame::Gripper, false),
        ("stochastic", DiffusionFrame::Gripper, true),
        ("world", DiffusionFrame::World, false),
    ] {
        let mut config = tiny_config();
        config.diffusion.frame = frame;
        config.diffusion.stochastic = stochastic;
        let (_, journal) = shelf.train(name, &config, &tiny_training(80), &data, None).unwrap();
        println!("{name}: loss {:.3} to {:.3}", journal.updates[0].loss, journal.updates[79].loss);
        let policy = shelf.policy(name);
        for steps in [1, 2, 100] {
            let errors = sorted_errors(&policy, &seen, steps);
            assert_eq!(errors.len(), 4 * 4 * 2 * 10);
            let (median, typical) = (errors[errors.len() / 2], errors[errors.len() * 99 / 100]);
            println!("{name}, {steps} steps: median {median:.1e}, 99th percentile {typical:.1e}");
            if frame == DiffusionFrame::Gripper {
                assert!(typical < 1e-3, "{name}, {steps} steps: {typical}");
            } else {
                assert!(median > 0.3, "control: what the world's frame shows an invariant network, {median}");
            }
        }
    }
}
