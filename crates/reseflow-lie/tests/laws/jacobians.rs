//! Jacobians against the series of ad, against finite differences, against each other and their inverses.

use crate::draw::{close, for_all};
use crate::exponential::power_series;
use crate::group::{LieGroup, laws_for_every_group};
use nalgebra::{DMatrix, DVector};

laws_for_every_group!(
    left_jacobian_is_the_series_of_ad,
    left_and_right_jacobians_are_related,
    jacobians_times_their_inverses_are_the_identity,
    jacobians_are_the_derivatives_of_exp,
    inverse_jacobians_are_the_derivatives_of_log,
);

pub(crate) fn left_jacobian_is_the_series_of_ad<G: LieGroup>() -> Result<(), String> {
    for_all(|a, _, _| {
        let tangent = a.tangent::<G>();
        let series = power_series(&G::algebra_adjoint(&tangent), |n| 1.0 / (n + 1) as f64);
        close(&G::left_jacobian(&tangent), &series, 1e-13)
    })
}

/// J_r(ξ) = J_l(−ξ) and J_l(ξ) = Ad_{Exp ξ} J_r(ξ).
pub(crate) fn left_and_right_jacobians_are_related<G: LieGroup>() -> Result<(), String> {
    for_all(|a, _, _| {
        let tangent = a.tangent::<G>();
        let right = G::right_jacobian(&tangent);
        close(&right, &G::left_jacobian(&-&tangent), 0.0)?;
        close(&G::left_jacobian(&tangent), &(a.element::<G>().adjoint() * right), 1e-13)
    })
}

pub(crate) fn jacobians_times_their_inverses_are_the_identity<G: LieGroup>() -> Result<(), String> {
    for_all(|a, _, _| {
        let tangent = a.tangent::<G>();
        let identity = DMatrix::identity(tangent.len(), tangent.len());
        close(&(G::left_jacobian(&tangent) * G::left_jacobian_inverse(&tangent)), &identity, 1e-13)?;
        close(&(G::right_jacobian(&tangent) * G::right_jacobian_inverse(&tangent)), &identity, 1e-13)
    })
}

fn basis(size: usize, index: usize) -> DVector<f64> {
    DVector::from_fn(size, |row, _| if row == index { 1.0 } else { 0.0 })
}

/// The derivative at 0 from values at ±h and ±2h, error O(h⁴).
fn central_difference(h: f64, f: impl Fn(f64) -> DVector<f64>) -> DVector<f64> {
    ((f(h) - f(-h)) * 8.0 - (f(2.0 * h) - f(-2.0 * h))) / (12.0 * h)
}

/// Exp(ξ + δ) ≈ Exp(J_l δ) Exp(ξ) ≈ Exp(ξ) Exp(J_r δ).
pub(crate) fn jacobians_are_the_derivatives_of_exp<G: LieGroup>() -> Result<(), String> {
    for_all(|a, _, _| {
        let tangent = a.tangent::<G>();
        let (x, size) = (a.element::<G>(), tangent.len());
        let moved = |axis: usize, h: f64| G::exp(&(&tangent + basis(size, axis) * h));
        let left: Vec<_> = (0..size)
            .map(|axis| central_difference(1e-3, |h| moved(axis, h).times(&x.inverse()).log()))
            .collect();
        let right: Vec<_> = (0..size)
            .map(|axis| central_difference(1e-3, |h| x.inverse().times(&moved(axis, h)).log()))
            .collect();
        close(&G::left_jacobian(&tangent), &DMatrix::from_columns(&left), 1e-10)?;
        close(&G::right_jacobian(&tangent), &DMatrix::from_columns(&right), 1e-10)
    })
}

/// Log(X Exp(δ)) ≈ Log X + J_r⁻¹ δ and Log(Exp(δ) X) ≈ Log X + J_l⁻¹ δ, differenced one-sidedly away from the cut, so
/// that it holds up to π.
pub(crate) fn inverse_jacobians_are_the_derivatives_of_log<G: LieGroup>() -> Result<(), String> {
    for_all(|a, _, _| {
        let tangent = a.tangent::<G>();
        let (x, size) = (a.element::<G>(), tangent.len());
        let column = |axis: usize, on_the_left: bool| {
            let away = if axis < 3 && tangent[axis] > 0.0 { -1.0 } else { 1.0 };
            let log = |h: f64| {
                let step = G::exp(&(basis(size, axis) * (away * h)));
                if on_the_left { step.times(&x).log() } else { x.times(&step).log() }
            };
            let h = 3e-4;
            let forward = log(0.0) * -25.0 + log(h) * 48.0 - log(2.0 * h) * 36.0 + log(3.0 * h) * 16.0
                - log(4.0 * h) * 3.0;
            forward * (away / (12.0 * h))
        };
        let left: Vec<_> = (0..size).map(|axis| column(axis, true)).collect();
        let right: Vec<_> = (0..size).map(|axis| column(axis, false)).collect();
        close(&G::left_jacobian_inverse(&tangent), &DMatrix::from_columns(&left), 1e-8)?;
        close(&G::right_jacobian_inverse(&tangent), &DMatrix::from_columns(&right), 1e-8)
    })
}
