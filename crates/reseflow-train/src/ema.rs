//! The exponential moving average of the weights, which is what is evaluated and kept.

use std::collections::HashMap;

use burn::module::{Module, ModuleMapper, ModuleVisitor, Param, ParamId};
use burn::tensor::{Tensor, TensorData};

/// Averaged values, by parameter.
pub(crate) struct WeightAverage {
    decay: f64,
    values: HashMap<ParamId, Vec<f64>>,
}

impl WeightAverage {
    /// An average that starts at the first weights it sees.
    pub(crate) fn new(decay: f64) -> Self {
        Self { decay, values: HashMap::new() }
    }

    /// Takes in the weights after update `update`, from 1. Early on the average is shorter, so that it forgets the start.
    pub(crate) fn update<M: Module>(&mut self, model: &M, update: usize) {
        let decay = self.decay.min((1.0 + update as f64) / (10.0 + update as f64));
        model.visit(&mut TakeIn { values: &mut self.values, decay });
    }

    /// `model` with the averaged weights.
    pub(crate) fn apply<M: Module>(&self, model: M) -> M {
        model.map(&mut PutIn { values: &self.values })
    }
}

struct TakeIn<'a> {
    values: &'a mut HashMap<ParamId, Vec<f64>>,
    decay: f64,
}

impl ModuleVisitor for TakeIn<'_> {
    fn visit_float<const D: usize>(&mut self, param: &Param<Tensor<D>>) {
        let Ok(now) = param.val().try_to_vec_as::<f64>() else { return };
        let average = self.values.entry(param.id).or_insert_with(|| now.clone());
        for (average, now) in average.iter_mut().zip(now) {
            *average += (1.0 - self.decay) * (now - *average);
        }
    }
}

struct PutIn<'a> {
    values: &'a HashMap<ParamId, Vec<f64>>,
}

impl ModuleMapper for PutIn<'_> {
    fn map_float<const D: usize>(&mut self, param: Param<Tensor<D>>) -> Param<Tensor<D>> {
        let Some(values) = self.values.get(&param.id) else { return param };
        param
            .map(|tensor| Tensor::from_data(TensorData::new(values.clone(), tensor.dims()), &tensor.device()))
    }
}
