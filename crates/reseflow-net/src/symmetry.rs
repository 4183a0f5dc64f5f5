//! Whether the network is equivariant, and what one that is not is told beside: where the world's axes point, and where in the world
//! things are.
//!
//! With the three axes among the vectors, scalars can be components of any vector and vectors can have any components, so any function of
//! world coordinates can be learned. Everything else stays as it is, which makes the two networks worth comparing.

use burn::tensor::{Device, Tensor};
use serde::{Deserialize, Serialize};

use crate::scene_batch::floats;
use crate::tokens::OFFSET_SCALE_M;

/// What a change of the world's frame does to the answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Symmetry {
    /// A moved scene has the moved answer.
    #[default]
    #[serde(rename = "se3")]
    SE3,
    /// The network sees the world's axes and absolute positions, and knows nothing of motions but what its training shows it: the control
    /// that says what equivariance is worth.
    #[serde(rename = "none")]
    None,
}

impl Symmetry {
    pub(crate) fn is_se3(&self) -> bool {
        *self == Symmetry::SE3
    }

    /// How many vectors a centre or a token has that has `relative` ones of its own.
    pub(crate) fn vectors(self, relative: usize) -> usize {
        if self.is_se3() { relative } else { relative + WORLD_VECTORS }
    }

    /// The vectors that a centre or a token is seen with.
    ///
    /// # Shapes
    /// - `relative`: its own, `[3, B·R, V]`, among them in channel `position` its offset from the scene's origin over the offset scale
    /// - `origins_m`: one a scene, B
    /// - output: `[3, B·R, V]`, or with the world's `[3, B·R, V + 4]`
    pub(crate) fn seen(self, relative: Tensor<3>, position: usize, origins_m: &[[f64; 3]]) -> Tensor<3> {
        if self.is_se3() {
            return relative;
        }
        let places = relative.clone().narrow(2, position, 1);
        Tensor::cat(vec![relative, world_vectors(places, origins_m)], 2)
    }
}

/// The world's three axes and the absolute position.
const WORLD_VECTORS: usize = 4;

/// The axes, the same for all, and each place's position in the world over the offset scale, `[3, B·R, 4]`; `places` are `[3, B·R, 1]`.
fn world_vectors(places: Tensor<3>, origins_m: &[[f64; 3]]) -> Tensor<3> {
    let device: Device = places.device();
    let [_, rows, _] = places.dims();
    let scenes = origins_m.len();
    let axes = (0..3)
        .flat_map(|component| (0..3 * rows).map(move |index| if index % 3 == component { 1.0 } else { 0.0 }));
    let axes = floats(axes.collect(), [3, rows, 3], &device);
    let origins = (0..3).flat_map(|axis| origins_m.iter().map(move |origin| origin[axis] / OFFSET_SCALE_M));
    let origins = floats(origins.collect(), [3, scenes, 1], &device);
    let absolute = (places.reshape([3, scenes, rows / scenes]) + origins).reshape([3, rows, 1]);
    Tensor::cat(vec![axes, absolute], 2)
}
