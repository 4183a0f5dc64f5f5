//! SE3ManiNet with K nodes (after RiEMann, arXiv 2403.19460): an SE(3)-Transformer over a cloud, K heat maps, and for every node a
//! position, invariant and equivariant features, and a pose; and the pose on which the nodes agree. Before training these poses are
//! turned much as the gripper is.
//!
//! [`ManiNodes::loss`] takes the consensus, at half weight every node's pose, and the maps' overlap as a penalty, so that nodes neither
//! collapse nor idle.

use burn::module::Module;
use burn::nn::Linear;
use burn::tensor::activation::softmax;
use burn::tensor::{Device, Tensor};
use rand::Rng;
use reseflow_lie_tensor::{SE3Tensor, gram_schmidt};
use serde::{Deserialize, Serialize};

use super::{SE3Transformer, SE3TransformerConfig, SceneFrames};
use crate::consensus::{NodePoses, spread};
use crate::degrees::{
    Fiber, FiberFeatures, FiberHeatMap, FiberHeatMapConfig, FiberLinear, FiberLinearConfig, RadialMlpConfig,
    TensorProductConvolution, TensorProductConvolutionConfig, UniformFiber,
};
use crate::init::{linear, linear_around};
use crate::scene_batch::CENTRE_VECTORS;
use crate::tokens::OFFSET_SCALE_M;
use crate::{CloudGraph, GraphConfig, GripperState, HeatMap, NetError, RadialBasis, SceneBatch};

/// Sizes of an [`SE3ManiNet`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SE3ManiNetConfig {
    /// The neighbour graph.
    pub graph: GraphConfig,
    /// The network over the centres. Its input is set from its own degrees and channels, its radial size from `centre_radial`.
    pub transformer: SE3TransformerConfig,
    /// Heat-map nodes K.
    pub nodes: usize,
    /// Basis of the lengths between points and centres.
    pub point_radial: RadialBasis,
    /// Basis of the lengths between centres.
    pub centre_radial: RadialBasis,
}

impl Default for SE3ManiNetConfig {
    fn default() -> Self {
        Self {
            graph: GraphConfig::default(),
            transformer: SE3TransformerConfig {
                layers: 2,
                output: UniformFiber { max_degree: 3, channels: 8 },
                ..SE3TransformerConfig::default()
            },
            nodes: 4,
            point_radial: RadialBasis { count: 8, max_m: 0.12 },
            centre_radial: RadialBasis { count: 8, max_m: 0.3 },
        }
    }
}

/// The columns of a pose.
const COLUMNS: usize = 2;

/// What a node sees of the gripper as vectors: its three columns, and its offset from the node. They follow the offset from the
/// centroid among a centre's vectors.
const GRIPPER_VECTORS: usize = CENTRE_VECTORS - 1;

impl SE3ManiNetConfig {
    /// The transformer's sizes with those that follow from others.
    fn transformer(&self) -> SE3TransformerConfig {
        let SE3TransformerConfig { max_degree, channels, .. } = self.transformer;
        SE3TransformerConfig {
            input: UniformFiber { max_degree, channels },
            radial: self.centre_radial.count,
            ..self.transformer.clone()
        }
    }

    /// Checks that every size makes sense.
    ///
    /// # Errors
    /// [`NetError::Config`] naming the first key that does not.
    pub fn validate(&self) -> Result<(), NetError> {
        self.graph.validate("mani_net.graph")?;
        for (key, value) in [
            ("nodes", self.nodes),
            ("transformer.max_degree", self.transformer.max_degree),
            ("transformer.output.max_degree", self.transformer.output.max_degree),
        ] {
            if value == 0 {
                return Err(NetError::Config(format!("mani_net.{key} must be at least 1, got 0")));
            }
        }
        self.point_radial.validate("mani_net.point_radial")?;
        self.centre_radial.validate("mani_net.centre_radial")?;
        self.transformer().validate()
    }

