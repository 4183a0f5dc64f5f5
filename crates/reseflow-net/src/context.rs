//! What the decoder needs to know about a scene, computed once per observation: the nodes of O frames, the gripper in each, and
//! how much of the episode has gone by.

use burn::module::{Module, Param};
use burn::nn::Linear;
use burn::tensor::{Device, Tensor};
use rand::Rng;

use crate::error::check_numbers;
use crate::init::{linear, linear_around, normal};
use crate::scene_batch::floats;
use crate::tokens::{FOURIER_WIDTH, OFFSET_SCALE_M, TOKEN_VECTORS, fourier, gripper_vectors};
use crate::{DecoderConfig, EncodedScenes, Features, GripperState, NetError, Parameterisation};

/// What is known about a scene besides its clouds.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneState {
    /// The gripper in each of the O frames, oldest first.
    pub frames: Vec<GripperState>,
    /// The gripper when it took hold; its opening plays no part. For networks with [`DecoderConfig::grasp_memory`].
    pub grasp: GripperState,
    /// Executed action steps over the episode's length, in \[0, 1\].
    pub progress: f64,
}

/// The decoder's view of B scenes; all positions are relative to the latest frame's centroid.
#[derive(Debug, Clone)]
pub struct SceneContext {
    /// The latest frame's centroids, world frame, metres.
    pub origins_m: Vec<[f64; 3]>,
    /// Nodes of all frames, scalars `[B·O·K, C]`, vectors with the position as last channel `[3, B·O·K, C + 1]`.
    pub(crate) memory: Features,
    /// Centres of all frames, scalars `[B·O·M, C]`, vectors with the position as last channel `[3, B·O·M, C + 1]`.
    pub(crate) centres: Features,
    /// Scene-wide features, scalars `[B, D]`, vectors `[3, B, V]`.
    pub(crate) scene: Features,
    /// Scene-wide part of the predicted columns and offsets, `[3, B, 3K]`, or velocities, `[3, B, 2K]`.
    pub(crate) skip: Tensor<3>,
    /// Latest node positions over the offset scale, `[3, B, K]`.
    pub(crate) node_positions: Tensor<3>,
}

/// Builds a [`SceneContext`]; a part of the decoder.
#[derive(Module, Debug)]
pub(crate) struct ContextEncoder {
    frame_embedding: Param<Tensor<2>>,
    scalars: Linear,
    vectors: Linear,
    skip: Linear,
    #[module(skip)]
    frames: usize,
    #[module(skip)]
    grasp_memory: bool,
}

impl ContextEncoder {
    /// Draws the weights.
    pub(crate) fn new<R: Rng + ?Sized>(config: &DecoderConfig, device: &Device, rng: &mut R) -> Self {
        let DecoderConfig { frames, nodes, channels, grasp_memory, .. } = *config;
        let vector_inputs =
            frames * (nodes * (channels + 1) + TOKEN_VECTORS) + usize::from(grasp_memory) * TOKEN_VECTORS;
        Self {
            frame_embedding: normal([frames, channels], 0.3, device, rng),
            scalars: linear(
                [frames * (nodes * channels + 1) + FOURIER_WIDTH, config.token_scalars],
                1.0,
                true,
                device,
                rng,
            ),
            vectors: linear([vector_inputs, config.token_vectors], 1.0, false, device, rng),
            skip: skip(config, vector_inputs, device, rng),
            frames,
            grasp_memory,
        }
    }

    /// Combines O encoded frames, oldest first, each holding the same B scenes.
    pub(crate) fn forward(
        &self,
        frames: &[EncodedScenes],
        states: &[SceneState],
    ) -> Result<SceneContext, NetError> {
        let Some(latest) = frames.last().filter(|_| frames.len() == self.frames) else {
            return Err(NetError::Mismatch {
                what: "observation frames",
                expected: self.frames,
                got: frames.len(),
            });
        };
        let scenes = states.len();
        let device = latest.positions.device();
        for frame in frames {
            if frame.centroids_m.len() != scenes {
                return Err(NetError::Mismatch {
                    what: "encoded scenes",
                    expected: scenes,
                    got: frame.centroids_m.len(),
                });
            }
        }
        if let Some(odd) = states.iter().find(|state| state.frames.len() != self.frames) {
            return Err(NetError::Mismatch {
                what: "gripper states",
                expected: self.frames,
                got: odd.frames.len(),
            });
        }
        for (scene, state) in states.iter().enumerate() {
            for (frame, gripper) in state.frames.iter().enumerate() {
                gripper.check("gripper state", scene * self.frames + frame)?;
            }
            state.grasp.check("grasp", scene)?;
            check_numbers("progress", scene, [state.progress])?;
        }
        let [rows, channels] = latest.nodes.scalars.dims();
        let nodes = rows / scenes;
        let origins_m = latest.centroids_m.clone();

        let (mut scalars, mut vectors) = (Vec::new(), Vec::new());
        let mut node_positions = None;
        for (index, frame) in frames.iter().enumerate() {
            let embedding = self.frame_embedding.val().narrow(0, index, 1);
            scalars.push((frame.nodes.scalars.clone() + embedding).reshape([scenes, 1, nodes * channels]));
            let positions =
                frame.positions.clone().reshape([3, scenes, nodes]) + shifts(frame, &origins_m, &device);
            let with_position = vec![frame.nodes.vectors.clone(), positions.clone().reshape([3, rows, 1])];
            vectors.push(Tensor::cat(with_position, 2).reshape([3, scenes, 1, nodes * (channels + 1)]));
            node_positions = Some(positions);
        }
        let scalars = Tensor::cat(scalars, 1);
        let vectors = Tensor::cat(vectors, 2);
        let [_, _, _, vector_width] = vectors.dims();

        let mut parts = vec![vectors.clone().reshape([3, scenes, self.frames * vector_width])];
        if self.grasp_memory {
            parts.push(grippers(states, |state| std::slice::from_ref(&state.grasp), &origins_m, &device));
        }
        parts.push(grippers(states, |state| &state.frames, &origins_m, &device));
        let scene_vectors = Tensor::cat(parts, 2);
        let scene_scalars = Tensor::cat(
            vec![scalars.clone().reshape([scenes, self.frames * nodes * channels]), known(states, &device)],
            1,
        );
        let memory_rows = scenes * self.frames * nodes;
        Ok(SceneContext {
            centres: centres(frames, &origins_m, &device),
            memory: Features {
                scalars: scalars.reshape([memory_rows, channels]),
                vectors: vectors.reshape([3, memory_rows, channels + 1]),
            },
            scene: Features {
                scalars: self.scalars.forward(scene_scalars),
                vectors: self.vectors.forward(scene_vectors.clone()),
            },
            skip: self.skip.forward(scene_vectors),
            node_positions: node_positions.unwrap_or_else(|| latest.positions.clone()),
            origins_m,
        })
    }
}

