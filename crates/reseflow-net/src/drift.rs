//! The drift model: encoder and decoder under one configuration.

use burn::module::Module;
use burn::tensor::Device;
use rand::Rng;
use serde::{Deserialize, Serialize};

use crate::{
    CloudGraph, Decoder, DecoderConfig, EncodedScenes, Encoder, EncoderConfig, EndpointPrediction,
    GripperState, NetError, SceneContext, SceneState, Symmetry, TokenBatch, TwistPrediction,
};

/// Sizes of a [`DriftNet`].
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DriftNetConfig {
    /// The encoder.
    pub encoder: EncoderConfig,
    /// The decoder.
    pub decoder: DecoderConfig,
    /// Whether the network is equivariant.
    #[serde(skip_serializing_if = "Symmetry::is_se3")]
    pub symmetry: Symmetry,
}

impl DriftNetConfig {
    /// Checks that every size makes sense.
    ///
    /// # Errors
    /// [`NetError::Config`] naming the first key that does not.
    pub fn validate(&self) -> Result<(), NetError> {
        self.encoder.validate()?;
        self.decoder.validate()
    }

    /// Draws the weights.
    ///
    /// # Errors
    /// As [`Self::validate`].
    pub fn init<R: Rng + ?Sized>(&self, device: &Device, rng: &mut R) -> Result<DriftNet, NetError> {
        self.validate()?;
        let decoder = DecoderConfig {
            nodes: self.encoder.nodes,
            channels: self.encoder.channels,
            symmetry: self.symmetry,
            ..self.decoder.clone()
        };
        let encoder = EncoderConfig { symmetry: self.symmetry, ..self.encoder.clone() };
        Ok(DriftNet {
            encoder: encoder.init(device, rng)?,
            decoder: decoder.init(device, rng)?,
            config: self.clone(),
        })
    }
}

/// Encoder and decoder. Encode and build the context once per observation, then decode once per solver step: with
/// [`DriftNet::decode`] or [`DriftNet::decode_twists`], whichever `decoder.parameterisation` says.
#[derive(Module, Debug)]
pub struct DriftNet {
    encoder: Encoder,
    decoder: Decoder,
    #[module(skip)]
    config: DriftNetConfig,
}

impl DriftNet {
    /// The configuration that the network was made with.
    pub fn config(&self) -> &DriftNetConfig {
        &self.config
    }

    /// Encodes one frame of each of B scenes: its cloud's graph and the gripper at that time.
    ///
    /// # Errors
    /// As [`EncoderConfig::collate`].
    pub fn encode<'a>(
        &self,
        graphs: impl IntoIterator<Item = &'a CloudGraph>,
        grippers: &[GripperState],
        device: &Device,
    ) -> Result<EncodedScenes, NetError> {
        let batch = self.config.encoder.collate(graphs, grippers, device)?;
        Ok(self.encoder.forward(&batch))
    }

    /// Combines O encoded frames, oldest first, with the grippers' states.
    ///
    /// # Errors
    /// [`NetError::Mismatch`] where frames and states do not go together; [`NetError::NonFinite`] and [`NetError::OutOfRange`]
    /// naming the gripper state or progress that is not finite or beyond 1e6.
    pub fn context(&self, frames: &[EncodedScenes], states: &[SceneState]) -> Result<SceneContext, NetError> {
        self.decoder.context(frames, states)
    }

    /// Predicts the clean trajectory from a noisy one.
    ///
    /// # Errors
    /// [`NetError::Mismatch`] where the tokens do not fit the network or the context, [`NetError::Parameterisation`] where the
    /// network was configured for twists.
    pub fn decode(
        &self,
        context: &SceneContext,
        tokens: &TokenBatch,
    ) -> Result<EndpointPrediction, NetError> {
        self.decoder.forward(context, tokens)
    }

    /// Predicts the velocity of a noisy trajectory along the flow.
    ///
    /// # Errors
    /// [`NetError::Mismatch`] where the tokens do not fit the network or the context, [`NetError::Parameterisation`] where the
    /// network was configured for endpoints.
    pub fn decode_twists(
        &self,
        context: &SceneContext,
        tokens: &TokenBatch,
    ) -> Result<TwistPrediction, NetError> {
        self.decoder.twists(context, tokens)
    }
}
