//! Twists: elements of se(3) as (ω, ρ), in body or in spatial coordinates, as two types.
//!
//! Lynch and Park, *Modern Robotics*, section 3.3.2; the order is the ReSeFlow paper's, angular first.

use crate::SE3;
use nalgebra::{Matrix4, Matrix6, Vector3, Vector6};
use std::ops::{Add, Mul, Neg, Sub};

macro_rules! twist {
    ($(#[$documentation:meta])* $twist:ident) => {
        $(#[$documentation])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $twist {
            /// ω: the rotation vector or angular velocity, radian (per unit of time).
            pub angular: Vector3<f64>,
            /// ρ: the linear part, metre (per unit of time).
            pub linear: Vector3<f64>,
        }

        impl $twist {
            /// The twist (ω, ρ).
            pub fn new(angular: Vector3<f64>, linear: Vector3<f64>) -> $twist {
                $twist { angular, linear }
            }

            /// The twist of standing still.
            pub fn zero() -> $twist {
                $twist::new(Vector3::zeros(), Vector3::zeros())
            }

            /// The six numbers (ω, ρ).
            pub fn vector6(&self) -> Vector6<f64> {
                let (w, r) = (&self.angular, &self.linear);
                Vector6::new(w.x, w.y, w.z, r.x, r.y, r.z)
            }

            /// The twist with the six numbers (ω, ρ).
            pub fn from_vector6(vector: &Vector6<f64>) -> $twist {
                $twist::new(vector.fixed_rows::<3>(0).into_owned(), vector.fixed_rows::<3>(3).into_owned())
            }

            /// hat: the matrix \[\[ω\]×, ρ; 0, 0\] ∈ se(3).
            pub fn hat(&self) -> Matrix4<f64> {
                let mut hat = Matrix4::zeros();
                hat.fixed_view_mut::<3, 3>(0, 0).copy_from(&self.angular.cross_matrix());
                hat.fixed_view_mut::<3, 1>(0, 3).copy_from(&self.linear);
                hat
            }

            /// ad_ξ = \[\[ω\]×, 0; \[ρ\]×, \[ω\]×\], the Lie bracket as a matrix: ad_ξ η = (ξ̂ η̂ − η̂ ξ̂)^∨.
            pub fn ad(&self) -> Matrix6<f64> {
                let hat = self.angular.cross_matrix();
                let mut ad = Matrix6::zeros();
                ad.fixed_view_mut::<3, 3>(0, 0).copy_from(&hat);
                ad.fixed_view_mut::<3, 3>(3, 0).copy_from(&self.linear.cross_matrix());
                ad.fixed_view_mut::<3, 3>(3, 3).copy_from(&hat);
                ad
            }

            /// Whether every component is finite.
            pub fn is_finite(&self) -> bool {
                self.angular.iter().chain(self.linear.iter()).all(|component| component.is_finite())
            }
        }

        impl Add for $twist {
            type Output = $twist;
            fn add(self, other: $twist) -> $twist {
                $twist::new(self.angular + other.angular, self.linear + other.linear)
            }
        }

        impl Sub for $twist {
            type Output = $twist;
            fn sub(self, other: $twist) -> $twist {
                $twist::new(self.angular - other.angular, self.linear - other.linear)
            }
        }

        impl Neg for $twist {
            type Output = $twist;
            fn neg(self) -> $twist {
                $twist::new(-self.angular, -self.linear)
            }
        }

        impl Mul<f64> for $twist {
            type Output = $twist;
            fn mul(self, scale: f64) -> $twist {
                $twist::new(self.angular * scale, self.linear * scale)
            }
        }

        impl Mul<$twist> for f64 {
            type Output = $twist;
            fn mul(self, twist: $twist) -> $twist {
                twist * self
            }
        }
    };
}

twist! {
    /// A twist in body coordinates, ξ_b = (X⁻¹ Ẋ)^∨: a change of world frame X ↦ gX leaves it as it is.
    ///
    /// A spatial twist does not pass for it:
    ///
    /// ```compile_fail
    /// use reseflow_lie::{BodyTwist, SE3, SpatialTwist};
    /// let pose: SE3 = SE3::identity().plus(&SpatialTwist::zero());
    /// ```
    BodyTwist
}

twist! {
    /// A twist in spatial (world) coordinates, ξ_s = (Ẋ X⁻¹)^∨ = Ad_X ξ_b.
    SpatialTwist
}

impl BodyTwist {
    /// The same motion of the body at pose `at` in spatial coordinates: ξ_s = Ad_X ξ_b.
    ///
    /// ```
    /// use reseflow_lie::{BodyTwist, SE3, SO3, Vector3};
    ///
    /// let at = SE3::new(SO3::exp(&Vector3::new(0.1, 0.7, -0.4)), Vector3::new(1.0, 2.0, 3.0));
    /// let body = BodyTwist::new(Vector3::new(0.2, -0.1, 0.3), Vector3::new(0.5, 0.6, -0.7));
    /// let spatial = body.to_spatial(&at);
    /// assert!((spatial.vector6() - at.adjoint() * body.vector6()).norm() < 1e-14);
    /// assert!((spatial.hat() - at.matrix() * body.hat() * at.inverse().matrix()).norm() < 1e-14);
    /// ```
    pub fn to_spatial(&self, at: &SE3) -> SpatialTwist {
        let (angular, linear) = at.adjoint_parts(&self.angular, &self.linear);
        SpatialTwist::new(angular, linear)
    }
}

impl SpatialTwist {
    /// The same motion of the body at pose `at` in body coordinates: ξ_b = Ad_X⁻¹ ξ_s.
    pub fn to_body(&self, at: &SE3) -> BodyTwist {
        let (angular, linear) = at.inverse().adjoint_parts(&self.angular, &self.linear);
        BodyTwist::new(angular, linear)
    }
}
