//! The encoder: colours, geometry and the gripper in, K nodes with features of degrees 0 and 1 out. Runs once per observation.

use burn::module::Module;
use burn::nn::Linear;
use burn::tensor::{Device, Tensor};
use rand::Rng;
use serde::{Deserialize, Serialize};

use crate::higher_degrees::{HigherDegrees, HigherDegreesConfig};
use crate::init::linear;
use crate::scene_batch::CENTRE_VECTORS;
use crate::transformer::centre_frames;
use crate::{
    CloudGraph, Convolution, ConvolutionConfig, Features, GraphConfig, GripperState, HeatMap, HeatMapConfig,
    Interaction, InteractionConfig, NetError, RadialBasis, SceneBatch, Symmetry,
};

/// Sizes of the [`Encoder`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EncoderConfig {
    /// The neighbour graph.
    pub graph: GraphConfig,
    /// Channels C per degree.
    pub channels: usize,
    /// Convolutions among the centres, after the one from the points.
    pub layers: usize,
    /// The highest degree of the centres' features, 1 to 3; above 1 there is a convolution of degrees 0 to this beside each of these.
    #[serde(skip_serializing_if = "is_one")]
    pub max_degree: usize,
    /// Heat-map nodes K.
    pub nodes: usize,
    /// Basis of the lengths between points and centres.
    pub point_radial: RadialBasis,
    /// Basis of the lengths between centres.
    pub centre_radial: RadialBasis,
    /// What the centres are told of the world; filled in from the network.
    #[serde(skip)]
    pub symmetry: Symmetry,
}

/// What is not written, so that a network of degrees 0 and 1 is called what it was before there were others.
fn is_one(max_degree: &usize) -> bool {
    *max_degree == 1
}

impl Default for EncoderConfig {
    fn default() -> Self {
        Self {
            graph: GraphConfig::default(),
            channels: 32,
            layers: 2,
            max_degree: 1,
            nodes: 4,
            point_radial: RadialBasis { count: 8, max_m: 0.12 },
            centre_radial: RadialBasis { count: 8, max_m: 0.3 },
            symmetry: Symmetry::default(),
        }
    }
}

impl EncoderConfig {
    /// Checks that every size makes sense.
    ///
    /// # Errors
    /// [`NetError::Config`] naming the first key that does not.
    pub fn validate(&self) -> Result<(), NetError> {
        self.graph.validate("encoder.graph")?;
        for (key, value) in [("channels", self.channels), ("nodes", self.nodes)] {
            if value == 0 {
                return Err(NetError::Config(format!("encoder.{key} must be at least 1, got 0")));
            }
        }
        let Self { max_degree, layers, .. } = *self;
        if !(1..=3).contains(&max_degree) {
            let fault = format!("encoder.max_degree must be 1, 2 or 3, got {max_degree}");
            return Err(NetError::Config(fault));
        }
        if max_degree > 1 && layers < 2 {
            return Err(NetError::Config(format!(
                "encoder.max_degree = {max_degree} needs encoder.layers of at least 2, got {layers}: one convolution makes the higher degrees and another one uses them"
            )));
        }
        self.point_radial.validate("encoder.point_radial")?;
        self.centre_radial.validate("encoder.centre_radial")
    }

    /// Lays `graphs` behind one another, each with its gripper, with all that an encoder of this configuration looks at.
    ///
    /// # Errors
    /// As [`SceneBatch::collate`].
    pub fn collate<'a>(
        &self,
        graphs: impl IntoIterator<Item = &'a CloudGraph>,
        grippers: &[GripperState],
        device: &Device,
    ) -> Result<SceneBatch, NetError> {
        let graphs: Vec<&CloudGraph> = graphs.into_iter().collect();
        let (points, centres) = (&self.point_radial, &self.centre_radial);
        let mut batch = SceneBatch::collate(graphs.iter().copied(), grippers, points, centres, device)?;
        if self.max_degree > 1 {
            batch.centre_frames = Some(centre_frames(&batch, &graphs, self.max_degree, device)?);
        }
        Ok(batch)
    }

    /// Draws the weights.
    ///
    /// # Errors
    /// As [`Self::validate`].
    pub fn init<R: Rng + ?Sized>(&self, device: &Device, rng: &mut R) -> Result<Encoder, NetError> {
        self.validate()?;
        let channels = self.channels;
        let convolution = |radial: RadialBasis, source_vectors| ConvolutionConfig {
            channels,
            radial: radial.count,
            source_vectors,
        };
        let interaction = InteractionConfig { scalars: channels, vectors: channels, hidden: 2 * channels };
        let higher = HigherDegreesConfig {
            max_degree: self.max_degree,
            channels,
            layers: self.layers,
            radial: self.centre_radial.count,
        };
        let centre_vectors = self.symmetry.vectors(CENTRE_VECTORS);
        Ok(Encoder {
            embed: linear([3, channels], 1.0, true, device, rng),
            place: linear([channels, channels], 1.0, true, device, rng),
            place_vectors: linear([centre_vectors, channels], 1.0, false, device, rng),
            from_points: convolution(self.point_radial, false).init(device, rng),
            point_interaction: interaction.init(device, rng),
            convolutions: (0..self.layers)
                .map(|_| convolution(self.centre_radial, true).init(device, rng))
                .collect(),
            interactions: (0..self.layers).map(|_| interaction.init(device, rng)).collect(),
            heat_map: HeatMapConfig { channels, nodes: self.nodes }.init(device, rng),
            higher: (self.max_degree > 1).then(|| higher.init(device, rng)),
            symmetry: self.symmetry,
        })
    }
}

