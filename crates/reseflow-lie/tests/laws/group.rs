//! What a law may ask of a group: tangents as vectors, elements as matrices, so that one text serves all.

use nalgebra::{DMatrix, DVector, Matrix3, Matrix6, Vector3, Vector6};
use reseflow_lie::{BodyTwist, SE3, SO3};
use std::fmt::Debug;

/// A matrix Lie group with everything this crate provides for each of its groups.
pub(crate) trait LieGroup: Copy + Debug + PartialEq {
    /// The tangent with this angular part; groups without translations drop the linear one.
    fn tangent(angular: &Vector3<f64>, linear: &Vector3<f64>) -> DVector<f64>;
    fn hat(tangent: &DVector<f64>) -> DMatrix<f64>;
    fn algebra_adjoint(tangent: &DVector<f64>) -> DMatrix<f64>;
    fn identity() -> Self;
    fn exp(tangent: &DVector<f64>) -> Self;
    fn log(&self) -> DVector<f64>;
    fn times(&self, right: &Self) -> Self;
    fn inverse(&self) -> Self;
    fn matrix(&self) -> DMatrix<f64>;
    fn adjoint(&self) -> DMatrix<f64>;
    fn act(&self, point: &Vector3<f64>) -> Vector3<f64>;
    fn left_jacobian(tangent: &DVector<f64>) -> DMatrix<f64>;
    fn right_jacobian(tangent: &DVector<f64>) -> DMatrix<f64>;
    fn left_jacobian_inverse(tangent: &DVector<f64>) -> DMatrix<f64>;
    fn right_jacobian_inverse(tangent: &DVector<f64>) -> DMatrix<f64>;
}

fn dynamic3(matrix: Matrix3<f64>) -> DMatrix<f64> {
    DMatrix::from_column_slice(3, 3, matrix.as_slice())
}

fn dynamic6(matrix: Matrix6<f64>) -> DMatrix<f64> {
    DMatrix::from_column_slice(6, 6, matrix.as_slice())
}

fn vector3(tangent: &DVector<f64>) -> Vector3<f64> {
    Vector3::from_column_slice(tangent.as_slice())
}

/// The twist with these six numbers.
pub(crate) fn twist(tangent: &DVector<f64>) -> BodyTwist {
    BodyTwist::from_vector6(&Vector6::from_column_slice(tangent.as_slice()))
}

impl LieGroup for SO3 {
    fn tangent(angular: &Vector3<f64>, _linear: &Vector3<f64>) -> DVector<f64> {
        DVector::from_column_slice(angular.as_slice())
    }
    fn hat(tangent: &DVector<f64>) -> DMatrix<f64> {
        dynamic3(vector3(tangent).cross_matrix())
    }
    fn algebra_adjoint(tangent: &DVector<f64>) -> DMatrix<f64> {
        dynamic3(vector3(tangent).cross_matrix())
    }
    fn identity() -> SO3 {
        SO3::identity()
    }
    fn exp(tangent: &DVector<f64>) -> SO3 {
        SO3::exp(&vector3(tangent))
    }
    fn log(&self) -> DVector<f64> {
        DVector::from_column_slice(SO3::log(self).as_slice())
    }
    fn times(&self, right: &SO3) -> SO3 {
        self * right
    }
    fn inverse(&self) -> SO3 {
        SO3::inverse(self)
    }
    fn matrix(&self) -> DMatrix<f64> {
        dynamic3(SO3::matrix(self))
    }
    fn adjoint(&self) -> DMatrix<f64> {
        dynamic3(SO3::adjoint(self))
    }
    fn act(&self, point: &Vector3<f64>) -> Vector3<f64> {
        SO3::act(self, point)
    }
    fn left_jacobian(tangent: &DVector<f64>) -> DMatrix<f64> {
        dynamic3(SO3::left_jacobian(&vector3(tangent)))
    }
    fn right_jacobian(tangent: &DVector<f64>) -> DMatrix<f64> {
        dynamic3(SO3::right_jacobian(&vector3(tangent)))
    }
    fn left_jacobian_inverse(tangent: &DVector<f64>) -> DMatrix<f64> {
        dynamic3(SO3::left_jacobian_inverse(&vector3(tangent)))
    }
    fn right_jacobian_inverse(tangent: &DVector<f64>) -> DMatrix<f64> {
        dynamic3(SO3::right_jacobian_inverse(&vector3(tangent)))
    }
}

impl LieGroup for SE3 {
    fn tangent(angular: &Vector3<f64>, linear: &Vector3<f64>) -> DVector<f64> {
        DVector::from_column_slice(BodyTwist::new(*angular, *linear).vector6().as_slice())
    }
    fn hat(tangent: &DVector<f64>) -> DMatrix<f64> {
        DMatrix::from_column_slice(4, 4, twist(tangent).hat().as_slice())
    }
    fn algebra_adjoint(tangent: &DVector<f64>) -> DMatrix<f64> {
        dynamic6(twist(tangent).ad())
    }
    fn identity() -> SE3 {
        SE3::identity()
    }
    fn exp(tangent: &DVector<f64>) -> SE3 {
        SE3::exp(&twist(tangent))
    }
    fn log(&self) -> DVector<f64> {
        DVector::from_column_slice(SE3::log(self).vector6().as_slice())
    }
    fn times(&self, right: &SE3) -> SE3 {
        self * right
    }
    fn inverse(&self) -> SE3 {
        SE3::inverse(self)
    }
    fn matrix(&self) -> DMatrix<f64> {
        DMatrix::from_column_slice(4, 4, SE3::matrix(self).as_slice())
    }
    fn adjoint(&self) -> DMatrix<f64> {
        dynamic6(SE3::adjoint(self))
    }
    fn act(&self, point: &Vector3<f64>) -> Vector3<f64> {
        SE3::act(self, point)
    }
    fn left_jacobian(tangent: &DVector<f64>) -> DMatrix<f64> {
        dynamic6(SE3::left_jacobian(&twist(tangent)))
    }
    fn right_jacobian(tangent: &DVector<f64>) -> DMatrix<f64> {
        dynamic6(SE3::right_jacobian(&twist(tangent)))
    }
    fn left_jacobian_inverse(tangent: &DVector<f64>) -> DMatrix<f64> {
        dynamic6(SE3::left_jacobian_inverse(&twist(tangent)))
    }
    fn right_jacobian_inverse(tangent: &DVector<f64>) -> DMatrix<f64> {
        dynamic6(SE3::right_jacobian_inverse(&twist(tangent)))
    }
}

/// Turns each law, a function over every [`LieGroup`], into one test for each group.
macro_rules! laws_for_every_group {
    ($($law:ident),+ $(,)?) => {
        mod so3 {
            $(#[test] fn $law() { super::$law::<reseflow_lie::SO3>().unwrap(); })+
        }
        mod se3 {
            $(#[test] fn $law() { super::$law::<reseflow_lie::SE3>().unwrap(); })+
        }
    };
}
pub(crate) use laws_for_every_group;
