//! To which motions the network is equivariant. One that is not equivariant to all is told more: which way is up, or which way all of the
//! world's axes point and where in the world things are.
//!
//! With the three axes among the vectors, scalars can be components of any vector and vectors can have any components, so any function of
//! world coordinates can be learned. Everything else stays as it is, which makes the networks worth comparing.

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
    /// A scene that is shifted, or turned about the vertical, has the answer so moved; the network sees the vertical, the world's z axis,
    /// and so which rotations are tilts.
    #[serde(rename = "upright")]
    Upright,
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
        relative
            + match self {
                Symmetry::SE3 => 0,
                Symmetry::Upright => 1,
                Symmetry::None => WORLD_AXES.len() + 1,
            }
    }

    /// The vectors that a centre or a token is seen with: its own, then the vertical or the three axes and the absolute position.
    ///
    /// # Shapes
    /// - `relative`: its own, `[3, B·R, V]`, among them in channel `position` its offset from the scene's origin over the offset scale
    /// - `origins_m`: one a scene, B
    /// - output: `[3, B·R, V]`, `[3, B·R, V + 1]` or `[3, B·R, V + 4]`
    pub(crate) fn seen(self, relative: Tensor<3>, position: usize, origins_m: &[[f64; 3]]) -> Tensor<3> {
        let [_, rows, _] = relative.dims();
        let axes = |axes: &[[f64; 3]]| world_axes(axes, rows, &relative.device());
        match self {
            Symmetry::SE3 => relative,
            Symmetry::Upright => {
                let up = axes(&[VERTICAL]);
                Tensor::cat(vec![relative, up], 2)
            }
            Symmetry::None => {
                let axes = axes(&WORLD_AXES);
                let places = relative.clone().narrow(2, position, 1);
                Tensor::cat(vec![relative, axes, absolute(places, origins_m)], 2)
            }
        }
    }
}

const VERTICAL: [f64; 3] = [0.0, 0.0, 1.0];
const WORLD_AXES: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], VERTICAL];

/// The axes, the same in every row, `[3, rows, axes]`.
fn world_axes(axes: &[[f64; 3]], rows: usize, device: &Device) -> Tensor<3> {
    let component =
        |component: usize| (0..rows).flat_map(move |_| axes.iter().map(move |axis| axis[component]));
    floats((0..3).flat_map(component).collect(), [3, rows, axes.len()], device)
}

/// Each place's position in the world over the offset scale, `[3, B·R, 1]`; `places` are the offsets from the scenes' origins, likewise.
fn absolute(places: Tensor<3>, origins_m: &[[f64; 3]]) -> Tensor<3> {
    let [_, rows, _] = places.dims();
    let scenes = origins_m.len();
    let origins = (0..3).flat_map(|axis| origins_m.iter().map(move |origin| origin[axis] / OFFSET_SCALE_M));
    let origins = floats(origins.collect(), [3, scenes, 1], &places.device());
    (places.reshape([3, scenes, rows / scenes]) + origins).reshape([3, rows, 1])
}
