//! The path from noise to data: the paper's geodesic H^t = H⁰ Exp(t log((H⁰)⁻¹ H¹)), a screw motion; the opening moves in a line.

use reseflow_data::ActionChunk;

/// The screw path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ScrewPath;

impl ScrewPath {
    /// The state at flow time `t` ∈ \[0, 1\] between noise and data of the same horizon.
    pub fn at(&self, noise: &ActionChunk, data: &ActionChunk, t: f64) -> ActionChunk {
        ActionChunk(noise.iter().zip(data.iter()).map(|(start, end)| start.interpolate(end, t)).collect())
    }
}
