//! What both kernels are made of: the flows' encoder, and L tokens that attend to its nodes and to each other.
//!
//! The gripper's axes and its offset enter every centre as vectors, and the nodes' vectors are also read along the gripper's axes, as
//! scalars: so the geometry relative to the gripper survives in degree 0.

use burn::module::{Module, Param};
use burn::nn::Linear;
use burn::tensor::{Device, Tensor, TensorData};
use rand::Rng;
use reseflow_net::init::{linear, normal};
use reseflow_net::{
    DriftNetConfig, EncodedScenes, Encoder, EncoderConfig, Features, Interaction, InteractionConfig,
    InvariantAttention, InvariantAttentionConfig, NetError,
};

use super::input::{KernelInput, OFFSET_SCALE_M, POSE_NUMBERS, SceneView, pose_numbers};
use crate::TrainError;

/// Scalars of a token besides its pose: the level's features and the opening.
const TOKEN_SCALARS: usize = 17;

/// Vectors of a token: its columns, its offset from the gripper, the gripper's columns.
const TOKEN_VECTORS: usize = 7;

/// Octaves of the episode's progress.
const PROGRESS_OCTAVES: usize = 4;

/// Encoder and token layers of one kernel.
#[derive(Module, Debug)]
pub(super) struct Trunk {
    encoder: Encoder,
    frame_embedding: Param<Tensor<2>>,
    step_embedding: Param<Tensor<2>>,
    scene: Linear,
    scalar_input: Linear,
    vector_input: Linear,
    interactions: Vec<Interaction>,
    self_attention: Vec<InvariantAttention>,
    node_attention: Vec<InvariantAttention>,
    #[module(skip)]
    frames: usize,
    #[module(skip)]
    encoder_config: EncoderConfig,
}

/// B encoded scenes as one kernel sees them.
#[derive(Debug, Clone)]
pub(super) struct TrunkScenes {
    /// Nodes of all frames, scalars `[B·O·K, S]`, vectors `[3, B·O·K, C + 1]`.
    memory: Features,
    /// `[B, D]`.
    scene: Tensor<2>,
}

impl Trunk {
    /// Draws the weights.
    pub(super) fn new<R: Rng + ?Sized>(
        config: &DriftNetConfig,
        device: &Device,
        rng: &mut R,
    ) -> Result<Self, TrainError> {
        let (encoder, decoder) = (&config.encoder, &config.decoder);
        let token = [decoder.token_scalars, decoder.token_vectors];
        let vectors = encoder.channels + 1;
        let scalars = encoder.channels + 3 * vectors;
        let interaction =
            InteractionConfig { scalars: token[0], vectors: token[1], hidden: token[0] + 2 * token[1] };
        let to_self = InvariantAttentionConfig { query: token, memory: token, key: 32 };
        let to_nodes = InvariantAttentionConfig { query: token, memory: [scalars, vectors], key: 32 };
        let known = decoder.frames * (encoder.nodes * scalars + POSE_NUMBERS + 1)
            + usize::from(decoder.grasp_memory) * POSE_NUMBERS
            + 2 * PROGRESS_OCTAVES;
        Ok(Self {
            encoder: encoder.init(device, rng)?,
            frame_embedding: normal([decoder.frames, scalars], 0.3, device, rng),
            step_embedding: normal([decoder.horizon, token[0]], 0.3, device, rng),
            scene: linear([known, token[0]], 1.0, true, device, rng),
            scalar_input: linear([TOKEN_SCALARS + POSE_NUMBERS, token[0]], 1.0, false, device, rng),
            vector_input: linear([TOKEN_VECTORS, token[1]], 1.0, false, device, rng),
            interactions: (0..decoder.layers).map(|_| interaction.init(device, rng)).collect(),
            self_attention: (0..decoder.layers).map(|_| to_self.init(device, rng)).collect(),
            node_attention: (0..decoder.layers).map(|_| to_nodes.init(device, rng)).collect(),
            frames: decoder.frames,
            encoder_config: encoder.clone(),
        })
    }

    /// Encodes scenes, once for all noise levels.
    pub(super) fn encode(&self, views: &[&SceneView], device: &Device) -> Result<TrunkScenes, TrainError> {
        if let Some(odd) = views.iter().find(|view| view.graphs.len() != self.frames) {
            let (expected, got) = (self.frames, odd.graphs.len());
            return Err(NetError::Mismatch { what: "observation frames", expected, got }.into());
        }
        let scenes = views.len();
        let axes = gripper_axes(views, device);
        let (mut scalars, mut vectors) = (Vec::new(), Vec::new());
        for frame in 0..self.frames {
            let grippers: Vec<_> = views.iter().map(|view| view.state(frame)).collect();
            let graphs = views.iter().map(|view| &view.graphs[frame]);
            let batch = self.encoder_config.collate(graphs, &grippers, device)?;
            let encoded = self.encoder.forward(&batch);
            let (of_frame, with_position) = self.read(&encoded, views, &axes, frame, device);
            let [rows, width] = of_frame.dims();
            let [_, _, vector_width] = with_position.dims();
            let nodes = rows / scenes;
            scalars.push(of_frame.reshape([scenes, 1, nodes * width]));
            vectors.push(with_position.reshape([3, scenes, 1, nodes * vector_width]));
        }
        let (scalars, vectors) = (Tensor::cat(scalars, 1), Tensor::cat(vectors, 2));
        let [_, frames, all_nodes] = scalars.dims();
        let [_, _, _, node_vectors] = vectors.dims();
        let [_, width] = self.frame_embedding.dims();
        let rows = scenes * frames * (all_nodes / width);
        let known =
            Tensor::cat(vec![scalars.clone().reshape([scenes, frames * all_nodes]), known(views, device)], 1);
        Ok(TrunkScenes {
            memory: Features {
                scalars: scalars.reshape([rows, width]),
                vectors: vectors.reshape([3, rows, node_vectors * scenes * frames / rows]),
            },
            scene: self.scene.forward(known),
        })
    }

