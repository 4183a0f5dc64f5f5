//! The objective against an oracle written out in the scalar group, on poses of the tensors' own f64.

use burn::tensor::{DType, Device, Tensor, TensorData};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use reseflow_flow::{
    EndpointTargets, FlowError, LENGTH_SCALE_M, LossContext, LossParts, NodeTargets, ObjectiveConfig, Path,
    PoseError, endpoint_loss,
};
use reseflow_lie::{BodyTwist, SE3, Vector3, geodesic_distance};

use crate::{pose, rng};

pub(crate) fn devices() -> [Device; 2] {
    [Device::flex(), ndarray()]
}

#[expect(deprecated, reason = "burn keeps ndarray until 0.23, and we promise that it works until then")]
fn ndarray() -> Device {
    Device::ndarray()
}

pub(crate) fn tensor<const D: usize>(values: Vec<f64>, shape: [usize; D], device: &Device) -> Tensor<D> {
    Tensor::from_data(TensorData::new(values, shape), (device, DType::F64))
}

pub(crate) fn rotations(poses: &[SE3], device: &Device) -> Tensor<3> {
    let rows = poses.iter().flat_map(|pose| {
        let matrix = pose.rotation.matrix().transpose();
        matrix.iter().copied().collect::<Vec<_>>()
    });
    tensor(rows.collect(), [poses.len(), 3, 3], device)
}

fn positions(poses: &[SE3], device: &Device) -> Tensor<2> {
    let rows = poses.iter().flat_map(|pose| pose.translation.iter().copied().collect::<Vec<_>>());
    tensor(rows.collect(), [poses.len(), 3], device)
}

/// N actions with K nodes each, predicted and wanted.
#[derive(Clone)]
pub(crate) struct Batch {
    pub(crate) predicted: Vec<(SE3, f64)>,
    /// `[N·K]`.
    pub(crate) nodes: Vec<SE3>,
    pub(crate) targets: Vec<(SE3, f64)>,
    pub(crate) weights: Vec<f64>,
    pub(crate) overlap: f64,
}

impl Batch {
    pub(crate) fn random(actions: usize, nodes: usize, rng: &mut ChaCha8Rng) -> Batch {
        Batch {
            predicted: (0..actions).map(|_| (pose(rng), rng.random())).collect(),
            nodes: (0..actions * nodes).map(|_| pose(rng)).collect(),
            targets: (0..actions).map(|_| (pose(rng), rng.random())).collect(),
            weights: (0..actions).map(|_| rng.random_range(0.1..1.0)).collect(),
            overlap: rng.random(),
        }
    }

    fn loss(&self, config: &ObjectiveConfig, device: &Device) -> LossParts {
        self.loss_of(&self.predicted_tensors(device), &self.node_tensors(device), config, device)
    }

    fn loss_of(
        &self,
        predicted: &EndpointTargets,
        nodes: &NodeTargets,
        config: &ObjectiveConfig,
        device: &Device,
    ) -> LossParts {
        let context = self.context(Path::Screw, &self.targets, device);
        endpoint_loss(predicted, nodes, &actions(&self.targets, device), &context, config)
    }

    /// What the batch is judged by, where the network was shown `states`.
    pub(crate) fn context(&self, path: Path, states: &[(SE3, f64)], device: &Device) -> LossContext {
        LossContext {
            path,
            states: actions(states, device),
            weights: tensor(self.weights.clone(), [self.weights.len()], device),
            overlap: tensor(vec![self.overlap], [1], device),
        }
    }

    pub(crate) fn predicted_tensors(&self, device: &Device) -> EndpointTargets {
        actions(&self.predicted, device)
    }

    pub(crate) fn node_tensors(&self, device: &Device) -> NodeTargets {
        NodeTargets { rotations: rotations(&self.nodes, device), positions_m: positions(&self.nodes, device) }
    }

