//! The two kernels: left factors Ĥ^{k→0} from scalars alone, and the last one from vectors.

use burn::module::Module;
use burn::nn::Linear;
use burn::tensor::{Device, Tensor, TensorData};
use rand::Rng;
use reseflow_flow::EndpointTargets;
use reseflow_lie_tensor::gram_schmidt;
use reseflow_net::init::linear;

use super::config::EtSeedConfig;
use super::input::{KernelInput, OFFSET_SCALE_M};
use super::trunk::{Trunk, TrunkScenes};
use crate::TrainError;

/// How far from the identity the drawn weights' left factors lie.
const READ_OUT_GAIN: f64 = 0.1;

/// Both kernels, with separate weights.
#[derive(Module, Debug)]
pub struct EtSeedNet {
    pub(super) invariant: InvariantKernel,
    pub(super) equivariant: EquivariantKernel,
}

impl EtSeedNet {
    /// Draws the weights.
    pub(super) fn new<R: Rng + ?Sized>(
        config: &EtSeedConfig,
        device: &Device,
        rng: &mut R,
    ) -> Result<Self, TrainError> {
        let token = [config.network.decoder.token_scalars, config.network.decoder.token_vectors];
        Ok(Self {
            invariant: InvariantKernel {
                trunk: Trunk::new(&config.network, device, rng)?,
                pose: linear([token[0], 9], READ_OUT_GAIN, true, device, rng),
                opening: linear([token[0], 1], READ_OUT_GAIN, true, device, rng),
            },
            equivariant: EquivariantKernel {
                trunk: Trunk::new(&config.network, device, rng)?,
                pose: linear([token[1], 3], READ_OUT_GAIN, false, device, rng),
                opening: linear([token[0], 1], READ_OUT_GAIN, true, device, rng),
            },
        })
    }
}

/// Levels above the first: nine numbers of degree 0, two columns and a translation, relative to the anchor.
#[derive(Module, Debug)]
pub(super) struct InvariantKernel {
    pub(super) trunk: Trunk,
    pose: Linear,
    opening: Linear,
}

impl InvariantKernel {
    /// X̂⁰ = Ĥ X^k relative to the anchor; Ĥ has the columns e_x + a and e_y + b, made orthonormal, and the translation c.
    pub(super) fn forward(
        &self,
        scenes: &TrunkScenes,
        input: &KernelInput,
    ) -> Result<EndpointTargets, TrainError> {
        let features = self.trunk.forward(scenes, input)?;
        let numbers = self.pose.forward(features.scalars.clone());
        let [rows, _] = numbers.dims();
        let axis = |index: usize| -> Tensor<2> {
            let unit = [0, 1, 2].map(|component| if component == index { 1.0 } else { 0.0 });
            Tensor::from_data(TensorData::new(unit.to_vec(), [1, 3]), &numbers.device())
        };
        let part = |index: usize| numbers.clone().narrow(1, 3 * index, 3);
        let left = gram_schmidt(part(0) + axis(0), part(1) + axis(1));
        let turned = left.clone().matmul(input.states.positions_m.clone().reshape([rows, 3, 1]));
        Ok(EndpointTargets {
            rotations: left.matmul(input.states.rotations.clone()),
            positions_m: turned.reshape([rows, 3]) + part(2).mul_scalar(OFFSET_SCALE_M),
            openings: input.states.openings.clone() + self.opening.forward(features.scalars),
        })
    }
}

/// The last level: three vectors, two to columns and one to an offset, in the world.
#[derive(Module, Debug)]
pub(super) struct EquivariantKernel {
    pub(super) trunk: Trunk,
    pose: Linear,
    opening: Linear,
}

impl EquivariantKernel {
    /// H⁰ = Ĥ H¹ in the world's axes, from the gripper's origin: the columns of H¹ and vectors, made orthonormal.
    pub(super) fn forward(
        &self,
        scenes: &TrunkScenes,
        input: &KernelInput,
    ) -> Result<EndpointTargets, TrainError> {
        let features = self.trunk.forward(scenes, input)?;
        let [_, rows, _] = features.vectors.dims();
        let vectors = self.pose.forward(features.vectors);
        let part = |index: usize| vectors.clone().narrow(2, index, 1).reshape([3, rows]).swap_dims(0, 1);
        let column = |index: usize| input.states.rotations.clone().narrow(2, index, 1).reshape([rows, 3]);
        Ok(EndpointTargets {
            rotations: gram_schmidt(column(0) + part(0), column(1) + part(1)),
            positions_m: input.states.positions_m.clone() + part(2).mul_scalar(OFFSET_SCALE_M),
            openings: input.states.openings.clone() + self.opening.forward(features.scalars),
        })
    }
}
