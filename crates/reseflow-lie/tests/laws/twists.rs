//! Body and spatial twists: what they are the derivatives of, how they convert, how they add.

use crate::draw::for_all;
use nalgebra::{Matrix4, Vector6};
use proptest::prelude::*;
use proptest::test_runner::TestCaseResult;
use reseflow_lie::{BodyTwist, SE3, SpatialTwist};

fn close(got: Vector6<f64>, want: Vector6<f64>, tolerance: f64) -> TestCaseResult {
    prop_assert!((got - want).amax() <= tolerance, "got {got}want {want}");
    Ok(())
}

#[test]
fn conversions_are_the_adjoint_and_undo_each_other() {
    for_all(|a, b, _| {
        let at = a.element::<SE3>();
        let body = BodyTwist::new(b.angular, b.linear);
        let spatial = body.to_spatial(&at);
        close(spatial.vector6(), at.adjoint() * body.vector6(), 1e-13)?;
        close(spatial.to_body(&at).vector6(), body.vector6(), 1e-13)
    })
    .unwrap();
}

/// ξ_b = (X⁻¹ Ẋ)^∨ and ξ_s = (Ẋ X⁻¹)^∨ along X(t) = X Exp(t ξ_b), differenced on the matrices.
#[test]
fn twists_are_the_two_readings_of_one_velocity() {
    for_all(|a, b, _| {
        let at = a.element::<SE3>();
        let body = BodyTwist::new(b.angular, b.linear);
        let pose = |t: f64| at.plus(&(body * t)).matrix();
        let h = 1e-3;
        let velocity: Matrix4<f64> =
            ((pose(h) - pose(-h)) * 8.0 - (pose(2.0 * h) - pose(-2.0 * h))) / (12.0 * h);
        let inverse = at.inverse().matrix();
        prop_assert!((inverse * velocity - body.hat()).amax() < 1e-9);
        prop_assert!((velocity * inverse - body.to_spatial(&at).hat()).amax() < 1e-9);
        Ok(())
    })
    .unwrap();
}

#[test]
fn exp_and_log_of_spatial_twists_undo_each_other() {
    for_all(|a, _, _| {
        let spatial = SpatialTwist::new(a.angular, a.linear);
        let displacement = SE3::exp_spatial(&spatial);
        prop_assert_eq!(displacement, SE3::exp(&BodyTwist::new(a.angular, a.linear)));
        close(displacement.log_spatial().vector6(), spatial.vector6(), 1e-7)?;
        // A one-parameter group commutes with itself: at Exp(ξ) the two readings of ξ agree.
        close(spatial.to_body(&displacement).vector6(), spatial.vector6(), 1e-13)
    })
    .unwrap();
}

#[test]
fn twists_form_a_vector_space() {
    for_all(|a, b, _| {
        let (x, y) = (BodyTwist::new(a.angular, a.linear), BodyTwist::new(b.angular, b.linear));
        prop_assert_eq!((x + y - y * 2.0).vector6(), x.vector6() + y.vector6() - y.vector6() * 2.0);
        prop_assert_eq!(-x, x * -1.0);
        prop_assert_eq!(0.5 * x, x * 0.5);
        prop_assert_eq!(BodyTwist::zero() + x, x);
        prop_assert_eq!(BodyTwist::from_vector6(&x.vector6()), x);
        Ok(())
    })
    .unwrap();
}

#[test]
fn the_six_numbers_are_angular_first() {
    let twist = SpatialTwist::from_vector6(&Vector6::new(1.0, 2.0, 3.0, 4.0, 5.0, 6.0));
    assert_eq!(twist.angular.as_slice(), [1.0, 2.0, 3.0]);
    assert_eq!(twist.linear.as_slice(), [4.0, 5.0, 6.0]);
    assert!(twist.is_finite() && !(twist * f64::NAN).is_finite());
}