    /// The total and its consensus part, by hand, from the squared error of an action's predicted pose.
    pub(crate) fn oracle(&self, config: &ObjectiveConfig, squared: impl Fn(&SE3, usize) -> f64) -> [f64; 2] {
        let error = |pose: &SE3, row: usize| match config.pseudo_huber {
            Some(c) => 2.0 * c * ((squared(pose, row) + c * c).sqrt() - c),
            None => squared(pose, row),
        };
        let all: f64 = self.weights.iter().sum();
        let per_action = self.nodes.len() / self.predicted.len();
        let (mut consensus, mut nodes, mut opening) = (0.0, 0.0, 0.0);
        for (row, (_, wanted_opening)) in self.targets.iter().enumerate() {
            let share = self.weights[row] / all;
            consensus += share * error(&self.predicted[row].0, row);
            opening += share * (self.predicted[row].1 - wanted_opening).powi(2);
            for node in &self.nodes[row * per_action..(row + 1) * per_action] {
                nodes += share * error(node, row) / per_action as f64;
            }
        }
        let total = consensus + config.nodes * nodes + config.opening * opening;
        [total + config.overlap * self.overlap, consensus]
    }
}

/// ½ ‖R̂ − R‖²_F = 4 sin²(θ/2), and the offset in units of the length scale.
fn pose_error(predicted: &SE3, target: &SE3) -> f64 {
    let apart = geodesic_distance(predicted, target);
    4.0 * (apart.rotation_rad / 2.0).sin().powi(2) + (apart.translation_m / LENGTH_SCALE_M).powi(2)
}

pub(crate) fn actions(actions: &[(SE3, f64)], device: &Device) -> EndpointTargets {
    let poses: Vec<_> = actions.iter().map(|action| action.0).collect();
    EndpointTargets {
        rotations: rotations(&poses, device),
        positions_m: positions(&poses, device),
        openings: tensor(actions.iter().map(|action| action.1).collect(), [actions.len(), 1], device),
    }
}

pub(crate) fn number(tensor: &Tensor<1>) -> f64 {
    tensor.clone().into_scalar::<f64>()
}

pub(crate) const WEIGHTS: ObjectiveConfig =
    ObjectiveConfig { error: PoseError::Chordal, pseudo_huber: None, nodes: 0.7, opening: 0.4, overlap: 0.2 };
const ROBUST: ObjectiveConfig = ObjectiveConfig { pseudo_huber: Some(0.3), ..WEIGHTS };

#[test]
fn the_objective_is_what_it_says() {
    let mut rng = rng(41);
    for device in devices() {
        for (actions, nodes) in [(1, 1), (7, 4), (20, 3)] {
            let batch = Batch::random(actions, nodes, &mut rng);
            for config in [ObjectiveConfig::default(), WEIGHTS, ROBUST] {
                let loss = batch.loss(&config, &device);
                let to_target = |pose: &SE3, row: usize| pose_error(pose, &batch.targets[row].0);
                let [total, consensus] = batch.oracle(&config, to_target);
                assert!((number(&loss.total) - total).abs() < 1e-12 * total, "{total}");
                assert!((number(&loss.consensus) - consensus).abs() < 1e-12 * consensus, "{consensus}");
            }
        }
    }
}

#[test]
fn a_small_error_counts_its_squared_angle() {
    let mut rng = rng(42);
    let angle = 1e-3;
    let mut batch = Batch::random(5, 1, &mut rng);
    for (predicted, target) in batch.predicted.iter_mut().zip(&batch.targets) {
        let twist = BodyTwist::new(Vector3::new(0.0, angle, 0.0), Vector3::zeros());
        *predicted = (target.0.plus(&twist), target.1);
    }
    let [device, _] = devices();
    let consensus = number(&batch.loss(&ObjectiveConfig::default(), &device).consensus);
    assert!((consensus / (angle * angle) - 1.0).abs() < 1e-6, "{consensus:e}");
}

