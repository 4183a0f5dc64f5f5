//! The paper's squared twist, of both parameterisations, against an oracle written out in the scalar group.

use burn::tensor::{Device, Tensor};
use rand::RngExt;
use reseflow_data::{Action, ActionChunk};
use reseflow_flow::{
    ActionVelocity, LENGTH_SCALE_M, ObjectiveConfig, Path, PoseError, TwistTargets, endpoint_loss, twist_loss,
};
use reseflow_lie::{BodyTwist, SE3, Vector3};

use crate::objective::{Batch, WEIGHTS, actions, devices, number, tensor};
use crate::{PATHS, pose, rng};

const TWIST: ObjectiveConfig = ObjectiveConfig { error: PoseError::Twist, ..WEIGHTS };
const ROBUST: ObjectiveConfig = ObjectiveConfig { pseudo_huber: Some(0.5), ..TWIST };

/// The body velocity of `path` from `noise` to `data` at flow time `t`.
fn velocity(path: Path, noise: &SE3, data: &SE3, t: f64) -> ActionVelocity {
    let chunk = |pose: &SE3| ActionChunk(vec![Action { world_from_gripper: *pose, opening: 0.0 }]);
    path.velocity(&chunk(noise), &chunk(data), t).expect("equal horizons").0[0]
}

fn between(path: Path, noise: &SE3, data: &SE3, t: f64) -> SE3 {
    match path {
        Path::Screw => noise.interpolate_screw(data, t),
        Path::Product => noise.interpolate_product(data, t),
    }
}

#[test]
fn in_endpoint_form_it_is_the_squared_twist_weighted_by_what_is_left_of_the_time() {
    let mut rng = rng(101);
    for device in devices() {
        for path in PATHS {
            for config in [TWIST, ROBUST] {
                let batch = Batch::random(6, 3, &mut rng);
                let noise: Vec<SE3> = (0..6).map(|_| pose(&mut rng)).collect();
                let times: Vec<f64> = (0..6).map(|_| rng.random_range(0.0..0.99)).collect();
                let state = |row: usize| between(path, &noise[row], &batch.targets[row].0, times[row]);
                let states: Vec<_> = (0..6).map(|row| (state(row), 0.0)).collect();

                // The drift is the velocity, now, of the path that leads from the state to the endpoint in the time left.
                let squared = |predicted: &SE3, row: usize| {
                    let left = 1.0 - times[row];
                    let drift = velocity(path, &states[row].0, predicted, 0.0) * (1.0 / left);
                    let wanted = velocity(path, &noise[row], &batch.targets[row].0, times[row]);
                    left * left * (drift - wanted).squared_norm()
                };
                let [total, consensus] = batch.oracle(&config, squared);
                let loss = endpoint_loss(
                    &batch.predicted_tensors(&device),
                    &batch.node_tensors(&device),
                    &actions(&batch.targets, &device),
                    &batch.context(path, &states, &device),
                    &config,
                );
                assert!((number(&loss.total) / total - 1.0).abs() < 1e-9, "{path:?}: {total}");
                assert!((number(&loss.consensus) / consensus - 1.0).abs() < 1e-9, "{path:?}: {consensus}");
            }
        }
    }
}

#[test]
fn an_endpoint_that_is_right_costs_nothing_even_at_the_end_of_time() {
    let mut rng = rng(102);
    for device in devices() {
        for path in PATHS {
            let mut batch = Batch::random(4, 2, &mut rng);
            batch.predicted = batch.targets.clone();
            batch.nodes = batch.targets.iter().flat_map(|target| [target.0; 2]).collect();
            let tracked = device.clone().autodiff();
            let mut predicted = batch.predicted_tensors(&tracked);
            predicted.rotations = predicted.rotations.require_grad();
            predicted.positions_m = predicted.positions_m.require_grad();
            // t = 1: the state is the target is the prediction.
            let context = batch.context(path, &batch.targets, &tracked);
            let targets = actions(&batch.targets, &tracked);
            let loss = endpoint_loss(&predicted, &batch.node_tensors(&tracked), &targets, &context, &ROBUST);
            assert!(number(&loss.consensus) < 1e-20);
            let gradients = loss.total.backward();
            let rotation =
                predicted.rotations.grad(&gradients).expect("the rotations are tracked").abs().max();
            let position = predicted.positions_m.grad(&gradients).expect("the positions are tracked");
            for largest in [number(&rotation), number(&position.abs().max())] {
                assert!(largest < 1e-9, "{largest}");
            }
        }
    }
}

fn twists(velocities: &[ActionVelocity], device: &Device) -> Tensor<2> {
    let rows =
        velocities.iter().flat_map(|velocity| velocity.twist.vector6().iter().copied().collect::<Vec<_>>());
    tensor(rows.collect(), [velocities.len(), 6], device)
}

fn openings(velocities: &[ActionVelocity], device: &Device) -> Tensor<2> {
    tensor(velocities.iter().map(|velocity| velocity.opening).collect(), [velocities.len(), 1], device)
}

#[test]
fn in_twist_form_it_is_the_squared_distance_of_body_twists() {
    let mut rng = rng(103);
    let mut velocities = |count: usize| -> Vec<ActionVelocity> {
        let mut vector = || Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0));
        let mut velocity =
            |_| ActionVelocity { twist: BodyTwist::new(vector(), vector()), opening: vector().x };
        (0..count).map(&mut velocity).collect()
    };
    for device in devices() {
        for config in [TWIST, ROBUST] {
            let (predicted, nodes, targets) = (velocities(5), velocities(15), velocities(5));
            let batch = Batch::random(5, 3, &mut crate::rng(104));
            let context = batch.context(Path::Screw, &batch.targets, &device);
            let of = |all: &[ActionVelocity]| TwistTargets {
                twists: twists(all, &device),
                openings: openings(all, &device),
            };
            let loss = twist_loss(&of(&predicted), twists(&nodes, &device), &of(&targets), &context, &config);

            let error = |from: &ActionVelocity, to: &ActionVelocity| {
                let off = from.twist - to.twist;
                let squared = off.angular.norm_squared() + off.linear.norm_squared() / LENGTH_SCALE_M.powi(2);
                config.pseudo_huber.map_or(squared, |c| 2.0 * c * ((squared + c * c).sqrt() - c))
            };
            let all: f64 = batch.weights.iter().sum();
            let (mut consensus, mut of_nodes, mut opening) = (0.0, 0.0, 0.0);
            for row in 0..5 {
                let share = batch.weights[row] / all;
                consensus += share * error(&predicted[row], &targets[row]);
                opening += share * (predicted[row].opening - targets[row].opening).powi(2);
                for node in &nodes[3 * row..3 * row + 3] {
                    of_nodes += share * error(node, &targets[row]) / 3.0;
                }
            }
            let total = consensus + 0.7 * of_nodes + 0.4 * opening + 0.2 * batch.overlap;
            assert!((number(&loss.consensus) / consensus - 1.0).abs() < 1e-12, "{consensus}");
            assert!((number(&loss.total) / total - 1.0).abs() < 1e-12, "{total}");
        }
    }
}
