//! Pointers read what is near their tips.

use burn::tensor::Tensor;
use reseflow_net::{Features, PointerAttentionConfig};

use crate::support::{devices, rng, tensor, values};

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
