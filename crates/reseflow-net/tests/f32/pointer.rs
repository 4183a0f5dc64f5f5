//! Pointers read what is near their tips, also where both are metres from the centroid.

use burn::module::{Module, ModuleMapper, Param};
use burn::tensor::{DType, Tensor};
use rand::RngExt;
use reseflow_net::{Features, PointerAttentionConfig};

use crate::support::features::HostFeatures;
use crate::support::{assert_small, devices, rng, tensor, values, worst_difference};

#[test]
fn a_pointer_reads_what_is_near_its_tip() {
    let config = PointerAttentionConfig { query: [6, 4], memory: [5, 3], heads: 2, key: 4 };
    for (name, device) in devices() {
        let layer = config.init(&device, &mut rng(9100));
        // No vectors: both pointers end at the origin. No scalars: nothing but the distance decides.
        let tokens =
            Features { scalars: Tensor::zeros([1, 6], &device), vectors: Tensor::zeros([3, 1, 4], &device) };
        let read = |rows: [(f64, f64); 2]| {
            let scalars = rows.iter().flat_map(|(value, _)| [*value; 5]).collect();
            let mut vectors = vec![0.0; 3 * 2 * 3];
            for (row, (_, x)) in rows.iter().enumerate() {
                vectors[row * 3 + 2] = *x;
            }
            let memory = Features {
                scalars: tensor(scalars, [2, 5], &device),
                vectors: tensor(vectors, [3, 2, 3], &device),
            };
            values(&layer.forward(1, &tokens, &memory).scalars)
        };
        let (alone, with_far, with_near) = (
            read([(1.0, 0.1), (1.0, 0.1)]),
            read([(1.0, 0.1), (-2.0, 3.0)]),
            read([(1.0, 0.1), (-2.0, 0.15)]),
        );
        let apart = |one: &[f64], other: &[f64]| {
            one.iter().zip(other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        assert!(apart(&alone, &with_far) < 1e-6, "{name}: what is far away was read");
        assert!(apart(&alone, &with_near) > 0.1, "{name}: what is near was not read");
    }
}

/// Weights in f64, whatever the suite's float type is.
struct Exact;

impl ModuleMapper for Exact {
    fn map_float<const D: usize>(&mut self, param: Param<Tensor<D>>) -> Param<Tensor<D>> {
        param.map(|weights| weights.cast(DType::F64))
    }
}

/// A scene 3 m wide, so densely filled that several rows are near every tip. By squares of such offsets less
/// twice their product it would be off by 1e-5.
#[test]
fn pointers_in_a_wide_scene_say_in_f32_what_they_say_in_f64() {
    let config = PointerAttentionConfig { query: [6, 4], memory: [5, 3], heads: 2, key: 4 };
    let (queries, rows) = (16, 2000);
    for (name, device) in devices() {
        let mut rng = rng(9101);
        let layer = config.init(&device, &mut rng);
        let mut tokens = HostFeatures::random(queries, [6, 4], &mut rng);
        let mut memory = HostFeatures::random(rows, [5, 3], &mut rng);
        // Offsets over 0.1 m: all vectors of the tokens, and the last of the memory.
        tokens.vectors.fill_with(|| rng.random_range(-15.0..15.0));
        for place in memory.vectors.iter_mut().skip(2).step_by(3) {
            *place = rng.random_range(-15.0..15.0);
        }
        let [tokens, memory] = [tokens, memory].map(|features| features.tensors(&device));
        let said = layer.forward(1, &tokens, &memory);
        let [tokens, memory] = [tokens, memory].map(|features| Features {
            scalars: features.scalars.cast(DType::F64),
            vectors: features.vectors.cast(DType::F64),
        });
        let exact = layer.map(&mut Exact).forward(1, &tokens, &memory);
        assert_eq!(exact.vectors.dtype(), DType::F64);
        for (what, said, exact) in [
            ("scalars", values(&said.scalars), values(&exact.scalars)),
            ("vectors", values(&said.vectors), values(&exact.vectors)),
        ] {
            let size = exact.iter().fold(0.0_f64, |size, value| size.max(value.abs()));
            let error = worst_difference(&said, &exact) / size;
            assert_small(&format!("{name} pointers over 3 m, {what} against f64"), error, 2e-6);
        }
    }
}
