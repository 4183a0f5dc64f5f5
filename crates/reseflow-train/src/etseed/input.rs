//! What the kernels are shown: the observed scenes, and the noisy trajectories as scalars and as vectors.

use burn::tensor::{Device, Tensor, TensorData};
use reseflow_data::ActionChunk;
use reseflow_flow::{Anchor, AnchoredChunk, EndpointTargets};
use reseflow_lie::SE3;
use reseflow_net::{CloudGraph, DriftNetConfig, GripperState, TokenBatch};

use super::config::EtSeedConfig;
use crate::TrainError;
use crate::convert::{endpoint_tensors, graph, token, tokens};
use crate::field::{Seen, progress};

/// Makes offsets in a scene comparable with unit vectors, metres; the network's own.
pub(super) const OFFSET_SCALE_M: f64 = 0.1;

/// Numbers of [`pose_numbers`].
pub(super) const POSE_NUMBERS: usize = 12;

/// One scene as it was observed.
#[derive(Debug, Clone)]
pub(super) struct SceneView {
    /// The O clouds, oldest first.
    pub(super) graphs: Vec<CloudGraph>,
    /// The gripper in each frame.
    pub(super) grippers: Vec<SE3>,
    /// Its openings.
    pub(super) openings: Vec<f64>,
    /// Where it took hold, for networks that are told.
    pub(super) world_from_grasp: Option<SE3>,
    /// Executed action steps over the horizon, in \[0, 1\].
    pub(super) progress: f64,
    /// What is diffused is relative to this.
    pub(super) anchor: Anchor,
}

impl SceneView {
    /// A scene from its frames, of which there is at least one.
    pub(super) fn new(scene: &Seen<'_>, config: &EtSeedConfig) -> Result<Self, TrainError> {
        let Seen { frames, world_from_grasp, elapsed } = scene;
        let Some(latest) = frames.last() else { return Err(TrainError::NoData) };
        let DriftNetConfig { encoder, decoder, .. } = &config.network;
        let graphs: Result<Vec<_>, _> = frames.iter().map(|seen| graph(seen, &encoder.graph)).collect();
        Ok(Self {
            graphs: graphs?,
            grippers: frames.iter().map(|seen| seen.world_from_gripper).collect(),
            openings: frames.iter().map(|seen| seen.gripper_opening).collect(),
            world_from_grasp: decoder.grasp_memory.then_some(*world_from_grasp),
            progress: progress(*elapsed, decoder.horizon),
            anchor: Anchor::of(latest, config.diffusion.frame),
        })
    }

    /// The gripper's latest pose.
    pub(super) fn gripper(&self) -> SE3 {
        self.grippers.last().copied().unwrap_or_else(SE3::identity)
    }

    /// The gripper of one frame as the network's vectors.
    pub(super) fn state(&self, frame: usize) -> GripperState {
        token(&self.grippers[frame], self.openings[frame])
    }
}

/// B·L noisy actions for one of the kernels.
#[derive(Debug, Clone)]
pub(super) struct KernelInput {
    /// The actions' columns and their offset from the gripper as vectors in the world; the level and the opening as scalars.
    pub(super) tokens: TokenBatch,
    /// The gripper's columns, `[3, B·L, 3]`.
    pub(super) gripper_columns: Tensor<3>,
    /// The poses as numbers in a frame that moves with the scene, `[B·L, 12]`.
    pub(super) pose_numbers: Tensor<2>,
    /// The poses in the frame of the kernel's answer.
    pub(super) states: EndpointTargets,
}

impl KernelInput {
    /// For the invariant kernel, whose answer is relative to the anchor; `levels` is k of each scene, `of` is K, and the network sees k/K.
    pub(super) fn invariant(
        views: &[&SceneView],
        states: &[AnchoredChunk],
        levels: &[usize],
        of: usize,
        device: &Device,
    ) -> Result<Self, TrainError> {
        let levels: Vec<f64> = levels.iter().map(|&level| level as f64 / of as f64).collect();
        let placed: Vec<_> = views.iter().zip(states).map(|(view, state)| view.anchor.place(state)).collect();
        let poses: Vec<SE3> =
            states.iter().flat_map(|state| state.0.iter().map(|action| action.anchor_from_gripper)).collect();
        Self::new(views, &placed, &levels, &poses, anchored_tensors(states, device), device)
    }

