//! Features of degrees 0 and 1, and the products between vectors.
//!
//! Vectors keep the spatial axis first (`[3, P, C]`): every component is one contiguous matrix, a channel mixing is one matrix
//! product, and an invariant gate `[1, P, C]` broadcasts along the outermost axis.

use burn::tensor::Tensor;

use crate::shape::must_be;

/// Features of P points with C channels per degree.
#[derive(Debug, Clone)]
pub struct Features {
    /// Degree 0, `[P, C]`: unchanged by a rotation.
    pub scalars: Tensor<2>,
    /// Degree 1, `[3, P, C]`: turned by a rotation along the first axis.
    pub vectors: Tensor<3>,
}

impl Features {
    /// The sum of features of the same sizes.
    ///
    /// # Panics
    /// Where the sizes differ.
    pub fn plus(self, other: Self) -> Self {
        must_be("sum of scalars", self.scalars.dims(), other.scalars.dims());
        must_be("sum of vectors", self.vectors.dims(), other.vectors.dims());
        Self { scalars: self.scalars + other.scalars, vectors: self.vectors + other.vectors }
    }

    /// Scales scalars by 1/√(1 + mean s²) and vectors by 1/√(1 + mean ‖v‖²): bounded, smooth at zero, equivariant.
    pub fn soft_normalize(self) -> Self {
        let scalar_rms = self.scalars.clone().square().mean_dim(1).add_scalar(1.0).sqrt();
        let vector_rms = self.vectors.clone().square().sum_dim(0).mean_dim(2).add_scalar(1.0).sqrt();
        Self { scalars: self.scalars / scalar_rms, vectors: self.vectors / vector_rms }
    }
}

/// Channel-wise inner product ⟨a, b⟩.
///
/// # Shapes
/// - a, b: `[3, P, C]`
/// - output: `[P, C]`
///
/// # Panics
/// Where the shapes do not go together.
pub fn dot(a: Tensor<3>, b: Tensor<3>) -> Tensor<2> {
    let [_, points, channels] = a.dims();
    (a * b).sum_dim(0).reshape([points, channels])
}

/// Channel-wise cross product a × b; the one product here that a reflection does not commute with.
///
/// # Shapes
/// - a: `[3, P, C]`
/// - b: `[3, P, C]` or `[3, P, 1]`
/// - output: `[3, P, C]`
///
/// # Panics
/// Where the shapes do not go together.
pub fn cross(a: Tensor<3>, b: Tensor<3>) -> Tensor<3> {
    let [ax, ay, az] = [0, 1, 2].map(|i| a.clone().narrow(0, i, 1));
    let [bx, by, bz] = [0, 1, 2].map(|i| b.clone().narrow(0, i, 1));
    Tensor::cat(
        vec![
            ay.clone() * bz.clone() - az.clone() * by.clone(),
            az * bx.clone() - ax.clone() * bz,
            ax * by - ay * bx,
        ],
        0,
    )
}
