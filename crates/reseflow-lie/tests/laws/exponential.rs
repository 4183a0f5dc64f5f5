//! Exp against the power series of its matrix, and Exp and Log as inverses of one another.

use crate::draw::{Regime, close, close_vectors, for_all};
use crate::group::{LieGroup, laws_for_every_group};
use nalgebra::DMatrix;
use proptest::prelude::*;
use std::f64::consts::PI;

laws_for_every_group!(
    exp_is_the_power_series_of_its_matrix,
    log_inverts_exp,
    exp_inverts_log,
    log_is_principal,
    exp_of_a_negated_tangent_is_the_inverse,
    exp_adds_along_a_line,
);

/// Σₙ weight(n) Mⁿ/n!, far past the last term that counts for ‖M‖ ≤ 8.
pub(crate) fn power_series(matrix: &DMatrix<f64>, weight: impl Fn(usize) -> f64) -> DMatrix<f64> {
    let size = matrix.nrows();
    let mut term = DMatrix::identity(size, size);
    let mut sum = &term * weight(0);
    for n in 1..60 {
        term = &term * matrix / n as f64;
        sum += &term * weight(n);
    }
    sum
}

pub(crate) fn exp_is_the_power_series_of_its_matrix<G: LieGroup>() -> Result<(), String> {
    for_all(|a, _, _| {
        let series = power_series(&G::hat(&a.tangent::<G>()), |_| 1.0);
        close(&a.element::<G>().matrix(), &series, 1e-14 * if a.scale() < 1.0 { 0.1 } else { 10.0 })
    })
}

/// 1e-12 away from the cut, relative near the identity; 1e-7 within 1e-6 of π, where half the digits of w are lost.
pub(crate) fn log_inverts_exp<G: LieGroup>() -> Result<(), String> {
    for_all(|a, _, _| {
        let tolerance = match a.regime {
            Regime::Uniform => 1e-12,
            Regime::NearIdentity => 1e-12 * a.scale(),
            Regime::NearHalfTurn => 1e-7,
        };
        close_vectors(&a.element::<G>().log(), &a.tangent::<G>(), tolerance)
    })
}

/// The other way round there is no cut: tight everywhere, for products as well.
pub(crate) fn exp_inverts_log<G: LieGroup>() -> Result<(), String> {
    for_all(|a, b, _| {
        let x = a.element::<G>().times(&b.element::<G>());
        close(&G::exp(&x.log()).matrix(), &x.matrix(), 2e-14)
    })
}

pub(crate) fn log_is_principal<G: LieGroup>() -> Result<(), String> {
    for_all(|a, b, _| {
        let log = a.element::<G>().times(&b.element::<G>()).log();
        let angle = log.rows(0, 3).norm();
        prop_assert!(angle <= PI + 1e-12, "angle {angle}");
        prop_assert!(log.iter().all(|component| component.is_finite()));
        Ok(())
    })
}

pub(crate) fn exp_of_a_negated_tangent_is_the_inverse<G: LieGroup>() -> Result<(), String> {
    for_all(|a, _, _| {
        let x = a.element::<G>();
        close(&G::exp(&-a.tangent::<G>()).matrix(), &x.inverse().matrix(), 1e-14)
    })
}

pub(crate) fn exp_adds_along_a_line<G: LieGroup>() -> Result<(), String> {
    for_all(|a, b, _| {
        let (tangent, s) = (a.tangent::<G>(), b.linear.x);
        let split = G::exp(&(&tangent * s)).times(&G::exp(&(&tangent * (1.0 - s))));
        close(&split.matrix(), &a.element::<G>().matrix(), 2e-14)
    })
}
