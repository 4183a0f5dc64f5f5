//! The edges of a batch of scenes with their frames.

use burn::tensor::Device;

use crate::degrees::EdgeFrames;
use crate::{CloudGraph, NetError, SceneBatch};

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
        let displacements = graphs.iter().flat_map(|graph| &graph.point_edges.displacement_m);
        Ok(Self {
            points: EdgeFrames::new(batch.point_edges.clone(), displacements, max_degree, device)?,
            centres: centre_frames(batch, &graphs, max_degree, device)?,
        })
    }
}

/// The frames of the edges among the centres alone.
pub(crate) fn centre_frames(
    batch: &SceneBatch,
    graphs: &[&CloudGraph],
    max_degree: usize,
    device: &Device,
) -> Result<EdgeFrames, NetError> {
    let displacements = graphs.iter().flat_map(|graph| &graph.centre_edges.displacement_m);
    EdgeFrames::new(batch.centre_edges.clone(), displacements, max_degree, device)
}
