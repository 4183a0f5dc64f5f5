//! The network as a drift field: scenes are encoded once, then every solver step is one pass of the decoder.

use burn::tensor::Device;
use reseflow_data::{ActionChunk, Observation};
use reseflow_flow::{DriftField, FlowError};
use reseflow_net::{DriftNet, NetError, SceneContext, SceneState, TokenBatch};

use crate::TrainError;
use crate::convert::{HostPrediction, graph, token, tokens};

/// B encoded scenes and the network that decodes them.
pub(crate) struct NetField<'a> {
    net: &'a DriftNet,
    context: SceneContext,
    device: Device,
    /// The last prediction with its nodes.
    pub(crate) last: Option<HostPrediction>,
}

impl<'a> NetField<'a> {
    /// Encodes scenes, each given as its frames (oldest first) and the action steps executed so far.
    pub(crate) fn new(
        net: &'a DriftNet,
        scenes: &[(Vec<&Observation>, usize)],
        device: &Device,
    ) -> Result<Self, TrainError> {
        let context = context(net, scenes, device)?;
        Ok(Self { net, context, device: device.clone(), last: None })
    }
}

/// The decoder's context of some scenes.
pub(crate) fn context(
    net: &DriftNet,
    scenes: &[(Vec<&Observation>, usize)],
    device: &Device,
) -> Result<SceneContext, TrainError> {
    let config = net.config();
    let expected = config.decoder.frames;
    if let Some((observed, _)) = scenes.iter().find(|(observed, _)| observed.len() != expected) {
        return Err(NetError::Mismatch { what: "observation frames", expected, got: observed.len() }.into());
    }
    let states: Vec<SceneState> = scenes
        .iter()
        .map(|(observed, elapsed)| SceneState {
            frames: observed
                .iter()
                .map(|seen| token(&seen.world_from_gripper, seen.gripper_opening))
                .collect(),
            progress: (*elapsed as f64 / config.decoder.horizon as f64).min(1.0),
        })
        .collect();
    let mut frames = Vec::with_capacity(config.decoder.frames);
    for frame in 0..config.decoder.frames {
        let graphs: Result<Vec<_>, _> =
            scenes.iter().map(|(observed, _)| graph(observed[frame], &config.encoder.graph)).collect();
        let grippers: Vec<_> = states.iter().map(|state| state.frames[frame]).collect();
        frames.push(net.encode(&graphs?, &grippers, device)?);
    }
    Ok(net.context(&frames, &states)?)
}

impl DriftField for NetField<'_> {
    fn endpoints(&mut self, states: &[ActionChunk], t: f64) -> Result<Vec<ActionChunk>, FlowError> {
        let failed = |fault: &dyn std::fmt::Display| FlowError::Field(fault.to_string());
        let trajectories: Vec<_> = states.iter().map(tokens).collect();
        let times = vec![t; states.len()];
        let batch = TokenBatch::new(&trajectories, &times, &self.context.origins_m, &self.device)
            .map_err(|fault| failed(&fault))?;
        let prediction = self.net.decode(&self.context, &batch).map_err(|fault| failed(&fault))?;
        let host =
            HostPrediction::new(&prediction, &self.context.origins_m).map_err(|fault| failed(&fault))?;
        let consensus = host.consensus.clone();
        self.last = Some(host);
        Ok(consensus)
    }
}