    /// Draws the weights.
    ///
    /// # Errors
    /// As [`Self::validate`].
    pub fn init<R: Rng + ?Sized>(&self, device: &Device, rng: &mut R) -> Result<SE3ManiNet, NetError> {
        self.validate()?;
        let transformer = self.transformer();
        let (hidden, output) = (transformer.input, transformer.output);
        let from_points = TensorProductConvolutionConfig {
            input: UniformFiber { max_degree: 0, channels: hidden.channels },
            output: hidden,
            radial: RadialMlpConfig { radial: self.point_radial.count, hidden: transformer.radial_hidden },
        };
        let place = FiberLinearConfig {
            input: Fiber { channels: vec![hidden.channels, CENTRE_VECTORS] },
            output: Fiber { channels: vec![hidden.channels; 2] },
            bias: true,
        };
        Ok(SE3ManiNet {
            embed: linear([3, hidden.channels], 1.0, true, device, rng),
            from_points: from_points.init(device, rng),
            place: place.init(device, rng),
            transformer: transformer.init(device, rng)?,
            heat_map: FiberHeatMapConfig { fiber: output.fiber(), nodes: self.nodes }.init(device, rng),
            columns: columns(output.channels, device, rng),
            offset: linear([output.channels, 3], 1.0, true, device, rng),
            agreement: linear([output.channels, 1], 0.5, false, device, rng),
            config: self.clone(),
        })
    }
}

/// From a node's vectors, and then the gripper's, to the columns of its pose. These start out near the gripper's: of columns drawn
/// anyhow, one node in twenty has a pair so nearly parallel, or so short, that orthonormalising raises rounding fortyfold.
fn columns<R: Rng + ?Sized>(channels: usize, device: &Device, rng: &mut R) -> Linear {
    let inputs = channels + GRIPPER_VECTORS;
    let mut around = vec![0.0; inputs * COLUMNS];
    for column in 0..COLUMNS {
        around[(channels + column) * COLUMNS + column] = 1.0;
    }
    linear_around(around, [inputs, COLUMNS], 0.2, device, rng)
}

/// From clouds to nodes with poses; see the module's description.
#[derive(Module, Debug)]
pub struct SE3ManiNet {
    embed: Linear,
    from_points: TensorProductConvolution,
    place: FiberLinear,
    transformer: SE3Transformer,
    heat_map: FiberHeatMap,
    columns: Linear,
    offset: Linear,
    agreement: Linear,
    #[module(skip)]
    config: SE3ManiNetConfig,
}

/// The K nodes of B scenes; positions are relative to the scene's centroid.
#[derive(Debug, Clone)]
pub struct ManiNodes {
    /// Centroids, world frame, metres.
    pub centroids_m: Vec<[f64; 3]>,
    /// Heat maps over the centres, `[B, K, M]`.
    pub heat: Tensor<3>,
    /// Heat-map positions, metres, `[B·K, 3]`.
    pub positions_m: Tensor<2>,
    /// Features of every degree; degree 0 is the invariant ones.
    pub features: FiberFeatures,
    /// Orientations of every node's pose, `[B·K, 3, 3]`.
    pub rotations: Tensor<3>,
    /// Positions of every node's pose: the heat map's, and an offset in the pose's own frame, metres, `[B·K, 3]`.
    pub translations_m: Tensor<2>,
    /// Consensus weights, `[B, K]`.
    pub weights: Tensor<2>,
    /// Consensus orientations, `[B, 3, 3]`.
    pub consensus_rotations: Tensor<3>,
    /// Consensus positions, metres, `[B, 3]`.
    pub consensus_positions_m: Tensor<2>,
}

impl SE3ManiNet {
    /// The sizes that the weights were drawn for.
    pub fn config(&self) -> &SE3ManiNetConfig {
        &self.config
    }

