//! The trajectory decoder: L tokens attend to the nodes and to each other; every node predicts every pose. Runs once per solver
//! step.
//!
//! A node's prediction of a pose is two columns (made a rotation by Gram–Schmidt) and an offset from the node. The consensus
//! averages columns and positions under invariant weights and orthonormalises once. Where the network is to say the drift itself
//! ([`Parameterisation::Twist`]), its last layer is another, in `twist.rs`.

use burn::module::{Module, Param};
use burn::nn::Linear;
use burn::tensor::activation::softmax;
use burn::tensor::{Device, Tensor};
use rand::Rng;
use reseflow_lie_tensor::SE3Tensor;
use serde::{Deserialize, Serialize};

use crate::consensus::{NodePoses, spread};
use crate::context::ContextEncoder;
use crate::init::{linear, normal};
use crate::tokens::{FOURIER_WIDTH, OFFSET_SCALE_M, TOKEN_VECTORS};
use crate::twist::TWIST_WIDTH;
use crate::{
    EncodedScenes, Features, Interaction, InteractionConfig, InvariantAttention, InvariantAttentionConfig,
    NetError, PointerAttention, PointerAttentionConfig, SceneContext, SceneState, Symmetry, TokenBatch,
    TwistPrediction,
};

/// What the decoder says of the flow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Parameterisation {
    /// The clean poses Ĥ¹, by [`Decoder::forward`].
    #[default]
    Endpoint,
    /// The drift, a body twist for each pose, by [`Decoder::twists`].
    Twist,
}

impl Parameterisation {
    /// Equivariant vectors for each pose of a node: two columns and an offset, or an angular and a linear velocity.
    pub(crate) fn vectors(self) -> usize {
        match self {
            Parameterisation::Endpoint => 3,
            Parameterisation::Twist => 2,
        }
    }

    fn is_endpoint(&self) -> bool {
        *self == Parameterisation::Endpoint
    }
}

/// Sizes of the [`Decoder`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DecoderConfig {
    /// Trajectory steps L.
    pub horizon: usize,
    /// Observation frames O.
    pub frames: usize,
    /// Layers of interaction, self-attention and attention to the nodes and centres.
    pub layers: usize,
    /// Scalar channels per token, D.
    pub token_scalars: usize,
    /// Vector channels per token, V.
    pub token_vectors: usize,
    /// What is predicted.
    #[serde(skip_serializing_if = "Parameterisation::is_endpoint")]
    pub parameterisation: Parameterisation,
    /// Heads of the attention that points at centres; 0 leaves that attention out.
    pub pointers: usize,
    /// Whether fingers are alike: of a trajectory and the same turned by half a turn about the approach axis, a network that
    /// answers with endpoints is then taught the one that closes along its motion, and a policy takes the one that begins closing more nearly as
    /// the gripper does. The network itself does not change.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub nearest_half_turn: bool,
    /// Whether the tokens are told where the gripper took hold of what it holds, which one frame alone does not show.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub grasp_memory: bool,
    /// Nodes K; filled in from the encoder.
    #[serde(skip)]
    pub nodes: usize,
    /// Node channels C; filled in from the encoder.
    #[serde(skip)]
    pub channels: usize,
    /// What the tokens are told of the world; filled in from the network.
    #[serde(skip)]
    pub symmetry: Symmetry,
}

impl Default for DecoderConfig {
    fn default() -> Self {
        Self {
            horizon: 10,
            frames: 2,
            layers: 3,
            token_scalars: 64,
            token_vectors: 32,
            parameterisation: Parameterisation::Endpoint,
            pointers: 4,
            nearest_half_turn: false,
            grasp_memory: false,
            nodes: 4,
            channels: 32,
            symmetry: Symmetry::default(),
        }
    }
}

impl DecoderConfig {
    /// Checks that every size makes sense.
    ///
    /// # Errors
    /// [`NetError::Config`] naming the first key that does not.
    pub fn validate(&self) -> Result<(), NetError> {
        for (key, value) in [
            ("horizon", self.horizon),
            ("frames", self.frames),
            ("token_scalars", self.token_scalars),
            ("token_vectors", self.token_vectors),
            ("nodes", self.nodes),
            ("channels", self.channels),
        ] {
            if value == 0 {
                return Err(NetError::Config(format!("decoder.{key} must be at least 1, got 0")));
            }
        }
        let heads = self.pointers.max(1);
        if !self.token_scalars.is_multiple_of(heads) || !self.token_vectors.is_multiple_of(heads) {
            return Err(NetError::Config(format!(
                "decoder.pointers must divide decoder.token_scalars and decoder.token_vectors, got {heads} heads for {} and {}",
                self.token_scalars, self.token_vectors
            )));
        }
        Ok(())
    }

