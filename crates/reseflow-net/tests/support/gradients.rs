//! A loss that depends on everything the network says, and the gradient of every parameter under its name.

use burn::module::{Module, ModuleVisitor, Param};
use burn::tensor::{Device, Gradients, Tensor};
use rand_chacha::ChaCha8Rng;
use reseflow_net::{DriftNet, HeatMap};

use super::scene::Scene;
use super::trajectory::endpoint;
use super::{normals, rng, tensor, values};

/// A random linear functional of all outputs for `scenes`.
pub(crate) fn generic_loss(net: &DriftNet, scenes: &[Scene], device: &Device) -> Tensor<1> {
    let (prediction, encoded, _) = endpoint(net, scenes, device);
    let mut rng = rng(77);
    let overlap = encoded.iter().map(|frame| HeatMap::overlap(&frame.heat)).reduce(|a, b| a + b);
    weighed(prediction.rotations, &mut rng)
        + weighed(prediction.positions_m, &mut rng)
        + weighed(prediction.openings, &mut rng)
        + weighed(prediction.node_rotations, &mut rng)
        + weighed(prediction.node_positions_m, &mut rng)
        + weighed(prediction.weights, &mut rng)
        + overlap.expect("there are frames")
}

pub(crate) fn weighed<const D: usize>(output: Tensor<D>, rng: &mut ChaCha8Rng) -> Tensor<1> {
    let weights = normals(output.dims().iter().product(), rng);
    (output.clone() * tensor(weights, output.dims(), &output.device())).sum()
}

/// A parameter's name and its gradient's values; empty where the loss does not reach it.
pub(crate) type NamedGradient = (String, Vec<f64>);

/// The gradient of every parameter, in the module's order.
pub(crate) fn named_gradients<M: Module>(module: &M, gradients: &Gradients) -> Vec<NamedGradient> {
    let mut collect = Collect { gradients, path: Vec::new(), found: Vec::new() };
    module.visit(&mut collect);
    collect.found
}

struct Collect<'a> {
    gradients: &'a Gradients,
    path: Vec<String>,
    found: Vec<NamedGradient>,
}

impl ModuleVisitor for Collect<'_> {
    fn visit_float<const D: usize>(&mut self, param: &Param<Tensor<D>>) {
        let gradient = param.val().grad(self.gradients).map_or_else(Vec::new, |gradient| values(&gradient));
        self.found.push((self.path.join("."), gradient));
    }

    fn enter_module(&mut self, name: &str, _: &str) {
        self.path.push(name.to_owned());
    }

    fn exit_module(&mut self, _: &str, _: &str) {
        self.path.pop();
    }
}
