//! Samples for the laws: uniform, near the identity and near a half turn; and the runner that counts them.

use crate::group::LieGroup;
use nalgebra::{DMatrix, DVector, Vector3};
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestCaseResult, TestRng, TestRunner};
use std::cell::Cell;
use std::f64::consts::PI;

/// Examples of each regime without which a suite has shown nothing, and fails.
const FEWEST: usize = 256;

/// Where on the group a sample lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Regime {
    /// Angle up to 3.1 rad, translation of the order of a metre.
    Uniform,
    /// Angle and translation up to 1e-8, one in eight of them exactly zero.
    NearIdentity,
    /// Angle within 1e-6 below π, translation of the order of a metre.
    NearHalfTurn,
}

/// A tangent vector, in parts so that every group can use it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    pub regime: Regime,
    pub angular: Vector3<f64>,
    pub linear: Vector3<f64>,
}

impl Sample {
    pub(crate) fn tangent<G: LieGroup>(&self) -> DVector<f64> {
        G::tangent(&self.angular, &self.linear)
    }

    pub(crate) fn element<G: LieGroup>(&self) -> G {
        G::exp(&self.tangent::<G>())
    }

    /// What an error is measured against: the size of the numbers involved.
    pub(crate) fn scale(&self) -> f64 {
        match self.regime {
            Regime::NearIdentity => 1e-8,
            _ => 1.0,
        }
    }
}

/// A vector with each component in [−1, 1].
pub(crate) fn vector() -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-1.0..1.0).prop_map(Vector3::from)
}

fn direction() -> impl Strategy<Value = Vector3<f64>> {
    vector().prop_filter("a direction", |v| v.norm() > 0.1).prop_map(|v| v.normalize())
}

/// A tangent of any regime.
pub(crate) fn sample() -> impl Strategy<Value = Sample> {
    let regime = prop_oneof![Just(Regime::Uniform), Just(Regime::NearIdentity), Just(Regime::NearHalfTurn)];
    (regime, direction(), 0.0..1.0, vector()).prop_map(|(regime, axis, u, linear)| {
        let (angle, metres) = match regime {
            Regime::Uniform => (3.1 * u, 2.0),
            Regime::NearIdentity if u < 0.125 => (0.0, 0.0),
            Regime::NearIdentity => (1e-8 * u, 1e-8),
            Regime::NearHalfTurn => (PI - 1e-6 * u, 2.0),
        };
        Sample { regime, angular: axis * angle, linear: linear * metres }
    })
}

/// Runs `law` on deterministic draws, four times as many as proptest's default or what PROPTEST_CASES says.
/// The error says which example broke it, or that too few were drawn.
pub(crate) fn for_all(law: impl Fn(&Sample, &Sample, &Sample) -> TestCaseResult) -> Result<(), String> {
    run(4 * Config::default().cases, law)
}

/// [`for_all`] with a given number of examples.
pub(crate) fn run(
    cases: u32,
    law: impl Fn(&Sample, &Sample, &Sample) -> TestCaseResult,
) -> Result<(), String> {
    let config = Config { cases, max_global_rejects: cases, failure_persistence: None, ..Config::default() };
    let rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let drawn = [Cell::new(0), Cell::new(0), Cell::new(0)];
    TestRunner::new_with_rng(config, rng)
        .run(&(sample(), sample(), sample()), |(a, b, c)| {
            law(&a, &b, &c)?;
            let count = &drawn[a.regime as usize];
            count.set(count.get() + 1);
            Ok(())
        })
        .map_err(|failure| failure.to_string())?;
    if drawn.iter().any(|count| count.get() < FEWEST) {
        return Err(format!("too few examples: {drawn:?} of each regime, at least {FEWEST} wanted"));
    }
    Ok(())
}

/// Fails the example unless the largest entry of |got − want| is at most `tolerance`.
pub(crate) fn close(got: &DMatrix<f64>, want: &DMatrix<f64>, tolerance: f64) -> TestCaseResult {
    let error = (got - want).amax();
    prop_assert!(error <= tolerance, "off by {error:e}, tolerance {tolerance:e}\ngot {got}want {want}");
    Ok(())
}

/// [`close`] for vectors.
pub(crate) fn close_vectors(got: &DVector<f64>, want: &DVector<f64>, tolerance: f64) -> TestCaseResult {
    let column = |vector: &DVector<f64>| DMatrix::from_column_slice(vector.len(), 1, vector.as_slice());
    close(&column(got), &column(want), tolerance)
}

#[test]
fn a_suite_that_drew_too_few_examples_fails() {
    let failure = run(700, |_, _, _| Ok(())).unwrap_err();
    assert!(failure.contains("too few examples"), "{failure}");
    run(1024, |_, _, _| Ok(())).unwrap();
}

#[test]
fn a_suite_whose_law_breaks_only_near_a_half_turn_fails() {
    let failure = for_all(|a, _, _| {
        prop_assert!(a.regime != Regime::NearHalfTurn);
        Ok(())
    });
    assert!(failure.is_err());
}