    /// Draws the weights.
    ///
    /// # Errors
    /// As [`Self::validate`].
    pub fn init<R: Rng + ?Sized>(&self, device: &Device, rng: &mut R) -> Result<Decoder, NetError> {
        self.validate()?;
        let token = [self.token_scalars, self.token_vectors];
        let node = [self.channels, self.channels + 1];
        let interaction =
            InteractionConfig { scalars: token[0], vectors: token[1], hidden: token[0] + 2 * token[1] };
        let to_self = InvariantAttentionConfig { query: token, memory: token, key: 32 };
        let to_nodes = InvariantAttentionConfig { query: token, memory: node, key: 32 };
        let to_centres = PointerAttentionConfig { query: token, memory: node, heads: self.pointers, key: 16 };
        Ok(Decoder {
            context: ContextEncoder::new(self, device, rng),
            step_embedding: normal([self.horizon, token[0]], 0.3, device, rng),
            scalar_input: linear([FOURIER_WIDTH + 1, token[0]], 1.0, false, device, rng),
            vector_input: linear([self.symmetry.vectors(TOKEN_VECTORS), token[1]], 1.0, false, device, rng),
            interactions: (0..self.layers).map(|_| interaction.init(device, rng)).collect(),
            self_attention: (0..self.layers).map(|_| to_self.init(device, rng)).collect(),
            pointers: (0..if self.pointers == 0 { 0 } else { self.layers })
                .map(|_| to_centres.init(device, rng))
                .collect(),
            node_attention: (0..self.layers).map(|_| to_nodes.init(device, rng)).collect(),
            poses: linear([token[1], self.parameterisation.vectors() * self.nodes], 0.5, false, device, rng),
            consensus: linear([token[0], self.nodes], 0.5, false, device, rng),
            opening: linear([token[0], 1], 0.5, true, device, rng),
            twists: (self.parameterisation == Parameterisation::Twist)
                .then(|| linear([token[0], TWIST_WIDTH * self.nodes], 0.5, true, device, rng)),
            nodes: self.nodes,
            symmetry: self.symmetry,
        })
    }
}

/// From a scene and a noisy trajectory to the clean one; see the module's description.
#[derive(Module, Debug)]
pub struct Decoder {
    context: ContextEncoder,
    step_embedding: Param<Tensor<2>>,
    scalar_input: Linear,
    vector_input: Linear,
    interactions: Vec<Interaction>,
    self_attention: Vec<InvariantAttention>,
    node_attention: Vec<InvariantAttention>,
    pointers: Vec<PointerAttention>,
    pub(crate) poses: Linear,
    pub(crate) consensus: Linear,
    pub(crate) opening: Linear,
    /// In twist form alone: what scalars add to the body twists.
    pub(crate) twists: Option<Linear>,
    #[module(skip)]
    pub(crate) nodes: usize,
    #[module(skip)]
    symmetry: Symmetry,
}

/// The predicted clean trajectory Ĥ¹, relative to the scenes' origins.
#[derive(Debug, Clone)]
pub struct EndpointPrediction {
    /// Consensus rotations, `[B·L, 3, 3]`.
    pub rotations: Tensor<3>,
    /// Consensus positions, metres, `[B·L, 3]`.
    pub positions_m: Tensor<2>,
    /// Openings, not clamped, `[B·L, 1]`.
    pub openings: Tensor<2>,
    /// Every node's rotations, `[B·L·K, 3, 3]`.
    pub node_rotations: Tensor<3>,
    /// Every node's positions, metres, `[B·L·K, 3]`.
    pub node_positions_m: Tensor<2>,
    /// Consensus weights, `[B·L, K]`.
    pub weights: Tensor<2>,
}

impl EndpointPrediction {
    /// The weighted root mean square of D_geo (radians and metres in squares) from the nodes' poses to the consensus, `[B·L]`: how
    /// unsure the network is.
    pub fn spread(&self) -> Tensor<1> {
        let nodes =
            SE3Tensor { rotation: self.node_rotations.clone(), translation: self.node_positions_m.clone() };
        let consensus = SE3Tensor { rotation: self.rotations.clone(), translation: self.positions_m.clone() };
        spread(&consensus, &nodes, &self.weights)
    }
}

impl Decoder {
    /// What the decoder needs to know about the scenes; once per observation.
    ///
    /// # Errors
    /// [`NetError::Mismatch`] where frames and states do not go together.
    pub fn context(&self, frames: &[EncodedScenes], states: &[SceneState]) -> Result<SceneContext, NetError> {
        self.context.forward(frames, states)
    }

    /// What the weights were drawn for.
    pub fn parameterisation(&self) -> Parameterisation {
        if self.twists.is_some() { Parameterisation::Twist } else { Parameterisation::Endpoint }
    }

