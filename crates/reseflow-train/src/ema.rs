//! The exponential moving average of the weights, which is what is evaluated and kept.

use std::collections::HashMap;

use burn::module::{Module, ModuleMapper, ModuleVisitor, Param, ParamId};
use burn::tensor::{Tensor, TensorData};

/// Averaged values, by parameter.
#[derive(Clone)]
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

    /// The averages of all of `model`'s parameters, one after another in the order of a visit; none before the first update.
    pub(crate) fn flat<M: Module>(&self, model: &M) -> Vec<f64> {
        let mut flat = Flatten { average: self, flat: Vec::new() };
        model.visit(&mut flat);
        flat.flat
    }

    /// What [`WeightAverage::flat`] was taken from; `None` where the values are not as many as the parameters.
    pub(crate) fn from_flat<M: Module>(decay: f64, model: &M, flat: &[f64]) -> Option<Self> {
        let mut split = Split { average: Self::new(decay), rest: Some(flat) };
        model.visit(&mut split);
        split.rest.is_some_and(<[f64]>::is_empty).then_some(split.average)
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

struct Flatten<'a> {
    average: &'a WeightAverage,
    flat: Vec<f64>,
}

impl ModuleVisitor for Flatten<'_> {
    fn visit_float<const D: usize>(&mut self, param: &Param<Tensor<D>>) {
        self.flat.extend(self.average.values.get(&param.id).into_iter().flatten());
    }
}

struct Split<'a> {
    average: WeightAverage,
    rest: Option<&'a [f64]>,
}

impl ModuleVisitor for Split<'_> {
    fn visit_float<const D: usize>(&mut self, param: &Param<Tensor<D>>) {
        let split = self.rest.and_then(|rest| rest.split_at_checked(param.shape().num_elements()));
        self.rest = split.map(|(values, rest)| {
            self.average.values.insert(param.id, values.to_vec());
            rest
        });
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

#[cfg(test)]
mod tests {
    use super::*;
    use burn::nn::{Linear, LinearConfig};
    use burn::tensor::Device;

    /// A layer whose every number is `value`.
    fn filled(layer: Linear, value: f64) -> Linear {
        struct Fill(f64);
        impl ModuleMapper for Fill {
            fn map_float<const D: usize>(&mut self, param: Param<Tensor<D>>) -> Param<Tensor<D>> {
                param.map(|tensor| Tensor::full(tensor.dims(), self.0, &tensor.device()))
            }
        }
        layer.map(&mut Fill(value))
    }

    /// The averages after each of `sequence`, taken in as the weights of updates 1, 2, …
    fn averages(decay: f64, sequence: &[f64]) -> Vec<f64> {
        let mut layer = LinearConfig::new(2, 3).init(&Device::flex());
        let mut average = WeightAverage::new(decay);
        let mut after = Vec::new();
        for (index, &value) in sequence.iter().enumerate() {
            layer = filled(layer, value);
            average.update(&layer, index + 1);
            let averaged = average.apply(layer.clone());
            let weight = averaged.weight.val().try_to_vec_as::<f64>().unwrap();
            let bias = averaged.bias.unwrap().val().try_to_vec_as::<f64>().unwrap();
            assert!(weight.len() == 6 && weight.iter().chain(&bias).all(|entry| *entry == weight[0]));
            after.push(weight[0]);
        }
        after
    }

    #[test]
    fn the_average_follows_its_recursion() {
        // Decays 2/11, 3/12 and 4/13, all below 0.995: 1, then 1 + 3/4 · 1, then 7/4 + 9/13 · 9/4.
        let expected = [1.0, 1.75, 1.75 + 9.0 / 13.0 * 2.25];
        for (got, expected) in averages(0.995, &[1.0, 2.0, 4.0]).iter().zip(expected) {
            assert!((got - expected).abs() < 1e-6, "{got}, expected {expected}");
        }
        // A decay of 0.2 counts from the second update on: 3/12 is more.
        let expected = [1.0, 1.8, 1.8 + 0.8 * 2.2];
        for (got, expected) in averages(0.2, &[1.0, 2.0, 4.0]).iter().zip(expected) {
            assert!((got - expected).abs() < 1e-6, "{got}, expected {expected}");
        }
    }

    #[test]
    fn weights_that_stay_are_their_own_average_and_without_decay_so_is_the_last() {
        assert_eq!(averages(0.9, &[0.5; 20]), [0.5; 20]);
        assert_eq!(averages(0.0, &[1.0, 3.0, -2.0]), [1.0, 3.0, -2.0]);
    }

    #[test]
    fn a_model_that_was_never_seen_stays_as_it_is() {
        let layer = filled(LinearConfig::new(2, 3).init(&Device::flex()), 0.25);
        let applied = WeightAverage::new(0.9).apply(layer);
        assert_eq!(applied.weight.val().try_to_vec_as::<f64>().unwrap(), [0.25; 6]);
    }
}
