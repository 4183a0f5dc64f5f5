//! Weights as training leaves them: nothing is exactly zero any more.

use burn::module::{Module, ModuleMapper, Param};
use burn::tensor::{Device, Tensor};
use rand_chacha::ChaCha8Rng;
use reseflow_net::{DriftNet, DriftNetConfig};

use super::{normals, tensor, values};

/// A drift model as drawn.
pub(crate) fn drawn_net(config: &DriftNetConfig, device: &Device, rng: &mut ChaCha8Rng) -> DriftNet {
    config.init(device, rng).expect("the sizes make sense")
}

/// A drift model as drawn, shaken.
pub(crate) fn shaken_net(config: &DriftNetConfig, device: &Device, rng: &mut ChaCha8Rng) -> DriftNet {
    shaken(drawn_net(config, device, rng), 0.05, rng)
}

/// `module` with independent noise of standard deviation `sigma` on every parameter, biases among them.
pub(crate) fn shaken<M: Module>(module: M, sigma: f64, rng: &mut ChaCha8Rng) -> M {
    module.map(&mut Shake { sigma, rng })
}

struct Shake<'a> {
    sigma: f64,
    rng: &'a mut ChaCha8Rng,
}

impl ModuleMapper for Shake<'_> {
    fn map_float<const D: usize>(&mut self, param: Param<Tensor<D>>) -> Param<Tensor<D>> {
        param.map(|weights| {
            let shape = weights.dims();
            let noise = normals(shape.iter().product(), self.rng);
            let moved =
                values(&weights).into_iter().zip(noise).map(|(weight, noise)| weight + self.sigma * noise);
            // A new leaf, so that a gradient arrives at it.
            tensor(moved.collect(), shape, &weights.device()).set_require_grad(weights.is_require_grad())
        })
    }
}
