//! Clipping by the global norm (burn's own clips tensor by tensor).

use burn::module::{Module, ModuleVisitor, Param};
use burn::optim::GradientsParams;
use burn::tensor::Tensor;

/// Scales all gradients by one factor so that their joint norm is at most `limit`; returns the norm before.
pub(crate) fn clip_global_norm<M: Module>(model: &M, gradients: &mut GradientsParams, limit: f64) -> f64 {
    let norm = global_norm(model, gradients);
    if norm > limit {
        model.visit(&mut Scale { gradients, factor: limit / norm });
    }
    norm
}

/// The norm of all gradients together.
pub(crate) fn global_norm<M: Module>(model: &M, gradients: &GradientsParams) -> f64 {
    let mut sum = SumOfSquares { gradients, total: 0.0 };
    model.visit(&mut sum);
    sum.total.sqrt()
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

#[cfg(test)]
mod tests {
    use super::*;
    use burn::nn::{Linear, LinearConfig};
    use burn::tensor::{Device, TensorData};

    /// A layer and the gradients of Σ C·W + Σ d·b, which are C and d themselves.
    fn layer_with(weight: [[f32; 2]; 2], bias: [f32; 2]) -> (Linear, GradientsParams) {
        let base = Device::flex();
        let layer = LinearConfig::new(2, 2).init(&base.clone().autodiff());
        let on_weight = Tensor::<2>::from_data(TensorData::from(weight), &base.clone().autodiff());
        let on_bias = Tensor::<1>::from_data(TensorData::from(bias), &base.autodiff());
        let bias = layer.bias.as_ref().unwrap().val();
        let loss = (layer.weight.val() * on_weight).sum() + (bias * on_bias).sum();
        let gradients = GradientsParams::from_grads(loss.backward(), &layer);
        (layer, gradients)
    }

    fn values(layer: &Linear, gradients: &GradientsParams) -> Vec<f64> {
        let weight = gradients.get::<2>(layer.weight.id).unwrap().try_to_vec_as::<f64>().unwrap();
        let bias = gradients.get::<1>(layer.bias.as_ref().unwrap().id).unwrap();
        weight.into_iter().chain(bias.try_to_vec_as::<f64>().unwrap()).collect()
    }

    #[test]
    fn all_gradients_shrink_by_one_factor_to_the_joint_norm() {
        // 3² + 4² + 12² = 13²: the norm of both tensors together, not of either.
        let (layer, mut gradients) = layer_with([[3.0, 0.0], [0.0, -4.0]], [0.0, 12.0]);
        assert!((clip_global_norm(&layer, &mut gradients, 6.5) - 13.0).abs() < 1e-5);
        let expected = [1.5, 0.0, 0.0, -2.0, 0.0, 6.0];
        for (got, expected) in values(&layer, &gradients).iter().zip(expected) {
            assert!((got - expected).abs() < 1e-6, "{got}, expected {expected}");
        }
        assert!((clip_global_norm(&layer, &mut gradients, 1e9) - 6.5).abs() < 1e-5, "what is left");
    }

    #[test]
    fn gradients_within_the_limit_stay_as_they_are() {
        let (layer, mut gradients) = layer_with([[0.1, 0.2], [0.3, 0.4]], [0.5, 0.6]);
        let before = values(&layer, &gradients);
        clip_global_norm(&layer, &mut gradients, 1.0);
        assert_eq!(values(&layer, &gradients), before);
    }

    #[test]
    fn a_gradient_that_is_no_number_shows_in_the_norm() {
        let (layer, mut gradients) = layer_with([[f32::NAN, 0.0], [0.0, 0.0]], [1.0, 0.0]);
        assert!(clip_global_norm(&layer, &mut gradients, 1.0).is_nan());
    }
}
