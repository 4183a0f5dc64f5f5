//! What the kernels are taught: targets, levels, windows, and an objective that sees small errors.

use std::collections::BTreeSet;
use std::path::Path;

use burn::module::{Module, ModuleVisitor, Param};
use burn::optim::GradientsParams;
use burn::tensor::{Tensor, TensorData};
use reseflow_data::{Dataset, Window};
use reseflow_flow::{Diffusion, EndpointTargets, LeftFactor};
use reseflow_lie::geodesic_distance;
use reseflow_lie_tensor::so3;
use reseflow_net::Symmetry;

use super::{HORIZON, config, data, device, net, rng};
use crate::etseed::batch::{Example, draw, loss};
use crate::etseed::objective::left_factor_loss;
use crate::{AugmentConfig, DeviceKind, EtSeedConfig, Resume, TrainConfig, TrainRequest};

fn examples(data: &Dataset, config: &EtSeedConfig, count: usize) -> Vec<Example> {
    let train = TrainConfig {
        batch_size: count,
        shards: 1,
        first_window_share: 0.0,
        augment: AugmentConfig::NONE,
        ..TrainConfig::default()
    };
    let request = TrainRequest {
        model: config,
        train: &train,
        demonstrations: data,
        mixture: None,
        validation: None,
        start: None,
        resume: Resume::Never,
        device: DeviceKind::Cpu,
        out: Path::new("nowhere"),
    };
    draw(&request, &mut rng(3)).unwrap()
}

/// The whole relative transform, and not the factor of the noise alone, is the target.
#[test]
fn the_target_of_every_level_is_the_demonstration_itself() {
    let (data, config) = (data(3), config());
    let diffusion = Diffusion::new(&config.diffusion).unwrap();
    for example in examples(&data, &config, 40) {
        let wanted: Vec<_> = example.window.targets(&data.episodes, HORIZON).collect();
        let placed = example.view.anchor.place(&example.clean);
        for (at, wanted) in wanted.iter().enumerate() {
            let error = |pose| geodesic_distance(&pose, &wanted.action.world_from_gripper).d_geo();
            assert!(error(placed.0[at].world_from_gripper) < 1e-9);
            let (noisy, clean) = (&example.noisy.0[at], &example.clean.0[at]);
            let back = LeftFactor::between(noisy, clean).apply(noisy);
            assert!(error(example.view.anchor.world_from_anchor * back.anchor_from_gripper) < 1e-9);
            // 0.5 rad is ten times γ: the noisy pose is where its level says.
            let about = diffusion.shrunk(clean, example.level).anchor_from_gripper;
            assert!(geodesic_distance(&noisy.anchor_from_gripper, &about).d_geo() < 0.5);
        }
    }
}

#[test]
fn a_tenth_of_the_windows_is_for_the_last_step_and_the_other_levels_are_uniform() {
    const COUNT: usize = 4000;
    let levels: Vec<usize> =
        examples(&data(2), &config(), COUNT).iter().map(|example| example.level).collect();
    let share =
        |is: &dyn Fn(usize) -> bool| levels.iter().filter(|level| is(**level)).count() as f64 / COUNT as f64;
    // Five standard errors.
    assert!((share(&|level| level == 1) - 0.1).abs() < 5.0 * (0.09 / COUNT as f64).sqrt());
    for first in (2..100).step_by(11) {
        let expected = 0.9 * 11.0 / 99.0;
        let found = share(&|level| (first..first + 11).contains(&level));
        assert!((found - expected).abs() < 5.0 * (expected / COUNT as f64).sqrt(), "{first}: {found}");
    }
    assert!(levels.iter().all(|level| (1..=100).contains(level)) && levels.contains(&100));
}

#[test]
fn the_noisiest_levels_have_their_share_of_what_is_not_for_the_last_step() {
    const COUNT: usize = 4000;
    for (steps, least) in [(100, 91), (2, 2)] {
        let mut config = EtSeedConfig { noisiest_share: 0.3, ..config() };
        config.diffusion.steps = steps;
        let drawn = examples(&data(2), &config, COUNT);
        let found = drawn.iter().filter(|example| example.level >= least).count() as f64 / COUNT as f64;
        let of_the_rest = (steps + 1 - least) as f64 / (steps - 1) as f64;
        let expected = 0.9 * (0.3 + 0.7 * of_the_rest);
        // Five standard errors.
        assert!((found - expected).abs() < 5.0 * (expected / COUNT as f64).sqrt(), "{steps}: {found}");
        assert!(drawn.iter().all(|example| (1..=steps).contains(&example.level)));
    }
}

/// Scenes, levels, targets and weights of a batch belong together example by example; each kernel judges its own levels.
#[test]
fn the_loss_of_a_mixed_batch_is_the_mean_of_what_its_examples_give_alone() {
    let config = config();
    let net = net(&config, &device());
    let drawn = examples(&data(3), &EtSeedConfig { last_step_share: 0.4, ..config.clone() }, 12);
    let of = |examples: &[Example]| loss(&net, examples, &config, &device()).unwrap().into_scalar::<f64>();
    let mut expected = 0.0;
    for is_last in [false, true] {
        let group: Vec<&Example> = drawn.iter().filter(|example| (example.level == 1) == is_last).collect();
        assert!(group.len() > 1, "both kernels have examples");
        let weight = |example: &Example| example.weights.iter().sum::<f64>();
        let total: f64 = group.iter().map(|example| weight(example)).sum();
        let alone = |example: &&Example| weight(example) / total * of(std::slice::from_ref(*example));
        expected += group.len() as f64 / 12.0 * group.iter().map(alone).sum::<f64>();
    }
    let found = of(&drawn);
    assert!((found - expected).abs() < 1e-5 * expected, "{found}, expected {expected}");
}

