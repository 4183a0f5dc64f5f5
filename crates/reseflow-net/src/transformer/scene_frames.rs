//! The edges of a batch of scenes with their frames.

use burn::tensor::Device;

use crate::degrees::EdgeFrames;
use crate::{CloudGraph, EdgeList, NetError, SceneBatch};

/// The frames of both kinds of edges of a [`SceneBatch`].
#[derive(Debug, Clone)]
pub struct SceneFrames {
    /// Edges from points to centres.
    pub points: EdgeFrames,
    /// Edges among centres.
    pub centres: EdgeFrames,
}

impl SceneFrames {
    /// The frames of a `batch`, which was made of these `graphs` in this order.
    ///
    /// # Errors
    /// [`NetError::Mismatch`] where the graphs have another number of edges than the batch.
    pub fn new<'a>(
        batch: &SceneBatch,
        graphs: impl IntoIterator<Item = &'a CloudGraph>,
        max_degree: usize,
        device: &Device,
    ) -> Result<Self, NetError> {
        let graphs: Vec<&CloudGraph> = graphs.into_iter().collect();
        let displacements = |edges: fn(&CloudGraph) -> &EdgeList| {
            graphs.iter().flat_map(move |graph| &edges(graph).displacement_m)
        };
        let frames = |tensors: &crate::EdgeTensors, edges| {
            EdgeFrames::new(tensors.clone(), displacements(edges), max_degree, device)
        };
        Ok(Self {
            points: frames(&batch.point_edges, |graph| &graph.point_edges)?,
            centres: frames(&batch.centre_edges, |graph| &graph.centre_edges)?,
        })
    }
}