    /// For the equivariant kernel, whose answer has the world's axes and the gripper's origin.
    pub(super) fn equivariant(
        views: &[&SceneView],
        trajectories: &[ActionChunk],
        device: &Device,
    ) -> Result<Self, TrainError> {
        let relative = |(view, chunk): (&&SceneView, &ActionChunk)| {
            let gripper_from_world = view.gripper().inverse();
            chunk.iter().map(|action| gripper_from_world * action.world_from_gripper).collect::<Vec<_>>()
        };
        let poses: Vec<SE3> = views.iter().zip(trajectories).flat_map(relative).collect();
        let states = world_tensors(views, trajectories, device);
        Self::new(views, trajectories, &vec![0.0; views.len()], &poses, states, device)
    }

    fn new(
        views: &[&SceneView],
        placed: &[ActionChunk],
        levels: &[f64],
        poses: &[SE3],
        states: EndpointTargets,
        device: &Device,
    ) -> Result<Self, TrainError> {
        let origins: Vec<[f64; 3]> = views.iter().map(|view| view.gripper().translation.into()).collect();
        let trajectories: Vec<_> = (views.iter().zip(placed))
            .map(|(view, chunk)| {
                let mut states = tokens(chunk);
                states.iter_mut().for_each(|state| state.opening -= view.anchor.opening);
                states
            })
            .collect();
        let tokens = TokenBatch::new(&trajectories, levels, &origins, device)?;
        let rows = poses.len();
        let columns = |axis: usize| {
            views.iter().zip(placed).flat_map(move |(view, chunk)| {
                let rotation = view.gripper().rotation.matrix();
                let row = [0, 1, 2].map(|column| rotation[(axis, column)]);
                std::iter::repeat_n(row, chunk.len()).flatten()
            })
        };
        let columns: Vec<f64> = (0..3).flat_map(columns).collect();
        let numbers: Vec<f64> = poses.iter().flat_map(pose_numbers).collect();
        Ok(Self {
            tokens,
            gripper_columns: Tensor::from_data(TensorData::new(columns, [3, rows, 3]), device),
            pose_numbers: Tensor::from_data(TensorData::new(numbers, [rows, POSE_NUMBERS]), device),
            states,
        })
    }
}

/// A pose as numbers of order one: its three columns, and its position over the offset scale.
pub(super) fn pose_numbers(pose: &SE3) -> [f64; POSE_NUMBERS] {
    let rotation = pose.rotation.matrix();
    std::array::from_fn(|index| match index {
        0..9 => rotation[(index % 3, index / 3)],
        _ => pose.translation[index - 9] / OFFSET_SCALE_M,
    })
}

/// Trajectories relative to their anchors as tensors.
pub(super) fn anchored_tensors(chunks: &[AnchoredChunk], device: &Device) -> EndpointTargets {
    let actions = chunks.iter().flat_map(|chunk| &chunk.0);
    endpoint_tensors(actions.map(|action| (action.anchor_from_gripper, action.opening)), device)
}

/// Trajectories in the world's axes, from the gripper's origin, with openings relative to the present one.
pub(super) fn world_tensors(
    views: &[&SceneView],
    chunks: &[ActionChunk],
    device: &Device,
) -> EndpointTargets {
    let actions = views.iter().zip(chunks).flat_map(|(view, chunk)| {
        chunk.iter().map(move |action| {
            let mut pose = action.world_from_gripper;
            pose.translation -= view.gripper().translation;
            (pose, action.opening - view.anchor.opening)
        })
    });
    endpoint_tensors(actions, device)
}
