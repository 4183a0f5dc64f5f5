//! Many clouds with their graphs as one flat batch of tensors.

use std::sync::Arc;

use burn::tensor::{Device, Int, Tensor, TensorData};

use crate::degrees::EdgeFrames;
use crate::tokens::{OFFSET_SCALE_M, gripper_vectors};
use crate::{CloudGraph, EdgeList, GripperState, NetError, RadialBasis};

/// Displacements shorter than this point nowhere in particular: the direction fades out smoothly below it, metres.
pub(crate) const SHORTEST_DIRECTION_M: f64 = 1e-3;

/// Edges of a whole batch, grouped by receiver.
#[derive(Debug, Clone)]
pub struct EdgeTensors {
    /// Edges per receiver.
    pub per_receiver: usize,
    /// Source rows, `[E]`.
    pub sources: Tensor<1, Int>,
    /// The same on the host.
    pub source_rows: Arc<[u32]>,
    /// r / √(‖r‖² + ε²), `[3, E, 1]`.
    pub directions: Tensor<3>,
    /// Radial basis of the edge length, `[E, R]`.
    pub radial: Tensor<2>,
    /// Envelope weights, `[E, 1]`.
    pub weights: Tensor<2>,
}

impl EdgeTensors {
    /// Lays `lists` behind one another, each with the number of nodes that its sources index; all have the same edges per receiver.
    ///
    /// # Errors
    /// [`NetError::Config`] where the radial basis makes no sense; [`NetError::Mismatch`] where there is no list, lists differ in their
    /// edges per receiver, or one has not as many displacements and weights as sources, or a source that is no node.
    pub fn collate<'a>(
        lists: impl IntoIterator<Item = (&'a EdgeList, usize)>,
        radial_basis: &RadialBasis,
        device: &Device,
    ) -> Result<Self, NetError> {
        radial_basis.validate("radial_basis")?;
        let lists: Vec<(&EdgeList, usize)> = lists.into_iter().collect();
        let Some((first, _)) = lists.first() else {
            return Err(NetError::Mismatch { what: "lists of edges in a batch", expected: 1, got: 0 });
        };
        for (list, nodes) in &lists {
            check(list, *nodes, first.per_receiver)?;
        }
        Ok(edge_tensors(&lists, radial_basis, device))
    }
}

/// B clouds as tensors; points of all clouds lie in one axis.
#[derive(Debug, Clone)]
pub struct SceneBatch {
    /// Centroids, world frame, metres, one per scene.
    pub centroids_m: Vec<[f64; 3]>,
    /// Centres per scene, M.
    pub centres_per_scene: usize,
    /// Colours, `[P, 3]`.
    pub colors: Tensor<2>,
    /// Rows of the centres among the points, `[B·M]`.
    pub centres: Tensor<1, Int>,
    /// What is known of every centre as vectors, `[3, B·M, 5]`: its offset from the centroid, the gripper's three columns, and the
    /// gripper's offset from the centre; offsets over the offset scale.
    pub centre_vectors: Tensor<3>,
    /// Edges from points to centres.
    pub point_edges: EdgeTensors,
    /// Edges among centres.
    pub centre_edges: EdgeTensors,
    /// The frames of the edges among centres, for an encoder of degrees above 1 ([`crate::EncoderConfig::collate`] makes them).
    pub centre_frames: Option<EdgeFrames>,
}

impl SceneBatch {
    /// Lays `graphs` behind one another, each with its gripper.
    ///
    /// # Errors
    /// [`NetError::Mismatch`] where there is no graph, graphs were built with different sizes, or there is not one gripper for each,
    /// [`NetError::NonFinite`] and [`NetError::OutOfRange`] naming the gripper that has a number that is not finite or beyond 1e6, and
    /// [`NetError::Config`] where a radial basis makes no sense.
    pub fn collate<'a>(
        graphs: impl IntoIterator<Item = &'a CloudGraph>,
        grippers: &[GripperState],
        point_radial: &RadialBasis,
        centre_radial: &RadialBasis,
        device: &Device,
    ) -> Result<Self, NetError> {
        let graphs: Vec<&CloudGraph> = graphs.into_iter().collect();
        let Some(first) = graphs.first() else {
            return Err(NetError::Mismatch { what: "scenes in a batch", expected: 1, got: 0 });
        };
        if grippers.len() != graphs.len() {
            return Err(NetError::Mismatch { what: "grippers", expected: graphs.len(), got: grippers.len() });
        }
        for (index, gripper) in grippers.iter().enumerate() {
            gripper.check("gripper", index)?;
        }
        point_radial.validate("point_radial")?;
        centre_radial.validate("centre_radial")?;
        let centres_per_scene = first.centres.len();
        for graph in &graphs {
            for (what, expected, got) in [
                ("centres", centres_per_scene, graph.centres.len()),
                ("edges per centre", first.point_edges.per_receiver, graph.point_edges.per_receiver),
                ("edges among centres", first.centre_edges.per_receiver, graph.centre_edges.per_receiver),
            ] {
                if expected != got {
                    return Err(NetError::Mismatch { what, expected, got });
                }
            }
        }
        let points: usize = graphs.iter().map(|graph| graph.positions_m.len()).sum();
        let colors = graphs.iter().flat_map(|graph| graph.colors.iter().flatten().copied()).collect();
        let mut centres = Vec::with_capacity(graphs.len() * centres_per_scene);
        let mut first_point = 0;
        for graph in &graphs {
            centres.extend(graph.centres.iter().map(|&centre| (first_point + centre) as i64));
            first_point += graph.positions_m.len();
        }
        Ok(Self {
            centroids_m: graphs.iter().map(|graph| graph.centroid_m).collect(),
            centres_per_scene,
            colors: floats(colors, [points, 3], device),
            centres: indices(centres, device),
            centre_vectors: centre_vectors(&graphs, grippers, device),
            point_edges: EdgeTensors::collate(
                graphs.iter().map(|graph| (&graph.point_edges, graph.positions_m.len())),
                point_radial,
                device,
            )?,
            centre_edges: EdgeTensors::collate(
                graphs.iter().map(|graph| (&graph.centre_edges, centres_per_scene)),
                centre_radial,
                device,
            )?,
            centre_frames: None,
        })
    }

    /// The number of scenes B.
    pub fn len(&self) -> usize {
        self.centroids_m.len()
    }

    /// Whether there is no scene; never so for a collated batch.
    pub fn is_empty(&self) -> bool {
        self.centroids_m.is_empty()
    }
}