/// A batch whose every prediction is its target.
fn perfect(rng: &mut ChaCha8Rng) -> Batch {
    let mut batch = Batch::random(6, 4, rng);
    batch.predicted = batch.targets.clone();
    batch.nodes = batch.targets.iter().flat_map(|target| [target.0; 4]).collect();
    batch.overlap = 0.0;
    batch
}

#[test]
fn the_target_itself_costs_nothing_and_pulls_nowhere() {
    let batch = perfect(&mut rng(43));
    for device in devices() {
        let tracked = device.autodiff();
        let mut predicted = batch.predicted_tensors(&tracked);
        predicted.rotations = predicted.rotations.require_grad();
        predicted.positions_m = predicted.positions_m.require_grad();
        predicted.openings = predicted.openings.require_grad();
        let mut nodes = batch.node_tensors(&tracked);
        nodes.rotations = nodes.rotations.require_grad();
        nodes.positions_m = nodes.positions_m.require_grad();
        let loss = batch.loss_of(&predicted, &nodes, &WEIGHTS, &tracked);
        assert_eq!([number(&loss.total), number(&loss.consensus)], [0.0; 2]);
        let gradients = loss.total.backward();
        let of_rotations = [&predicted.rotations, &nodes.rotations]
            .map(|input| input.grad(&gradients).expect("the rotations are tracked").abs().max());
        let of_vectors = [&predicted.positions_m, &nodes.positions_m, &predicted.openings]
            .map(|input| input.grad(&gradients).expect("the vectors are tracked").abs().max());
        for largest in of_rotations.iter().chain(&of_vectors) {
            assert_eq!(number(largest), 0.0);
        }
    }
}

#[test]
fn every_term_pulls_on_what_it_is_about() {
    let mut rng = rng(44);
    let [device, _] = devices();
    let off = BodyTwist::new(Vector3::new(0.1, 0.0, 0.2), Vector3::new(0.01, 0.0, 0.0));
    let perfect = perfect(&mut rng);
    let spoilt = |spoil: fn(&mut Batch, &BodyTwist)| {
        let mut batch = perfect.clone();
        spoil(&mut batch, &off);
        let loss = batch.loss(&WEIGHTS, &device);
        [number(&loss.total), number(&loss.consensus)]
    };
    let [total, consensus] = spoilt(|batch, off| batch.predicted[2].0 = batch.predicted[2].0.plus(off));
    assert!(total > 1e-4 && total == consensus);
    let others: [fn(&mut Batch, &BodyTwist); 3] = [
        |batch, off| batch.nodes[9] = batch.nodes[9].plus(off),
        |batch, _| batch.predicted[1].1 += 0.1,
        |batch, _| batch.overlap = 0.3,
    ];
    for spoil in others {
        let [total, consensus] = spoilt(spoil);
        assert!(total > 1e-4 && consensus == 0.0, "{total} {consensus}");
    }
}

#[test]
fn an_action_without_weight_does_not_count_and_only_ratios_matter() {
    let mut rng = rng(45);
    for device in devices() {
        let batch = Batch::random(6, 4, &mut rng);
        let total = |batch: &Batch| number(&batch.loss(&WEIGHTS, &device).total);

        let mut ignored = batch.clone();
        (ignored.weights[1], ignored.weights[4]) = (0.0, 0.0);
        let mut otherwise = ignored.clone();
        for row in [1, 4] {
            otherwise.predicted[row] = (pose(&mut rng), 0.0);
            otherwise.targets[row] = (pose(&mut rng), 1.0);
            otherwise.nodes[row * 4] = pose(&mut rng);
        }
        assert_eq!(total(&ignored), total(&otherwise));
        otherwise.predicted[0].0 = pose(&mut rng);
        assert_ne!(total(&ignored), total(&otherwise), "control: the first action counts");

        let mut scaled = batch.clone();
        scaled.weights.iter_mut().for_each(|weight| *weight *= 8.0);
        assert!((total(&scaled) - total(&batch)).abs() < 1e-12 * total(&batch));

        // A tenth of the weight is a tenth of the pull.
        let pull = |weight: f64| {
            let mut batch = batch.clone();
            batch.weights = vec![1.0, 1.0, 1.0, 1.0, 1.0, weight];
            let tracked = device.clone().autodiff();
            let mut predicted = batch.predicted_tensors(&tracked);
            predicted.positions_m = predicted.positions_m.require_grad();
            let loss = batch.loss_of(&predicted, &batch.node_tensors(&tracked), &WEIGHTS, &tracked);
            let gradients = loss.total.backward();
            let gradient = predicted.positions_m.grad(&gradients).expect("the positions are tracked");
            let rows = gradient.square().sum_dim(1).sqrt().try_into_vec_as::<f64>().expect("a float tensor");
            rows[5] / rows[0]
        };
        assert!((pull(0.1) / pull(1.0) - 0.1).abs() < 1e-12);
    }
}

