//! The network as a drift field: scenes are encoded once, then every solver step is one pass of the decoder.

use burn::tensor::Device;
use reseflow_data::{ActionChunk, Observation, ObservationHistory};
use reseflow_flow::{DriftField, FlowError};
use reseflow_net::{DriftNet, EncodedScenes, NetError, SceneContext, SceneState, TokenBatch};

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
    /// Encodes scenes.
    pub(crate) fn new(net: &'a DriftNet, scenes: &[Seen<'_>], device: &Device) -> Result<Self, TrainError> {
        let (_, context) = encode(net, scenes, device)?;
        Ok(Self { net, context, device: device.clone(), last: None })
    }
}

/// A scene as it was observed: its frames, oldest first, and the action steps executed so far.
pub(crate) type Seen<'a> = (Vec<&'a Observation>, usize);

/// The scenes that `histories` end in.
pub(crate) fn scenes_of(histories: &[ObservationHistory]) -> Vec<Seen<'_>> {
    histories.iter().map(|history| (history.frames().collect(), history.elapsed_steps())).collect()
}

/// The share of the horizon that is over.
pub(crate) fn progress(elapsed: usize, horizon: usize) -> f64 {
    (elapsed as f64 / horizon as f64).min(1.0)
}

/// Some scenes' frames, each encoded by itself, and the decoder's context of them all.
pub(crate) fn encode(
    net: &DriftNet,
    scenes: &[Seen<'_>],
    device: &Device,
) -> Result<(Vec<EncodedScenes>, SceneContext), TrainError> {
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
            progress: progress(*elapsed, config.decoder.horizon),
        })
        .collect();
    let mut frames = Vec::with_capacity(config.decoder.frames);
    for frame in 0..config.decoder.frames {
        let graphs: Result<Vec<_>, _> =
            scenes.iter().map(|(observed, _)| graph(observed[frame], &config.encoder.graph)).collect();
        let grippers: Vec<_> = states.iter().map(|state| state.frames[frame]).collect();
        frames.push(net.encode(&graphs?, &grippers, device)?);
    }
    let context = net.context(&frames, &states)?;
    Ok((frames, context))
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
