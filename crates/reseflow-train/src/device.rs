//! Where tensors live, chosen at run time.

use burn::tensor::Device;
use serde::{Deserialize, Serialize};

/// Where to compute.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DeviceKind {
    /// The processor, with the faster backend (flex).
    #[default]
    Cpu,
    /// burn's flex backend.
    Flex,
    /// burn's ndarray backend.
    Ndarray,
}

impl DeviceKind {
    /// What configurations call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cpu => "cpu",
            Self::Flex => "flex",
            Self::Ndarray => "ndarray",
        }
    }

    /// burn's device of this kind.
    pub fn device(self) -> Device {
        match self {
            Self::Cpu | Self::Flex => Device::flex(),
            Self::Ndarray => ndarray(),
        }
    }
}

#[expect(deprecated, reason = "burn 0.22 still ships ndarray, and users ask to compare with it")]
fn ndarray() -> Device {
    Device::ndarray()
}