/// Ends of episodes that are not cumulative gave seven windows of five hundred steps.
#[test]
fn every_step_of_every_episode_is_drawn() {
    let data = data(50);
    assert_eq!(Window::all(&data.episodes).len(), 500);
    let seen: BTreeSet<(usize, usize)> = examples(&data, &config(), 4000)
        .iter()
        .map(|example| (example.window.episode, example.window.step))
        .collect();
    // 500 e⁻⁸ windows are missed on average.
    assert!(seen.len() >= 497, "{}", seen.len());
}

/// An `acos` clamped at 1 − 1e-6 sees no error below 1.4e-3 rad.
#[test]
fn small_rotations_are_seen_and_have_a_gradient() {
    let device = device().autodiff();
    for angle in [3e-4, 1e-3, 0.1, 2.0] {
        let omega =
            Tensor::<2>::from_data(TensorData::new(vec![angle, 0.0, 0.0], [1, 3]), &device).require_grad();
        let zero = Tensor::zeros([1, 3], &device);
        let opening = || Tensor::zeros([1, 1], &device);
        let predicted = EndpointTargets {
            rotations: so3::exp(omega.clone()),
            positions_m: zero.clone(),
            openings: opening(),
        };
        let targets = EndpointTargets {
            rotations: so3::exp(zero.clone()),
            positions_m: zero.clone().add_scalar(0.03),
            openings: opening().add_scalar(1.0),
        };
        let weights = || Tensor::ones([1], &device);
        let loss = left_factor_loss(&predicted, &targets, weights(), 0.25);
        // 0.03 m on three axes over ℓ = 0.15 m, and a quarter for the opening.
        let rest = 0.2 * 3f64.sqrt() + 0.25;
        let error = loss.clone().into_scalar::<f64>() - rest - angle;
        assert!(error.abs() < 1e-3 * angle + 1e-6, "{angle}: {error}");
        let gradients = loss.backward();
        let gradient = omega.grad(&gradients).unwrap().try_to_vec_as::<f64>().unwrap();
        assert!((gradient[0] - 1.0).abs() < 1e-2, "{angle}: {gradient:?}");
    }
}

#[test]
fn padded_actions_count_by_their_weight() {
    let device = device();
    let poses = |positions: Vec<f64>| EndpointTargets {
        rotations: so3::exp(Tensor::zeros([2, 3], &device)),
        positions_m: Tensor::from_data(TensorData::new(positions, [2, 3]), &device),
        openings: Tensor::zeros([2, 1], &device),
    };
    let (predicted, targets) = (poses(vec![0.15, 0.0, 0.0, 0.0, 0.3, 0.0]), poses(vec![0.0; 6]));
    let weights = Tensor::from_data(TensorData::new(vec![1.0, 0.1], [2]), &device);
    let loss = left_factor_loss(&predicted, &targets, weights, 1.0).into_scalar::<f64>();
    assert!((loss - (1.0 + 0.1 * 2.0) / 1.1).abs() < 1e-5, "{loss}");
}

#[test]
fn a_value_out_of_range_is_refused_by_its_key() {
    let good = config();
    good.validate().unwrap();
    let with = |change: &dyn Fn(&mut EtSeedConfig)| {
        let mut config = good.clone();
        change(&mut config);
        config.validate().unwrap_err().to_string()
    };
    assert!(with(&|config| config.last_step_share = 1.5).contains("baseline.last_step_share"));
    assert!(with(&|config| config.opening = f64::NAN).contains("baseline.opening"));
    assert!(with(&|config| config.diffusion.steps = 0).contains("diffusion.steps"));
    assert!(with(&|config| config.network.encoder.nodes = 0).contains("encoder.nodes"));
    for symmetry in [Symmetry::Upright, Symmetry::None] {
        assert!(with(&|config| config.network.symmetry = symmetry).contains("model.network.symmetry"));
    }
    let text = toml::to_string(&good).unwrap();
    assert_eq!(toml::from_str::<EtSeedConfig>(&text).unwrap(), good);
    assert!(toml::from_str::<EtSeedConfig>("last_step = 1").unwrap_err().to_string().contains("last_step"));
}

/// The names of the parameters without a gradient.
struct Lacking<'a> {
    gradients: &'a GradientsParams,
    path: Vec<String>,
    found: Vec<String>,
}

impl ModuleVisitor for Lacking<'_> {
    fn visit_float<const D: usize>(&mut self, param: &Param<Tensor<D>>) {
        if self.gradients.get::<D>(param.id).is_none() {
            self.found.push(self.path.join("."));
        }
    }

    fn enter_module(&mut self, name: &str, _: &str) {
        self.path.push(name.to_owned());
    }

    fn exit_module(&mut self, _: &str, _: &str) {
        self.path.pop();
    }
}

/// The invariant kernel answers with scalars, so what its last layer gathers as vectors goes nowhere.
#[test]
fn every_parameter_has_a_gradient_but_for_the_last_vectors_of_the_invariant_kernel() {
    let (config, device) = (config(), device().autodiff());
    let net = net(&config, &device);
    let drawn = examples(&data(3), &EtSeedConfig { last_step_share: 0.4, ..config.clone() }, 12);
    let gradients = loss(&net, &drawn, &config, &device).unwrap().backward();
    let gradients = GradientsParams::from_grads(gradients, &net);
    let mut lacking = Lacking { gradients: &gradients, path: Vec::new(), found: Vec::new() };
    net.visit(&mut lacking);
    let expected = ["self_attention", "node_attention"]
        .map(|attention| format!("invariant.trunk.{attention}.1.vector_value.weight"));
    assert_eq!(lacking.found, expected);
}
