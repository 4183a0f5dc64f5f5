//! The two geodesics between poses: the screw motion of SE(3), and the product SO(3) × ℝ³ that D_geo measures.
//!
//! Each is a displacement (start, end ↦ body twist) and a retraction (start, body twist ↦ end) that undo each other;
//! the path is the retraction of a fraction of the displacement. Both are unchanged by a change of world frame.

use burn::tensor::Tensor;

use crate::se3::{SE3Tensor, split};
use crate::so3;

/// Which geodesic.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Geodesic {
    /// X Exp(t Log(X⁻¹Y)): the ReSeFlow paper's, one screw motion.
    Screw,
    /// (R_x Exp(t Log(R_xᵀR_y)), p_x + t (p_y − p_x)): rotation and position apart.
    Product,
}

impl Geodesic {
    /// The body twist that leads from `start` to `end` in unit time.
    ///
    /// `Screw`: Log(X⁻¹Y). `Product`: (Log(R_xᵀR_y), R_xᵀ(p_y − p_x)).
    ///
    /// # Shapes
    /// - output: `[N, 6]`, angular part first
    pub fn displacement(self, start: &SE3Tensor, end: &SE3Tensor) -> Tensor<2> {
        let start_from_end = start.between(end);
        match self {
            Self::Screw => start_from_end.log(),
            Self::Product => {
                Tensor::cat(vec![so3::log(start_from_end.rotation), start_from_end.translation], 1)
            }
        }
    }

    /// Where the body twist leads from `start` in unit time.
    ///
    /// `Screw`: X Exp(ξ). `Product`: (R_x Exp(ω), p_x + R_x ρ).
    ///
    /// # Shapes
    /// - `twist`: `[N, 6]`, angular part first
    pub fn retract(self, start: &SE3Tensor, twist: Tensor<2>) -> SE3Tensor {
        let step = match self {
            Self::Screw => SE3Tensor::exp(twist),
            Self::Product => {
                let (angular, linear) = split(twist);
                SE3Tensor { rotation: so3::exp(angular), translation: linear }
            }
        };
        start.compose(&step)
    }

    /// The point at the fraction `time` of the way from `start` (0) to `end` (1).
    ///
    /// # Shapes
    /// - `time`: `[N]`
    pub fn interpolate(self, start: &SE3Tensor, end: &SE3Tensor, time: Tensor<1>) -> SE3Tensor {
        let displacement = self.displacement(start, end);
        self.retract(start, displacement * time.unsqueeze_dim(1))
    }
}