/// The channels of [`SceneBatch::centre_vectors`].
pub(crate) const CENTRE_VECTORS: usize = 5;

fn centre_vectors(graphs: &[&CloudGraph], grippers: &[GripperState], device: &Device) -> Tensor<3> {
    let mut values = Vec::new();
    for axis in 0..3 {
        for (graph, gripper) in graphs.iter().zip(grippers) {
            for &centre in &graph.centres {
                let offset_m = graph.positions_m[centre];
                let centre_m = [0, 1, 2].map(|axis| graph.centroid_m[axis] + offset_m[axis]);
                values.push(offset_m[axis] / OFFSET_SCALE_M);
                values.extend(gripper_vectors(gripper, &centre_m, axis));
            }
        }
    }
    let rows = values.len() / (3 * CENTRE_VECTORS);
    floats(values, [3, rows, CENTRE_VECTORS], device)
}

/// Refuses a list whose parts do not go together, or whose sources are not among `nodes`.
fn check(list: &EdgeList, nodes: usize, per_receiver: usize) -> Result<(), NetError> {
    let edges = list.sources.len();
    // Sources index nodes, so there are at least as many as the largest index and one.
    let reached = list.sources.iter().max().map_or(0, |last| last + 1);
    for (what, expected, got) in [
        ("edges per receiver", per_receiver, list.per_receiver),
        ("displacements of edges", edges, list.displacement_m.len()),
        ("weights of edges", edges, list.weights.len()),
        ("edges left over by whole receivers", 0, edges.checked_rem(per_receiver).unwrap_or(edges)),
        ("nodes that sources of edges index", nodes, reached.max(nodes)),
    ] {
        if expected != got {
            return Err(NetError::Mismatch { what, expected, got });
        }
    }
    Ok(())
}

fn edge_tensors(lists: &[(&EdgeList, usize)], radial_basis: &RadialBasis, device: &Device) -> EdgeTensors {
    let (mut sources, mut directions, mut radial, mut weights) =
        (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let (mut first_source, mut per_receiver) = (0, 0);
    for &(list, source_count) in lists {
        per_receiver = list.per_receiver;
        sources.extend(list.sources.iter().map(|&source| (first_source + source) as u32));
        weights.extend_from_slice(&list.weights);
        for displacement in &list.displacement_m {
            let squared: f64 = displacement.iter().map(|value| value * value).sum();
            let softened = (squared + SHORTEST_DIRECTION_M * SHORTEST_DIRECTION_M).sqrt();
            directions.push(displacement.map(|value| value / softened));
            radial_basis.evaluate_into(squared.sqrt(), &mut radial);
        }
        first_source += source_count;
    }
    let edges = sources.len();
    EdgeTensors {
        per_receiver,
        sources: indices(sources.iter().map(|&source| i64::from(source)).collect(), device),
        source_rows: sources.into(),
        directions: component_first(&directions, device),
        radial: floats(radial, [edges, radial_basis.count], device),
        weights: floats(weights, [edges, 1], device),
    }
}

/// Values as a tensor of the device's own float type.
pub(crate) fn floats<const D: usize>(values: Vec<f64>, shape: [usize; D], device: &Device) -> Tensor<D> {
    Tensor::from_data(TensorData::new(values, shape), device)
}

fn indices(values: Vec<i64>, device: &Device) -> Tensor<1, Int> {
    let count = values.len();
    Tensor::from_data(TensorData::new(values, [count]), device)
}

/// N vectors as `[3, N, 1]`.
fn component_first(vectors: &[[f64; 3]], device: &Device) -> Tensor<3> {
    let values = (0..3).flat_map(|axis| vectors.iter().map(move |vector| vector[axis])).collect();
    floats(values, [3, vectors.len(), 1], device)
}
