//! The whole sampler turns with the world, to the rounding of the float type that the network computes in.
//!
//! Clouds hold f32, whose rounding of a turned scene would hide what the network does. So points lie on a grid that rotations by
//! integer quaternions of norm 9, whose matrices have entries k/9, take to one nine times as fine: both hold in f32 exactly.

use reseflow_data::{Observation, ObservationHistory, Split};
use reseflow_flow::PoseError;
use reseflow_lie::{SE3, SO3, Vector3, geodesic_distance};
use reseflow_net::Parameterisation;
use reseflow_train::{AdaptiveConfig, DeviceKind, FlowPolicy, Solver, TrainConfig, UpdateMetrics};

use crate::support::{Shelf, demonstrations, histories, tiny_model, tiny_training};

/// Where moved points lie: numbers of 24 bits reach to 4 m.
const FINE_M: f64 = 1.0 / 4_194_304.0;
/// Where the points lie that are moved: nine times as far apart.
const COARSE_M: f64 = 9.0 * FINE_M;
/// What an error of a position is relative to.
const SCENE_M: f64 = 0.15;

const SEEDS: [u64; 1] = [3407];

/// One step of Euler's rule, ten, and RK45: at its own tolerance where the network says velocities, and at a looser one where it says
/// clean poses, since following those of a hardly trained network closely takes hundreds of steps. The looser the tolerance, the more
/// the end depends on the steps' lengths, which rounding changes.
fn solvers(form: Parameterisation) -> [(&'static str, Solver); 3] {
    let adaptive = match form {
        Parameterisation::Endpoint => AdaptiveConfig { rtol: 0.03, atol: 1e-3, max_steps: 400 },
        Parameterisation::Twist => AdaptiveConfig { max_steps: 400, ..AdaptiveConfig::default() },
    };
    [
        ("one Euler step", Solver::Euler { steps: 1 }),
        ("ten Euler steps", Solver::Euler { steps: 10 }),
        ("RK45", Solver::DormandPrince(adaptive)),
    ]
}

/// Turns of 96° and 141° about axes that are none of the world's diagonals, with shifts of about a metre.
fn motions() -> [SE3; 2] {
    let motion = |xyzw: [f64; 4], shift: [f64; 3]| {
        let rotation = SO3::from_quaternion_xyzw(xyzw.map(|part| part / 3.0)).unwrap();
        SE3::new(rotation, Vector3::from(shift.map(|part| (part / FINE_M).round() * FINE_M)))
    };
    [motion([2.0, 1.0, 0.0, 2.0], [0.3, -1.2, 0.7]), motion([-2.0, 0.0, 2.0, 1.0], [-0.9, 0.4, 1.1])]
}

/// Coordinates that f32 must hold as they are, once rounding of f64 has been taken from them.
fn held(place_m: Vector3<f64>, grid_m: f64) -> [f32; 3] {
    let exact = place_m.map(|value| (value / grid_m).round() * grid_m);
    let held = exact.map(|value| value as f32);
    assert_eq!(held.map(f64::from), exact, "f32 does not hold the grid");
    held.into()
}

fn on_the_grid(observation: &Observation) -> Observation {
    let mut observation = observation.clone();
    for point in &mut observation.cloud.points {
        *point = held(Vector3::from(point.map(f64::from)), COARSE_M);
    }
    observation
}

/// The observation with the cloud moved exactly, and the gripper where `gripper` puts it.
fn moved(observation: &Observation, cloud: &SE3, gripper: &SE3) -> Observation {
    let mut moved = observation.clone();
    for point in &mut moved.cloud.points {
        let place = cloud.act(&Vector3::from(point.map(f64::from)));
        *point = held(place, FINE_M);
        let off = (Vector3::from(point.map(f64::from)) - place).amax();
        assert!(off < 1e-14, "a moved point does not lie on the grid but {off:e} m off");
    }
    moved.world_from_gripper = *gripper * observation.world_from_gripper;
    moved
}

/// How far draws from moved scenes are from the moved draws, for every scene, seed and action, ascending: the largest of the angle
/// in radians, the distance over the scene's size, and the difference of the openings.
fn deviations(
    policy: &FlowPolicy,
    seen: &[ObservationHistory],
    solver: &Solver,
    noise_follows: bool,
) -> Vec<f64> {
    let plain = policy.draw(seen, &SEEDS, solver).unwrap().samples;
    let mut all = Vec::new();
    for motion in motions() {
        // Noise is drawn about the gripper.
        let gripper = if noise_follows { motion } else { SE3::identity() };
        let turned: Vec<_> = (seen.iter())
            .map(|history| history.map(|frame| moved(frame, &motion, &gripper), |pose| gripper * *pose))
            .collect();
        let drawn = policy.draw(&turned, &SEEDS, solver).unwrap().samples;
        for (before, after) in plain.iter().flatten().zip(drawn.iter().flatten()) {
            for (before, after) in before.consensus.iter().zip(after.consensus.iter()) {
                let expected = motion * before.world_from_gripper;
                let off = geodesic_distance(&after.world_from_gripper, &expected);
                let opening = (after.opening - before.opening).abs();
                all.push(off.rotation_rad.max(off.translation_m / SCENE_M).max(opening));
            }
        }
    }
    all.sort_by(f64::total_cmp);
    all
}

/// Draws of networks that say clean poses and of such that say velocities, untrained and trained, with one step of Euler's rule,
/// with ten, and with RK45, deviate by no more than `bar` on each back end.
pub(crate) fn the_sampler_turns_with_the_world(bar: f64) {
    let (data, held_out) = (demonstrations(Split::Train, 4), demonstrations(Split::Validation, 2));
    let seen = histories(&held_out, 4);
    let seen: Vec<_> = seen.iter().map(|history| history.map(on_the_grid, SE3::clone)).collect();
    let untrained = TrainConfig { learning_rate: 0.0, ..tiny_training(1) };
    let trained = TrainConfig { warmup: 5, ..tiny_training(100) };
    for form in [Parameterisation::Endpoint, Parameterisation::Twist] {
        let mut model = tiny_model();
        model.network.decoder.parameterisation = form;
        for (name, training) in [("untrained", &untrained), ("trained", &trained)] {
            let mut training = training.clone();
            if form == Parameterisation::Twist {
                training.objective.error = PoseError::Twist;
            }
            let shelf = Shelf::new();
            let (_, journal) = shelf.train_model(name, &model, &training, &data, None).unwrap();
            if training.updates > 1 {
                let sum = |updates: &[UpdateMetrics]| updates.iter().map(|one| one.loss).sum::<f64>();
                let (first, last) = (sum(&journal.updates[..10]), sum(&journal.updates[90..]));
                assert!(last < 0.7 * first, "{form:?}: ten losses went from {first} to {last} only");
            }
            for device in [DeviceKind::Flex, DeviceKind::Ndarray] {
                let policy = FlowPolicy::load(&shelf.path(name), device).unwrap();
                for (solver_name, solver) in solvers(form) {
                    let what = format!("{name} {form:?} on {device:?}, {solver_name}");
                    let together = deviations(&policy, &seen, &solver, true);
                    let count = together.len();
                    assert_eq!(count, motions().len() * seen.len() * SEEDS.len() * 10);
                    let worst = together[count - 1];
                    // The control: noise that stays behind must not give the moved trajectory.
                    let left_behind = deviations(&policy, &seen, &solver, false)[count / 2];
                    assert!(worst <= bar, "{what}: {worst:e}");
                    assert!(left_behind > 1e-2, "{what}: noise left behind changes only {left_behind:e}");
                }
            }
        }
    }
}