#[test]
fn pseudo_huber_is_the_square_of_small_errors_and_in_proportion_to_large_ones() {
    let [device, _] = devices();
    let mut batch = Batch::random(1, 1, &mut rng(46));
    let mut loss = |metres: f64, c: f64| {
        let offset = BodyTwist::new(Vector3::zeros(), Vector3::new(metres, 0.0, 0.0));
        batch.predicted[0].0 = batch.targets[0].0.plus(&offset);
        number(&batch.loss(&ObjectiveConfig { pseudo_huber: Some(c), ..WEIGHTS }, &device).consensus)
    };
    let error = |metres: f64| metres / LENGTH_SCALE_M;
    assert!((loss(1e-4, 1.0) / error(1e-4).powi(2) - 1.0).abs() < 1e-6);
    let slope = (loss(300.0, 0.2) - loss(200.0, 0.2)) / (error(300.0) - error(200.0));
    assert!((slope - 0.4).abs() < 1e-6, "2c, not {slope}");
}

#[test]
fn a_batch_in_which_nothing_counts_costs_its_overlap_and_pulls_nowhere() {
    for device in devices() {
        let mut batch = Batch::random(4, 2, &mut rng(47));
        batch.weights = vec![0.0; 4];
        let tracked = device.autodiff();
        let mut predicted = batch.predicted_tensors(&tracked);
        predicted.positions_m = predicted.positions_m.require_grad();
        let loss = batch.loss_of(&predicted, &batch.node_tensors(&tracked), &WEIGHTS, &tracked);
        assert_eq!(number(&loss.consensus), 0.0);
        assert!((number(&loss.total) - WEIGHTS.overlap * batch.overlap).abs() < 1e-15);
        let gradients = loss.total.backward();
        let pull = predicted.positions_m.grad(&gradients).expect("the positions are tracked");
        assert_eq!(number(&pull.abs().max()), 0.0);
    }
}

#[test]
fn a_weight_or_a_scale_that_makes_no_sense_is_named() {
    type Spoil = fn(&mut ObjectiveConfig, f64);
    let cases: [(&str, Spoil, &[f64]); 4] = [
        ("nodes", |config, value| config.nodes = value, &[-0.5, f64::NAN, f64::INFINITY]),
        ("opening", |config, value| config.opening = value, &[-0.5, f64::NAN, f64::INFINITY]),
        ("overlap", |config, value| config.overlap = value, &[-0.5, f64::NAN, f64::INFINITY]),
        ("pseudo_huber", |config, value| config.pseudo_huber = Some(value), &[0.0, -1.0, f64::NAN]),
    ];
    assert_eq!(ROBUST.validate(), Ok(()));
    for (key, spoil, values) in cases {
        for &value in values {
            let mut config = ObjectiveConfig::default();
            spoil(&mut config, value);
            let Err(FlowError::Config(text)) = config.validate() else { panic!("{key} = {value} is taken") };
            assert!(
                text.contains(&format!("objective.{key}")) && text.contains(&value.to_string()),
                "{text}"
            );
        }
    }
}
