//! Two vectors to a rotation (Zhou et al. 2019, "On the continuity of rotation representations in neural networks").

use burn::tensor::{Tensor, s};

use crate::constant::constant;
use crate::series::squared_norm;

/// Length below which a vector gives no direction.
const SHORTEST: f64 = 1e-6;

/// The rotation whose first column is `first` normalised and whose second is `second` made orthogonal to it.
///
/// Turning both vectors turns the rotation. A `first` shorter than 1e-6, and a `second` whose part across `first` is
/// shorter than 1e-6 (or 1e-6 of its length), give no direction: a fixed axis stands in, the result is still a rotation
/// and the gradient towards that vector is 0. This is the only place where equivariance ends.
///
/// # Shapes
/// - `first`, `second`: `[N, 3]`
/// - output: `[N, 3, 3]`
pub fn gram_schmidt(first: Tensor<2>, second: Tensor<2>) -> Tensor<3> {
    let [n, _] = first.dims();
    let axis_x = constant(&[1.0, 0.0, 0.0], [1, 3], &first).expand([n, 3]);
    let axis_y = constant(&[0.0, 1.0, 0.0], [1, 3], &first).expand([n, 3]);

    let no_first = squared_norm(first.clone().detach()).lower_elem(SHORTEST * SHORTEST).expand([n, 3]);
    let column_x = normalize(first.mask_where(no_first, axis_x.clone()));

    let across = reject(second.clone(), column_x.clone());
    let shortest = (squared_norm(second.detach()) + 1.0) * (SHORTEST * SHORTEST);
    let no_second = squared_norm(across.clone().detach()).lower(shortest).expand([n, 3]);
    let near_x = column_x.clone().detach().slice(s![.., 0..1]).abs().greater_elem(0.8).expand([n, 3]);
    let stand_in = axis_x.mask_where(near_x, axis_y);
    // Projected twice: one projection of a vector nearly along x leaves rounding along x that normalising would raise.
    let column_y = normalize(reject(across.mask_where(no_second, stand_in), column_x.clone()));
    let column_z = column_x.clone().cross(column_y.clone(), 1);
    Tensor::stack(vec![column_x, column_y, column_z], 2)
}

fn normalize(x: Tensor<2>) -> Tensor<2> {
    x.clone() / squared_norm(x).sqrt()
}

/// The part of `x` orthogonal to the unit vector `direction`.
fn reject(x: Tensor<2>, direction: Tensor<2>) -> Tensor<2> {
    let along = x.clone().mul(direction.clone()).sum_dim(1);
    x - direction * along
}