    /// One frame's nodes: their scalars with all vectors read along the gripper's axes, and their vectors with the position.
    fn read(
        &self,
        encoded: &EncodedScenes,
        views: &[&SceneView],
        axes: &Tensor<3>,
        frame: usize,
        device: &Device,
    ) -> (Tensor<2>, Tensor<3>) {
        let scenes = views.len();
        let [_, rows, channels] = encoded.nodes.vectors.dims();
        let nodes = rows / scenes;
        let shift = (0..3).flat_map(|axis| {
            (views.iter().zip(&encoded.centroids_m)).map(move |(view, centroid)| {
                (centroid[axis] - view.gripper().translation[axis]) / OFFSET_SCALE_M
            })
        });
        let shift: Tensor<3> =
            Tensor::from_data(TensorData::new(shift.collect::<Vec<f64>>(), [3, scenes, 1]), device);
        let positions = (encoded.positions.clone().reshape([3, scenes, nodes]) + shift).reshape([3, rows, 1]);
        let vectors = Tensor::cat(vec![encoded.nodes.vectors.clone(), positions], 2);
        let mut parts = vec![encoded.nodes.scalars.clone()];
        for axis in 0..3 {
            let along = axes.clone().narrow(2, axis, 1).reshape([3, scenes, 1, 1]);
            let read = (vectors.clone().reshape([3, scenes, nodes, channels + 1]) * along).sum_dim(0);
            parts.push(read.reshape([rows, channels + 1]));
        }
        let scalars = Tensor::cat(parts, 1) + self.frame_embedding.val().narrow(0, frame, 1);
        (scalars, vectors)
    }

    /// The tokens' features; once per evaluation.
    pub(super) fn forward(&self, scenes: &TrunkScenes, input: &KernelInput) -> Result<Features, TrainError> {
        let [horizon, width] = self.step_embedding.dims();
        let [count, _] = scenes.scene.dims();
        let [rows, _] = input.pose_numbers.dims();
        for (what, expected, got) in [
            ("tokens per trajectory", horizon, input.tokens.horizon),
            ("tokens in the batch", count * horizon, rows),
        ] {
            if expected != got {
                return Err(NetError::Mismatch { what, expected, got }.into());
            }
        }
        let numbers = Tensor::cat(vec![input.tokens.scalars.clone(), input.pose_numbers.clone()], 1);
        let scalars = self.scalar_input.forward(numbers).reshape([count, horizon, width])
            + scenes.scene.clone().reshape([count, 1, width])
            + self.step_embedding.val().reshape([1, horizon, width]);
        let vectors = Tensor::cat(vec![input.tokens.vectors.clone(), input.gripper_columns.clone()], 2);
        let mut features =
            Features { scalars: scalars.reshape([rows, width]), vectors: self.vector_input.forward(vectors) };
        let layers = self.interactions.iter().zip(&self.self_attention).zip(&self.node_attention);
        for ((interaction, self_attention), node_attention) in layers {
            features = interaction.forward(features);
            let from_tokens = self_attention.forward(count, &features, &features);
            let from_nodes = node_attention.forward(count, &features, &scenes.memory);
            features = Features {
                scalars: features.scalars + from_tokens.scalars + from_nodes.scalars,
                vectors: features.vectors + from_tokens.vectors + from_nodes.vectors,
            }
            .soft_normalize();
        }
        Ok(features)
    }
}

/// The columns of the latest grippers, `[3, B, 3]`.
fn gripper_axes(views: &[&SceneView], device: &Device) -> Tensor<3> {
    let row = |axis: usize| {
        views.iter().flat_map(move |view| {
            let rotation = view.gripper().rotation.matrix();
            [0, 1, 2].map(|column| rotation[(axis, column)])
        })
    };
    let values: Vec<f64> = (0..3).flat_map(row).collect();
    Tensor::from_data(TensorData::new(values, [3, views.len(), 3]), device)
}

/// The grippers of all frames seen from the latest, their openings, the grasp for those who are told of it, and the progress:
/// `[B, O · 13 + 8]`, or 12 more.
fn known(views: &[&SceneView], device: &Device) -> Tensor<2> {
    let mut values = Vec::new();
    for view in views {
        let gripper_from_world = view.gripper().inverse();
        for (gripper, opening) in view.grippers.iter().zip(&view.openings) {
            values.extend(pose_numbers(&(gripper_from_world * *gripper)));
            values.push(*opening);
        }
        let grasp = view.world_from_grasp.map(|world_from_grasp| gripper_from_world * world_from_grasp);
        values.extend(grasp.iter().flat_map(pose_numbers));
        for octave in 0..PROGRESS_OCTAVES {
            let angle = view.progress * std::f64::consts::FRAC_PI_2 * f64::from(1_u32 << octave);
            values.extend([angle.cos(), angle.sin()]);
        }
    }
    let width = values.len() / views.len();
    Tensor::from_data(TensorData::new(values, [views.len(), width]), device)
}
