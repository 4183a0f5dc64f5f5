//! The gradient of a generic loss against central differences of fourth order, parameter by parameter and along directions through all of them.

use burn::module::{Module, ModuleMapper, Param};
use burn::tensor::{Device, Tensor};
use reseflow_net::{DriftNet, SE3ManiNet};

use crate::support::degree_laws::{NONLINEARITIES, mani_net_loss};
use crate::support::gradients::{NamedGradient, generic_loss, named_gradients};
use crate::support::laws::example;
use crate::support::mani_net::small_mani_net;
use crate::support::scene::{Cloud, Scene};
use crate::support::twists::{in_twist_form, twist_loss};
use crate::support::weights::{shaken, shaken_net};
use crate::support::{assert_small, devices, normals, rng, small, tensor, values, worse, worst_difference};

/// Length of the step along a unit vector.
const STEP: f64 = 1e-4;

/// A direction in the space of all parameters: one list of components a tensor, in the module's order.
type Direction = Vec<Vec<f64>>;

struct Advance<'a> {
    direction: std::slice::Iter<'a, Vec<f64>>,
    step: f64,
}

impl ModuleMapper for Advance<'_> {
    fn map_float<const D: usize>(&mut self, param: Param<Tensor<D>>) -> Param<Tensor<D>> {
        let components = self.direction.next().expect("a direction has every parameter");
        param.map(|weights| {
            let offset = tensor(components.clone(), weights.dims(), &weights.device());
            weights + offset * self.step
        })
    }
}

fn advanced<M: Module>(net: &M, direction: &Direction, step: f64) -> M {
    net.clone().map(&mut Advance { direction: direction.iter(), step })
}

/// `direction` with length 1, restricted to the tensors that `keep` names.
fn unit(direction: &Direction, keep: impl Fn(usize) -> bool) -> Direction {
    let mut kept: Direction = (direction.iter().enumerate())
        .map(|(index, part)| if keep(index) { part.clone() } else { vec![0.0; part.len()] })
        .collect();
    let norm = kept.iter().flatten().map(|value| value * value).sum::<f64>().sqrt();
    kept.iter_mut().flatten().for_each(|value| *value /= norm);
    kept
}

/// The network whose gradient is asked for; the same on every device.
fn network(device: &Device) -> DriftNet {
    let mut rng = rng(31);
    shaken_net(&small(), device, &mut rng)
}

/// The gradient of the generic loss by every parameter.
fn gradient(device: &Device) -> Vec<NamedGradient> {
    let tracked = device.clone().autodiff();
    let net = network(&tracked);
    let gradients = generic_loss(&net, &scenes(), &tracked).backward();
    named_gradients(&net, &gradients)
}

fn scenes() -> [Scene; 2] {
    [0, 1].map(|index| example(index, &small()))
}

/// Asserts that `gradients` are the slopes of `loss` around `net`, along several directions through all parameters and one
/// through each.
fn assert_slopes<M: Module>(
    what: &str,
    net: &M,
    gradients: &[NamedGradient],
    loss: impl Fn(&M) -> Tensor<1>,
    fewest_directions: usize,
) {
    let mut rng = rng(32);
    let mut draw =
        || -> Direction { gradients.iter().map(|(_, gradient)| normals(gradient.len(), &mut rng)).collect() };
    let mut directions: Vec<(&str, Direction)> =
        (0..3).map(|_| ("all parameters", unit(&draw(), |_| true))).collect();
    let through_each = draw();
    for (index, (parameter, _)) in gradients.iter().enumerate() {
        directions.push((parameter, unit(&through_each, |other| other == index)));
    }
    assert!(directions.len() >= fewest_directions, "only {} directions", directions.len());
    for (along, direction) in directions {
        let at = |step| values(&loss(&advanced(net, &direction, step)))[0];
        let slope = (8.0 * (at(STEP) - at(-STEP)) - at(2.0 * STEP) + at(-2.0 * STEP)) / (12.0 * STEP);
        let products = gradients.iter().zip(&direction).flat_map(|((_, gradient), direction)| {
            gradient.iter().zip(direction).map(|(gradient, direction)| gradient * direction)
        });
        let expected: f64 = products.sum();
        let error = (slope - expected).abs() / expected.abs().max(1e-2);
        assert_small(&format!("slope of {what} along {along}"), error, 1e-6);
    }
}

#[test]
fn the_gradient_is_the_slope_of_the_loss() {
    for (name, device) in devices() {
        let gradients = gradient(&device);
        let loss = |net: &DriftNet| generic_loss(net, &scenes(), &device);
        assert_slopes(&format!("{name} drift"), &network(&device), &gradients, loss, 50);
    }
}

#[test]
fn the_gradient_of_the_twist_form_is_the_slope_of_its_loss() {
    let net = |device: &Device| {
        let mut rng = rng(35);
        shaken_net(&in_twist_form(small()), device, &mut rng)
    };
    for (name, device) in devices() {
        let tracked = device.clone().autodiff();
        let tracked_net = net(&tracked);
        let gradients = twist_loss(&tracked_net, &scenes(), &tracked).backward();
        let gradients = named_gradients(&tracked_net, &gradients);
        let loss = |net: &DriftNet| twist_loss(net, &scenes(), &device);
        assert_slopes(&format!("{name} twists"), &net(&device), &gradients, loss, 50);
    }
}

#[test]
fn the_gradient_of_mani_net_is_the_slope_of_its_loss() {
    let every =
        devices().into_iter().flat_map(|of| NONLINEARITIES.map(|nonlinearity| (of.clone(), nonlinearity)));
    for ((name, device), nonlinearity) in every {
        let net = |device: &Device| {
            let mut rng = rng(33);
            let net = small_mani_net(nonlinearity).init(device, &mut rng).expect("the sizes make sense");
            shaken(net, 0.05, &mut rng)
        };
        let clouds = [30, 9].map(|count| Cloud::in_a_box(count, &mut rng(34)));
        let tracked = device.clone().autodiff();
        let tracked_net = net(&tracked);
        let gradients = mani_net_loss(&tracked_net, &clouds, &tracked).backward();
        let gradients = named_gradients(&tracked_net, &gradients);
        let loss = |net: &SE3ManiNet| mani_net_loss(net, &clouds, &device);
        assert_slopes(&format!("{name} SE3ManiNet, {nonlinearity:?},"), &net(&device), &gradients, loss, 50);
    }
}

#[test]
fn every_device_has_the_same_gradient() {
    let [flex, ndarray] = devices().map(|(_, device)| gradient(&device));
    let mut worst = 0.0;
    for ((_, flex), (_, ndarray)) in flex.iter().zip(&ndarray) {
        let norm = flex.iter().map(|value| value * value).sum::<f64>().sqrt();
        worst = worse(worst, worst_difference(flex, ndarray) / norm);
    }
    assert_small("gradients of flex and ndarray, relative", worst, 1e-9);
}
