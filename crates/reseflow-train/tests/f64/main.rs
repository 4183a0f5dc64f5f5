//! The whole sampler in f64, which a process must choose before it makes its first tensor.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

#[path = "../suite/sampler.rs"]
mod sampler;
#[path = "../suite/support.rs"]
#[expect(dead_code, reason = "the other suite needs more of it")]
mod support;

use burn::tensor::{DType, FloatDType, Tensor};
use reseflow_train::DeviceKind;

#[test]
fn the_whole_sampler_turns_with_the_world_to_rounding() {
    for kind in [DeviceKind::Flex, DeviceKind::Ndarray] {
        let mut device = kind.device();
        device.configure(FloatDType::F64).unwrap();
        assert_eq!(Tensor::<1>::zeros([1], &device).dtype(), DType::F64);
    }
    sampler::the_sampler_turns_with_the_world(1e-9);
}