    /// The endpoint that the tokens flow towards; once per solver step.
    ///
    /// # Errors
    /// [`NetError::Mismatch`] where the tokens have another horizon or batch than the network and the context,
    /// [`NetError::Parameterisation`] where the decoder predicts twists.
    pub fn forward(
        &self,
        context: &SceneContext,
        tokens: &TokenBatch,
    ) -> Result<EndpointPrediction, NetError> {
        self.must_predict(Parameterisation::Endpoint)?;
        let features = self.features(context, tokens)?;
        Ok(self.read_out(context, features, tokens.horizon))
    }

    /// The drift of the tokens; once per solver step.
    ///
    /// # Errors
    /// [`NetError::Mismatch`] where the tokens have another horizon or batch than the network and the context,
    /// [`NetError::Parameterisation`] where the decoder predicts endpoints.
    pub fn twists(&self, context: &SceneContext, tokens: &TokenBatch) -> Result<TwistPrediction, NetError> {
        self.must_predict(Parameterisation::Twist)?;
        let features = self.features(context, tokens)?;
        Ok(self.read_out_twists(context, tokens, features))
    }

    fn must_predict(&self, asked: Parameterisation) -> Result<(), NetError> {
        let configured = self.parameterisation();
        if configured == asked { Ok(()) } else { Err(NetError::Parameterisation { configured, asked }) }
    }

    /// The tokens' features after all layers.
    fn features(&self, context: &SceneContext, tokens: &TokenBatch) -> Result<Features, NetError> {
        let [horizon, scalar_width] = self.step_embedding.dims();
        if tokens.horizon != horizon {
            return Err(NetError::Mismatch {
                what: "tokens per trajectory",
                expected: horizon,
                got: tokens.horizon,
            });
        }
        let scenes = context.origins_m.len();
        let [rows, _] = tokens.scalars.dims();
        if rows != scenes * horizon {
            return Err(NetError::Mismatch {
                what: "tokens in the batch",
                expected: scenes * horizon,
                got: rows,
            });
        }

        let scalars =
            self.scalar_input.forward(tokens.scalars.clone()).reshape([scenes, horizon, scalar_width])
                + context.scene.scalars.clone().reshape([scenes, 1, scalar_width])
                + self.step_embedding.val().reshape([1, horizon, scalar_width]);
        let [_, _, vector_width] = context.scene.vectors.dims();
        let seen = self.symmetry.seen(tokens.vectors.clone(), TOKEN_VECTORS - 1, &context.origins_m);
        let vectors = self.vector_input.forward(seen).reshape([3, scenes, horizon, vector_width])
            + context.scene.vectors.clone().reshape([3, scenes, 1, vector_width]);
        let mut features = Features {
            scalars: scalars.reshape([rows, scalar_width]),
            vectors: vectors.reshape([3, rows, vector_width]),
        };
        for (layer, interaction) in self.interactions.iter().enumerate() {
            features = interaction.forward(features);
            let from_tokens = self.self_attention[layer].forward(scenes, &features, &features);
            let from_nodes = self.node_attention[layer].forward(scenes, &features, &context.memory);
            let from_centres = self
                .pointers
                .get(layer)
                .map(|pointers| pointers.forward(scenes, &features, &context.centres));
            features = features.plus(from_tokens).plus(from_nodes);
            if let Some(from_centres) = from_centres {
                features = features.plus(from_centres);
            }
            features = features.soft_normalize();
        }
        Ok(features)
    }

    /// Poses of every node and their consensus from the tokens' final features.
    fn read_out(&self, context: &SceneContext, features: Features, horizon: usize) -> EndpointPrediction {
        let (nodes, scenes) = (self.nodes, context.origins_m.len());
        let rows = scenes * horizon;
        let weights = softmax(self.consensus.forward(features.scalars.clone()), 1);
        let openings = self.opening.forward(features.scalars);

        // [3, B, L, 3, K]: first column, second column and offset, per node.
        let poses = self.poses.forward(features.vectors).reshape([3, scenes, horizon, 3 * nodes])
            + context.skip.clone().reshape([3, scenes, 1, 3 * nodes]);
        let poses = poses.reshape([3, rows, 3, nodes]);
        let part = |index: usize| poses.clone().narrow(2, index, 1).reshape([3, rows, nodes]);
        let (first, second, offset) = (part(0), part(1), part(2));
        let positions = (offset.reshape([3, scenes, horizon, nodes])
            + context.node_positions.clone().reshape([3, scenes, 1, nodes]))
        .reshape([3, rows, nodes])
        .mul_scalar(OFFSET_SCALE_M);

        let of_nodes = NodePoses { first, second, positions };
        let (rotations, positions_m) = of_nodes.consensus(&weights);
        let (node_rotations, node_positions_m) = of_nodes.poses();
        EndpointPrediction { rotations, positions_m, openings, node_rotations, node_positions_m, weights }
    }
}
