//! Two vectors to a rotation (Zhou et al. 2019, "On the continuity of rotation representations in neural networks").

use burn::tensor::Tensor;

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

    let no_first = squared_norm(first.clone().detach()).lower_elem(SHORTEST * SHORTEST);
    let column_x = normalize(first.mask_where(no_first.expand([n, 3]), axis_x.clone()));

    let along = column_x.clone().detach();
    let across = squared_norm(along.clone().cross(second.clone().detach(), 1));
    let shortest = (squared_norm(second.clone().detach()) + 1.0) * (SHORTEST * SHORTEST);
    let no_second = across.lower(shortest).expand([n, 3]);
    let near_x = along.slice([0..n, 0..1]).abs().greater_elem(0.8).expand([n, 3]);
    let stand_in = axis_x.mask_where(near_x, axis_y);

    let column_z = normalize(column_x.clone().cross(second.mask_where(no_second, stand_in), 1));
    let column_y = column_z.clone().cross(column_x.clone(), 1);
    Tensor::stack(vec![column_x, column_y, column_z], 2)
}

fn normalize(x: Tensor<2>) -> Tensor<2> {
    x.clone() / squared_norm(x).sqrt()
}