    /// Encodes scenes, each with its gripper.
    ///
    /// # Errors
    /// As [`SceneBatch::collate`].
    pub fn encode<'a>(
        &self,
        graphs: impl IntoIterator<Item = &'a CloudGraph>,
        grippers: &[GripperState],
        device: &Device,
    ) -> Result<ManiNodes, NetError> {
        let graphs: Vec<&CloudGraph> = graphs.into_iter().collect();
        let SE3ManiNetConfig { point_radial, centre_radial, .. } = &self.config;
        let batch =
            SceneBatch::collate(graphs.iter().copied(), grippers, point_radial, centre_radial, device)?;
        let frames = SceneFrames::new(&batch, graphs, self.config.transformer.max_degree, device)?;
        Ok(self.forward(&batch, &frames))
    }

    /// The nodes of a batch.
    ///
    /// # Panics
    /// Where the batch was collated with other radial bases, or the frames are of lower degrees than the network.
    pub fn forward(&self, batch: &SceneBatch, frames: &SceneFrames) -> ManiNodes {
        let embedded = self.embed.forward(batch.colors.clone()).tanh();
        let [points, channels] = embedded.dims();
        let colors = FiberFeatures { degrees: vec![embedded.clone().reshape([1, points, channels])] };
        let at_centres = embedded.select(0, batch.centres.clone());
        let [centres, _] = at_centres.dims();
        let own = FiberFeatures {
            degrees: vec![at_centres.reshape([1, centres, channels]), batch.centre_vectors.clone()],
        };
        let features = self.from_points.forward(&colors, &frames.points) + self.place.forward(&own);
        let features = self.transformer.forward(features, &frames.centres);

        let heat = self.heat_map.weights(batch.len(), &features);
        let nodes = FiberHeatMap::pool(&heat, &features);
        // The centres' offsets from the centroid are the first of their vectors; the gripper's columns are the same at all of them.
        let vectors = FiberFeatures { degrees: vec![batch.centre_vectors.clone()] };
        let vectors = FiberHeatMap::pool(&heat, &vectors).degrees.remove(0);
        let rows = vectors.dims()[1];
        let positions = vectors.clone().narrow(2, 0, 1).reshape([3, rows]).swap_dims(0, 1);
        let positions = positions.mul_scalar(OFFSET_SCALE_M);

        let seen = Tensor::cat(vec![nodes.degrees[1].clone(), vectors.narrow(2, 1, GRIPPER_VECTORS)], 2);
        let columns = self.columns.forward(seen);
        let column = |index: usize| columns.clone().narrow(2, index, 1).reshape([3, rows]);
        let (first, second) = (column(0), column(1));
        let rotations = gram_schmidt(first.clone().swap_dims(0, 1), second.clone().swap_dims(0, 1));
        let offset = self.offset.forward(nodes.scalars()).reshape([rows, 3, 1]);
        let offset = rotations.clone().matmul(offset).reshape([rows, 3]);
        let translations = positions.clone() + offset.mul_scalar(OFFSET_SCALE_M);

        let by_scene = [batch.len(), rows / batch.len()];
        let weights = softmax(self.agreement.forward(nodes.scalars()).reshape(by_scene), 1);
        let of_nodes = |values: Tensor<2>| values.reshape([3, by_scene[0], by_scene[1]]);
        let (consensus_rotations, consensus_positions_m) = NodePoses {
            first: of_nodes(first),
            second: of_nodes(second),
            positions: of_nodes(translations.clone().swap_dims(0, 1)),
        }
        .consensus(&weights);
        ManiNodes {
            centroids_m: batch.centroids_m.clone(),
            heat,
            positions_m: positions,
            features: nodes,
            rotations,
            translations_m: translations,
            weights,
            consensus_rotations,
            consensus_positions_m,
        }
    }
}

impl ManiNodes {
    /// How much the nodes of a scene look at the same points, `[1]`; as [`HeatMap::overlap`].
    pub fn overlap(&self) -> Tensor<1> {
        HeatMap::overlap(&self.heat)
    }

    /// The weighted root mean square of D_geo (radians and metres in squares) from the nodes' poses to the consensus, `[B]`: how
    /// unsure the network is.
    pub fn spread(&self) -> Tensor<1> {
        let nodes = SE3Tensor { rotation: self.rotations.clone(), translation: self.translations_m.clone() };
        let consensus = SE3Tensor {
            rotation: self.consensus_rotations.clone(),
            translation: self.consensus_positions_m.clone(),
        };
        spread(&consensus, &nodes, &self.weights)
    }
}
