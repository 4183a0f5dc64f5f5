//! Clipping by the global norm (burn's own clips tensor by tensor).

use burn::module::{Module, ModuleVisitor, Param};
use burn::optim::GradientsParams;
use burn::tensor::Tensor;

/// Scales all gradients by one factor so that their joint norm is at most `limit`; returns the norm before.
pub(crate) fn clip_global_norm<M: Module>(model: &M, gradients: &mut GradientsParams, limit: f64) -> f64 {
    let mut sum = SumOfSquares { gradients, total: 0.0 };
    model.visit(&mut sum);
    let norm = sum.total.sqrt();
    if norm > limit {
        model.visit(&mut Scale { gradients, factor: limit / norm });
    }
    norm
}

struct SumOfSquares<'a> {
    gradients: &'a GradientsParams,
    total: f64,
}

impl ModuleVisitor for SumOfSquares<'_> {
    fn visit_float<const D: usize>(&mut self, param: &Param<Tensor<D>>) {
        if let Some(gradient) = self.gradients.get::<D>(param.id) {
            self.total += gradient.square().sum().into_scalar::<f64>();
        }
    }
}

struct Scale<'a> {
    gradients: &'a mut GradientsParams,
    factor: f64,
}

impl ModuleVisitor for Scale<'_> {
    fn visit_float<const D: usize>(&mut self, param: &Param<Tensor<D>>) {
        if let Some(gradient) = self.gradients.remove::<D>(param.id) {
            self.gradients.register(param.id, gradient.mul_scalar(self.factor));
        }
    }
}
