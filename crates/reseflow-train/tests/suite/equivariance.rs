//! The whole sampler of a trained network: a moved scene gives the moved trajectory, draw by draw.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use reseflow_data::{Observation, ObservationHistory, Split};
use reseflow_lie::{SE3, SO3, Vector3, geodesic_distance};
use reseflow_train::{FlowPolicy, TrainConfig};

use crate::sampler::the_sampler_turns_with_the_world;
use crate::support::{Shelf, demonstrations, histories, tiny_training};

pub(crate) const SEEDS: [u64; 2] = [3407, 3408];

/// Rotations uniform on SO(3), shifts of about a metre.
fn motions(count: usize) -> Vec<SE3> {
    let mut rng = ChaCha8Rng::seed_from_u64(99);
    let mut motion = || {
        let rotation = SO3::sample_haar(&mut rng);
        SE3::new(rotation, Vector3::from_fn(|_, _| StandardNormal.sample(&mut rng)))
    };
    (0..count).map(|_| motion()).collect()
}

/// The cloud moved in f64 and rounded to the f32 of files, as users would; the gripper where `gripper` puts it.
fn moved(observation: &Observation, cloud: &SE3, gripper: &SE3) -> Observation {
    let mut moved = observation.clone();
    for point in &mut moved.cloud.points {
        let place: [f64; 3] = cloud.act(&Vector3::from(point.map(f64::from))).into();
        *point = place.map(|coordinate| coordinate as f32);
    }
    moved.world_from_gripper = *gripper * observation.world_from_gripper;
    moved
}

/// D_geo between the prediction on moved scenes and the moved prediction, for every scene, seed and action, ascending.
pub(crate) fn errors(
    policy: &FlowPolicy,
    seen: &[ObservationHistory],
    steps: usize,
    gripper_too: bool,
) -> Vec<f64> {
    let plain = policy.predict(seen, &SEEDS, steps).unwrap();
    let mut errors = Vec::new();
    for motion in motions(5) {
        let gripper = if gripper_too { motion } else { SE3::identity() };
        let turned: Vec<_> = (seen.iter())
            .map(|history| history.map(|frame| moved(frame, &motion, &gripper), |pose| gripper * *pose))
            .collect();
        let drawn = policy.predict(&turned, &SEEDS, steps).unwrap();
        for (before, after) in plain.iter().flatten().zip(drawn.iter().flatten()) {
            for (before, after) in before.consensus.iter().zip(after.consensus.iter()) {
                let expected = motion * before.world_from_gripper;
                errors.push(geodesic_distance(&after.world_from_gripper, &expected).d_geo());
                assert!(!gripper_too || (after.opening - before.opening).abs() < 1e-3);
            }
        }
    }
    errors.sort_by(f64::total_cmp);
    errors
}

#[test]
fn a_moved_scene_gives_the_moved_trajectory_of_a_trained_policy() {
    let shelf = Shelf::new();
    let data = demonstrations(Split::Train, 6);
    let config = TrainConfig { warmup: 5, ..tiny_training(100) };
    let (_, journal) = shelf.train("policy", &config, &data, None).unwrap();
    let policy = shelf.policy("policy");
    println!("loss {:.3} to {:.3}", journal.updates[0].loss, journal.updates[99].loss);
    assert!(journal.updates[99].loss < 0.5 * journal.updates[0].loss, "the network has learned something");

    let held_out = demonstrations(Split::Validation, 6);
    let seen: Vec<_> = [0, 1, 5].into_iter().flat_map(|step| histories(&held_out, step)).collect();
    for steps in [1, 10] {
        let together = errors(&policy, &seen, steps, true);
        let count = together.len();
        assert_eq!(count, 5 * 18 * SEEDS.len() * 10);
        let (typical, worst) = (together[count * 99 / 100], together[count - 1]);
        println!("{steps} steps: 99th percentile {typical:.2e}, worst {worst:.2e}");
        assert!(typical <= 1e-4, "{steps} steps: {typical}");

        // The control: noise about a gripper that stays behind must not give the moved trajectory.
        let left_behind = errors(&policy, &seen, steps, false);
        let median = left_behind[count / 2];
        println!("{steps} steps, gripper left behind: median {median:.2e}");
        assert!(median > 1e-2, "{steps} steps: moving the cloud alone changes too little: {median}");
    }
}

#[test]
fn the_whole_sampler_turns_with_the_world_to_rounding() {
    the_sampler_turns_with_the_world(1e-5);
}
