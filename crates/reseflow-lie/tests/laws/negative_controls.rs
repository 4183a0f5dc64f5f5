//! Groups with one deliberate fault each: a law that lets its fault pass is no law.

use crate::axioms;
use crate::exponential;
use crate::group::LieGroup;
use crate::jacobians;
use nalgebra::{DMatrix, DVector, Vector3};
use reseflow_lie::{SE3, SO3};

const EXP_WITHOUT_JACOBIAN: u8 = 0;
const INVERSE_WITHOUT_ROTATION: u8 = 1;
const ADJOINT_OF_INVERSE: u8 = 2;
const LEFT_AND_RIGHT_SWAPPED: u8 = 3;
const LOG_WITHOUT_CANONICAL_SIGN: u8 = 4;

/// SE(3) with one fault.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Faulty<const FAULT: u8>(SE3);

impl<const FAULT: u8> LieGroup for Faulty<FAULT> {
    fn tangent(angular: &Vector3<f64>, linear: &Vector3<f64>) -> DVector<f64> {
        SE3::tangent(angular, linear)
    }
    fn hat(tangent: &DVector<f64>) -> DMatrix<f64> {
        <SE3 as LieGroup>::hat(tangent)
    }
    fn algebra_adjoint(tangent: &DVector<f64>) -> DMatrix<f64> {
        SE3::algebra_adjoint(tangent)
    }
    fn identity() -> Self {
        Faulty(SE3::identity())
    }
    fn exp(tangent: &DVector<f64>) -> Self {
        if FAULT == EXP_WITHOUT_JACOBIAN {
            let twist = crate::group::twist(tangent);
            return Faulty(SE3::new(SO3::exp(&twist.angular), twist.linear));
        }
        Faulty(<SE3 as LieGroup>::exp(tangent))
    }
    fn log(&self) -> DVector<f64> {
        let log = LieGroup::log(&self.0);
        let angle = log.rows(0, 3).norm();
        if FAULT == LOG_WITHOUT_CANONICAL_SIGN && angle > 2.0 {
            return &log * (1.0 - 2.0 * std::f64::consts::PI / angle);
        }
        log
    }
    fn times(&self, right: &Self) -> Self {
        Faulty(self.0 * right.0)
    }
    fn inverse(&self) -> Self {
        if FAULT == INVERSE_WITHOUT_ROTATION {
            return Faulty(SE3::new(self.0.rotation.inverse(), -self.0.translation));
        }
        Faulty(self.0.inverse())
    }
    fn matrix(&self) -> DMatrix<f64> {
        LieGroup::matrix(&self.0)
    }
    fn adjoint(&self) -> DMatrix<f64> {
        LieGroup::adjoint(&if FAULT == ADJOINT_OF_INVERSE { self.0.inverse() } else { self.0 })
    }
    fn act(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.0.act(point)
    }
    fn left_jacobian(tangent: &DVector<f64>) -> DMatrix<f64> {
        let sign = if FAULT == LEFT_AND_RIGHT_SWAPPED { -1.0 } else { 1.0 };
        <SE3 as LieGroup>::left_jacobian(&(tangent * sign))
    }
    fn right_jacobian(tangent: &DVector<f64>) -> DMatrix<f64> {
        Self::left_jacobian(&-tangent)
    }
    fn left_jacobian_inverse(tangent: &DVector<f64>) -> DMatrix<f64> {
        let sign = if FAULT == LEFT_AND_RIGHT_SWAPPED { -1.0 } else { 1.0 };
        <SE3 as LieGroup>::left_jacobian_inverse(&(tangent * sign))
    }
    fn right_jacobian_inverse(tangent: &DVector<f64>) -> DMatrix<f64> {
        Self::left_jacobian_inverse(&-tangent)
    }
}

#[test]
fn an_exponential_without_its_jacobian_is_noticed() {
    type Group = Faulty<EXP_WITHOUT_JACOBIAN>;
    assert!(exponential::exp_is_the_power_series_of_its_matrix::<Group>().is_err());
    assert!(exponential::exp_adds_along_a_line::<Group>().is_err());
    assert!(exponential::log_inverts_exp::<Group>().is_err());
}

#[test]
fn an_inverse_that_does_not_rotate_is_noticed() {
    assert!(axioms::identity_and_inverse::<Faulty<INVERSE_WITHOUT_ROTATION>>().is_err());
}

#[test]
fn the_adjoint_of_the_inverse_is_noticed() {
    type Group = Faulty<ADJOINT_OF_INVERSE>;
    assert!(axioms::the_adjoint_conjugates::<Group>().is_err());
    assert!(axioms::the_adjoint_is_a_homomorphism::<Group>().is_err());
    assert!(axioms::the_adjoint_of_an_exponential_is_the_exponential_of_ad::<Group>().is_err());
    assert!(jacobians::left_and_right_jacobians_are_related::<Group>().is_err());
}

#[test]
fn swapped_jacobians_are_noticed() {
    type Group = Faulty<LEFT_AND_RIGHT_SWAPPED>;
    assert!(jacobians::left_jacobian_is_the_series_of_ad::<Group>().is_err());
    assert!(jacobians::jacobians_are_the_derivatives_of_exp::<Group>().is_err());
    assert!(jacobians::inverse_jacobians_are_the_derivatives_of_log::<Group>().is_err());
}

#[test]
fn a_logarithm_past_the_half_turn_is_noticed() {
    type Group = Faulty<LOG_WITHOUT_CANONICAL_SIGN>;
    assert!(exponential::log_inverts_exp::<Group>().is_err());
    assert!(exponential::log_is_principal::<Group>().is_err());
}
