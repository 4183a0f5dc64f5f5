//! The network as a field, of clean trajectories or of velocities: scenes are encoded once, then every solver step is one pass of
//! the decoder.

use burn::tensor::Device;
use reseflow_data::{ActionChunk, Observation, ObservationHistory};
use reseflow_flow::{ChunkVelocity, DriftField, Flow, FlowError, TwistField};
use reseflow_lie::SE3;
use reseflow_net::{
    DriftNet, EncodedScenes, NetError, Parameterisation, SceneContext, SceneState, TokenBatch,
};

use crate::TrainError;
use crate::convert::{HostPrediction, graph, host, token, tokens, velocities};

/// B encoded scenes and the network that decodes them.
pub(crate) struct NetField<'a> {
    net: &'a DriftNet,
    context: SceneContext,
    device: Device,
    /// What the nodes said when the network was asked last.
    pub(crate) last: Option<NodeAnswers>,
}

/// What the nodes said, each by itself.
pub(crate) enum NodeAnswers {
    /// Clean trajectories.
    Endpoints(HostPrediction),
    /// Velocities: how far they lie from the consensus, `[scene][step]`.
    Twists(Vec<Vec<f64>>),
}

impl<'a> NetField<'a> {
    /// Encodes scenes.
    pub(crate) fn new(net: &'a DriftNet, scenes: &[Seen<'_>], device: &Device) -> Result<Self, TrainError> {
        let (_, context) = encode(net, scenes, device)?;
        Ok(Self { net, context, device: device.clone(), last: None })
    }

    /// The flow to integrate, in the form that the network was configured for.
    pub(crate) fn flow(&mut self) -> Flow<'_> {
        match self.net.config().decoder.parameterisation {
            Parameterisation::Endpoint => Flow::Endpoint(self),
            Parameterisation::Twist => Flow::Twist(self),
        }
    }

    fn batch(&self, states: &[ActionChunk], t: f64) -> Result<TokenBatch, TrainError> {
        let trajectories: Vec<_> = states.iter().map(tokens).collect();
        let times = vec![t; states.len()];
        Ok(TokenBatch::new(&trajectories, &times, &self.context.origins_m, &self.device)?)
    }

    fn ask_endpoints(&mut self, states: &[ActionChunk], t: f64) -> Result<Vec<ActionChunk>, TrainError> {
        let prediction = self.net.decode(&self.context, &self.batch(states, t)?)?;
        let answer = HostPrediction::new(&prediction, &self.context.origins_m)?;
        let consensus = answer.consensus.clone();
        self.last = Some(NodeAnswers::Endpoints(answer));
        Ok(consensus)
    }

    fn ask_velocities(&mut self, states: &[ActionChunk], t: f64) -> Result<Vec<ChunkVelocity>, TrainError> {
        let prediction = self.net.decode_twists(&self.context, &self.batch(states, t)?)?;
        let spread = host(&prediction.spread())?;
        let per_scene = spread.chunks(spread.len() / states.len());
        self.last = Some(NodeAnswers::Twists(per_scene.map(<[f64]>::to_vec).collect()));
        velocities(&prediction, states.len())
    }
}

/// A scene as it was observed.
#[derive(Debug, Clone)]
pub(crate) struct Seen<'a> {
    /// The O frames, oldest first.
    pub(crate) frames: Vec<&'a Observation>,
    /// Where the gripper took hold.
    pub(crate) world_from_grasp: SE3,
    /// Action steps executed so far.
    pub(crate) elapsed: usize,
}

/// The scenes that `histories` end in.
pub(crate) fn scenes_of(histories: &[ObservationHistory]) -> Vec<Seen<'_>> {
    let seen = |history| {
        let history: &ObservationHistory = history;
        Seen {
            frames: history.frames().collect(),
            world_from_grasp: history.world_from_grasp(),
            elapsed: history.elapsed_steps(),
        }
    };
    histories.iter().map(seen).collect()
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
    if let Some(odd) = scenes.iter().find(|scene| scene.frames.len() != expected) {
        return Err(NetError::Mismatch { what: "observation frames", expected, got: odd.frames.len() }.into());
    }
    let states: Vec<SceneState> = scenes
        .iter()
        .map(|scene| SceneState {
            frames: (scene.frames.iter())
                .map(|seen| token(&seen.world_from_gripper, seen.gripper_opening))
                .collect(),
            grasp: token(&scene.world_from_grasp, 0.0),
            progress: progress(scene.elapsed, config.decoder.horizon),
        })
        .collect();
    let mut frames = Vec::with_capacity(config.decoder.frames);
    for frame in 0..config.decoder.frames {
        let graphs: Result<Vec<_>, _> =
            scenes.iter().map(|scene| graph(scene.frames[frame], &config.encoder.graph)).collect();
        let grippers: Vec<_> = states.iter().map(|state| state.frames[frame]).collect();
        frames.push(net.encode(&graphs?, &grippers, device)?);
    }
    let context = net.context(&frames, &states)?;
    Ok((frames, context))
}

impl DriftField for NetField<'_> {
    fn endpoints(&mut self, states: &[ActionChunk], t: f64) -> Result<Vec<ActionChunk>, FlowError> {
        self.ask_endpoints(states, t).map_err(|fault| FlowError::Field(fault.to_string()))
    }
}

impl TwistField for NetField<'_> {
    fn velocities(&mut self, states: &[ActionChunk], t: f64) -> Result<Vec<ChunkVelocity>, FlowError> {
        self.ask_velocities(states, t).map_err(|fault| FlowError::Field(fault.to_string()))
    }
}
