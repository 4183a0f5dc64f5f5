//! The kernels as the sampler's denoiser: scenes are encoded once, then every step is one pass of the tokens.

use burn::tensor::Device;
use reseflow_data::{Action, ActionChunk};
use reseflow_flow::{AnchoredAction, AnchoredChunk, Denoiser, EndpointTargets, FlowError, LeftFactor};
use reseflow_lie::{Matrix3, SE3, SO3, Vector3};

use super::input::{KernelInput, SceneView};
use super::net::EtSeedNet;
use super::trunk::TrunkScenes;
use crate::TrainError;
use crate::convert::host;

/// B scenes, encoded by both kernels.
pub(super) struct NetDenoiser<'a> {
    net: &'a EtSeedNet,
    views: Vec<&'a SceneView>,
    invariant: TrunkScenes,
    equivariant: TrunkScenes,
    levels: usize,
    device: Device,
}

impl<'a> NetDenoiser<'a> {
    /// Encodes the scenes; K is `levels`.
    pub(super) fn new(
        net: &'a EtSeedNet,
        views: &'a [SceneView],
        levels: usize,
        device: &Device,
    ) -> Result<Self, TrainError> {
        let views: Vec<&SceneView> = views.iter().collect();
        Ok(Self {
            invariant: net.invariant.trunk.encode(&views, device)?,
            equivariant: net.equivariant.trunk.encode(&views, device)?,
            net,
            views,
            levels,
            device: device.clone(),
        })
    }
}

impl Denoiser for NetDenoiser<'_> {
    fn invariant(
        &mut self,
        states: &[AnchoredChunk],
        level: usize,
    ) -> Result<Vec<Vec<LeftFactor>>, FlowError> {
        let levels = vec![level; states.len()];
        let input = KernelInput::invariant(&self.views, states, &levels, self.levels, &self.device)
            .map_err(failed)?;
        let clean = self.net.invariant.forward(&self.invariant, &input).map_err(failed)?;
        let mut clean = actions(&clean).map_err(failed)?.into_iter();
        let factors = |state: &AnchoredChunk| {
            let pairs = state.0.iter().zip(clean.by_ref());
            pairs
                .map(|(noisy, (anchor_from_gripper, opening))| {
                    LeftFactor::between(noisy, &AnchoredAction { anchor_from_gripper, opening })
                })
                .collect()
        };
        Ok(states.iter().map(factors).collect())
    }

    fn equivariant(&mut self, trajectories: &[ActionChunk]) -> Result<Vec<Vec<LeftFactor>>, FlowError> {
        let input = KernelInput::equivariant(&self.views, trajectories, &self.device).map_err(failed)?;
        let clean = self.net.equivariant.forward(&self.equivariant, &input).map_err(failed)?;
        let mut clean = actions(&clean).map_err(failed)?.into_iter();
        let factors = |(view, trajectory): (&&SceneView, &ActionChunk)| {
            let (origin, present) = (view.gripper().translation, view.anchor.opening);
            let pairs = trajectory.iter().zip(clean.by_ref());
            pairs
                .map(|(noisy, (mut world_from_gripper, opening))| {
                    world_from_gripper.translation += origin;
                    let clean = Action { world_from_gripper, opening: opening + present };
                    LeftFactor::between_actions(noisy, &clean)
                })
                .collect()
        };
        Ok(self.views.iter().zip(trajectories).map(factors).collect())
    }
}

fn failed(fault: TrainError) -> FlowError {
    FlowError::Field(fault.to_string())
}

/// The predicted poses and openings on the host.
fn actions(predicted: &EndpointTargets) -> Result<Vec<(SE3, f64)>, TrainError> {
    let rotations = host(&predicted.rotations)?;
    let positions = host(&predicted.positions_m)?;
    let openings = host(&predicted.openings)?;
    let rows = rotations.chunks_exact(9).zip(positions.chunks_exact(3)).zip(openings);
    rows.enumerate()
        .map(|(row, ((rotation, position), opening))| {
            let rotation = SO3::from_matrix(&Matrix3::from_row_slice(rotation))
                .map_err(|fault| FlowError::Field(format!("predicted rotation {row}: {fault}")))?;
            Ok((SE3::new(rotation, Vector3::from_column_slice(position)), opening))
        })
        .collect()
}
