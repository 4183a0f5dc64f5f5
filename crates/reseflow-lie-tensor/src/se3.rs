//! Poses: composition, inverse, action, exponential, logarithm and adjoint of SE(3).
//!
//! Twists are (ω, ρ), the angular part first. Formulas as in Solà, Deray, Atchuthan 2018, "A micro Lie theory for state
//! estimation in robotics", whose twists are (ρ, θ).

use burn::tensor::{Tensor, s};

use crate::so3;

/// A batch of N rigid transforms.
#[derive(Debug, Clone)]
pub struct SE3Tensor {
    /// Rotation matrices, `[N, 3, 3]`.
    pub rotation: Tensor<3>,
    /// Translations, `[N, 3]`, metres.
    pub translation: Tensor<2>,
}

impl SE3Tensor {
    /// The poses in homogeneous matrices, whose last row is not looked at.
    ///
    /// # Shapes
    /// - `matrix`: `[N, 4, 4]`
    pub fn from_matrix(matrix: Tensor<3>) -> Self {
        let [n, _, _] = matrix.dims();
        let rotation = matrix.clone().slice(s![.., 0..3, 0..3]);
        let translation = matrix.slice(s![.., 0..3, 3..4]).reshape([n, 3]);
        Self { rotation, translation }
    }

    /// The homogeneous matrices.
    ///
    /// # Shapes
    /// - output: `[N, 4, 4]`
    pub fn to_matrix(&self) -> Tensor<3> {
        let [n, _] = self.translation.dims();
        let top = Tensor::cat(vec![self.rotation.clone(), self.translation.clone().reshape([n, 3, 1])], 2);
        let zeros = Tensor::zeros([n, 1, 3], (&top.device(), top.dtype()));
        let one = Tensor::ones([n, 1, 1], (&top.device(), top.dtype()));
        Tensor::cat(vec![top, Tensor::cat(vec![zeros, one], 2)], 1)
    }

    /// The number of poses, N.
    pub fn len(&self) -> usize {
        self.translation.dims()[0]
    }

    /// Whether there is no pose at all.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// X Y: `a_from_b.compose(&b_from_c)` is `a_from_c`.
    pub fn compose(&self, other: &Self) -> Self {
        Self {
            rotation: so3::compose(self.rotation.clone(), other.rotation.clone()),
            translation: self.act(other.translation.clone()),
        }
    }

    /// X⁻¹ = (Rᵀ, −Rᵀ p).
    pub fn inverse(&self) -> Self {
        Self {
            rotation: so3::inverse(self.rotation.clone()),
            translation: -so3::act_inverse(self.rotation.clone(), self.translation.clone()),
        }
    }

    /// X⁻¹ Y: `end` seen from `self`.
    pub fn between(&self, end: &Self) -> Self {
        let displacement = end.translation.clone() - self.translation.clone();
        Self {
            rotation: so3::between(self.rotation.clone(), end.rotation.clone()),
            translation: so3::act_inverse(self.rotation.clone(), displacement),
        }
    }

    /// R x + p, one point per pose.
    ///
    /// # Shapes
    /// - `point`: `[N, 3]`
    /// - output: `[N, 3]`
    pub fn act(&self, point: Tensor<2>) -> Tensor<2> {
        so3::act(self.rotation.clone(), point) + self.translation.clone()
    }

    /// Exp(ω, ρ) = (Exp ω, J_l(ω) ρ) (eq. 172).
    ///
    /// # Shapes
    /// - `twist`: `[N, 6]`, angular part first
    pub fn exp(twist: Tensor<2>) -> Self {
        let (angular, linear) = split(twist);
        let translation = so3::act(so3::left_jacobian(angular.clone()), linear);
        Self { rotation: so3::exp(angular), translation }
    }

    /// Log(R, p) = (ω, J_l⁻¹(ω) p) with ω = Log R (eq. 173); at a half-turn see [`so3::log`].
    ///
    /// # Shapes
    /// - output: `[N, 6]`, angular part first
    pub fn log(&self) -> Tensor<2> {
        let angular = so3::log(self.rotation.clone());
        let linear = so3::act(so3::left_jacobian_inverse(angular.clone()), self.translation.clone());
        Tensor::cat(vec![angular, linear], 1)
    }

    /// Ad_X with ξ_spatial = Ad_X ξ_body: \[\[R, 0\], \[p̂ R, R\]\] for twists (ω, ρ) (eq. 175, reordered).
    ///
    /// # Shapes
    /// - output: `[N, 6, 6]`
    pub fn adjoint(&self) -> Tensor<3> {
        let coupling = so3::compose(so3::hat(self.translation.clone()), self.rotation.clone());
        let top = Tensor::cat(vec![self.rotation.clone(), self.rotation.zeros_like()], 2);
        let bottom = Tensor::cat(vec![coupling, self.rotation.clone()], 2);
        Tensor::cat(vec![top, bottom], 1)
    }
}

/// The angular and the linear part of a twist.
///
/// # Shapes
/// - `twist`: `[N, 6]`
/// - output: `[N, 3]` each
pub fn split(twist: Tensor<2>) -> (Tensor<2>, Tensor<2>) {
    (twist.clone().slice(s![.., 0..3]), twist.slice(s![.., 3..6]))
}