/// What the scene as a whole adds to the nodes' vectors. Rotations start out near the latest gripper's: two columns that are nearly
/// parallel, which give no rotation to speak of, are rare. Positions start out near the nodes.
fn skip<R: Rng + ?Sized>(config: &DecoderConfig, inputs: usize, device: &Device, rng: &mut R) -> Linear {
    let outputs = config.parameterisation.vectors() * config.nodes;
    let mut around = vec![0.0; inputs * outputs];
    if config.parameterisation == Parameterisation::Endpoint {
        // The last four inputs are the latest gripper's columns and its offset; the first outputs are the nodes' first columns,
        // then their second columns.
        for (column, node) in (0..2).flat_map(|column| (0..config.nodes).map(move |node| (column, node))) {
            around[(inputs - 4 + column) * outputs + column * config.nodes + node] = 1.0;
        }
    }
    linear_around(around, [inputs, outputs], 0.2, device, rng)
}

/// A frame's centroids relative to the latest ones, over the offset scale, `[3, B, 1]`.
fn shifts(frame: &EncodedScenes, origins_m: &[[f64; 3]], device: &Device) -> Tensor<3> {
    let pairs = || frame.centroids_m.iter().zip(origins_m);
    let values = (0..3)
        .flat_map(|axis| pairs().map(move |(from, to)| (from[axis] - to[axis]) / OFFSET_SCALE_M))
        .collect();
    floats(values, [3, origins_m.len(), 1], device)
}

/// The centres of all frames, placed relative to the latest centroid.
fn centres(frames: &[EncodedScenes], origins_m: &[[f64; 3]], device: &Device) -> Features {
    let scenes = origins_m.len();
    let (mut scalars, mut vectors) = (Vec::new(), Vec::new());
    for frame in frames {
        let ([rows, channels], [_, _, width]) = (frame.centres.scalars.dims(), frame.centres.vectors.dims());
        let per_scene = rows / scenes;
        scalars.push(frame.centres.scalars.clone().reshape([scenes, per_scene, channels]));
        let seen = frame.centres.vectors.clone().reshape([3, scenes, per_scene, width]);
        let shift = shifts(frame, origins_m, device).reshape([3, scenes, 1, 1]);
        let placed = seen.clone().narrow(3, width - 1, 1) + shift;
        vectors.push(Tensor::cat(vec![seen.narrow(3, 0, width - 1), placed], 3));
    }
    let (scalars, vectors) = (Tensor::cat(scalars, 1), Tensor::cat(vectors, 2));
    let ([_, per_scene, channels], [_, _, _, width]) = (scalars.dims(), vectors.dims());
    let rows = scenes * per_scene;
    Features { scalars: scalars.reshape([rows, channels]), vectors: vectors.reshape([3, rows, width]) }
}

/// The grippers that `choose` picks of each scene, G of them, as vectors, `[3, B, 4·G]`.
fn grippers(
    states: &[SceneState],
    choose: impl Fn(&SceneState) -> &[GripperState] + Copy,
    origins_m: &[[f64; 3]],
    device: &Device,
) -> Tensor<3> {
    let count = states.first().map_or(0, |state| choose(state).len());
    let values = (0..3)
        .flat_map(|axis| {
            (states.iter().zip(origins_m)).flat_map(move |(state, origin)| {
                choose(state).iter().flat_map(move |gripper| gripper_vectors(gripper, origin, axis))
            })
        })
        .collect();
    floats(values, [3, states.len(), TOKEN_VECTORS * count], device)
}

/// Openings and progress, `[B, O + 16]`.
fn known(states: &[SceneState], device: &Device) -> Tensor<2> {
    let width = FOURIER_WIDTH + states.first().map_or(0, |state| state.frames.len());
    let values = (states.iter())
        .flat_map(|state| state.frames.iter().map(|gripper| gripper.opening).chain(fourier(state.progress)))
        .collect();
    floats(values, [states.len(), width], device)
}