/// From clouds to nodes; see the module's description.
#[derive(Module, Debug)]
pub struct Encoder {
    embed: Linear,
    place: Linear,
    place_vectors: Linear,
    from_points: Convolution,
    point_interaction: Interaction,
    convolutions: Vec<Convolution>,
    interactions: Vec<Interaction>,
    heat_map: HeatMap,
    /// Beside the convolutions, where there are degrees above 1.
    higher: Option<HigherDegrees>,
    #[module(skip)]
    symmetry: Symmetry,
}

/// What the encoder says about B scenes.
#[derive(Debug, Clone)]
pub struct EncodedScenes {
    /// Centroids, world frame, metres: the origin of `positions`.
    pub centroids_m: Vec<[f64; 3]>,
    /// Node positions over the offset scale, relative to the centroid, `[3, B·K, 1]`.
    pub positions: Tensor<3>,
    /// Node features, scalars `[B·K, C]`, vectors `[3, B·K, C]`.
    pub nodes: Features,
    /// Heat maps over the centres, `[B, K, M]`.
    pub heat: Tensor<3>,
    /// Centre features with the position over the offset scale as last vector, scalars `[B·M, C]`, vectors `[3, B·M, C + 1]`.
    pub centres: Features,
}

impl Encoder {
    /// Encodes a batch of scenes, each in its centroid's frame.
    ///
    /// # Panics
    /// Where the batch was collated with other radial bases or for another highest degree.
    pub fn forward(&self, batch: &SceneBatch) -> EncodedScenes {
        assert_eq!(
            self.higher.is_some(),
            batch.centre_frames.is_some(),
            "Encoder: a batch has frames of its edges where there are degrees above 1, and nowhere else"
        );
        let scenes = batch.len();
        let embedded = self.embed.forward(batch.colors.clone()).tanh();
        let centre_scalars = embedded.clone().select(0, batch.centres.clone());
        let [rows, channels] = centre_scalars.dims();
        let positions = batch.centre_vectors.clone().narrow(2, 0, 1);

        let points =
            Features { scalars: embedded, vectors: Tensor::zeros([3, 1, 1], &batch.colors.device()) };
        let message = self.from_points.forward(&points, centre_scalars.clone(), &batch.point_edges);
        let scalars = centre_scalars + message.scalars;
        // Where the centre is and how the gripper is turned, seen from it; the gate starts at one.
        let gate = self.place.forward(scalars.clone()).reshape([1, rows, channels]).add_scalar(1.0);
        let seen = self.symmetry.seen(batch.centre_vectors.clone(), 0, &batch.centroids_m);
        let placed = gate * self.place_vectors.forward(seen);
        let mut features =
            self.point_interaction.forward(Features { scalars, vectors: message.vectors + placed });
        let mut higher = Vec::new();
        for (layer, interaction) in self.interactions.iter().enumerate() {
            let scalars = features.scalars.clone();
            let message = self.convolutions[layer].forward(&features, scalars, &batch.centre_edges);
            let beside = self.higher.as_ref().zip(batch.centre_frames.as_ref()).map(|(layers, frames)| {
                layers.forward(layer, &features, std::mem::take(&mut higher), frames)
            });
            features = features.plus(message);
            if let Some((message, left)) = beside {
                (features, higher) = (features.plus(message), left);
            }
            features = interaction.forward(features);
        }

        let heat = self.heat_map.weights(scenes, &features);
        let with_position = Features {
            scalars: features.scalars,
            vectors: Tensor::cat(vec![features.vectors, positions], 2),
        };
        let nodes = HeatMap::pool(&heat, with_position.clone());
        EncodedScenes {
            centroids_m: batch.centroids_m.clone(),
            positions: nodes.vectors.clone().narrow(2, channels, 1),
            nodes: Features { scalars: nodes.scalars, vectors: nodes.vectors.narrow(2, 0, channels) },
            heat,
            centres: with_position,
        }
    }
}
