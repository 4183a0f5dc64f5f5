//! D_geo: a metric, unchanged by the world frame, with its two parts.

use crate::draw::for_all;
use proptest::prelude::*;
use reseflow_lie::{BodyTwist, SE3, SO3, Vector3, geodesic_distance};

#[test]
fn d_geo_is_a_metric() {
    for_all(|a, b, c| {
        let (x, y, z) = (a.element::<SE3>(), b.element::<SE3>(), c.element::<SE3>());
        let d = |from: &SE3, to: &SE3| geodesic_distance(from, to).d_geo();
        prop_assert!(d(&x, &x) < 1e-15);
        prop_assert!((d(&x, &y) - d(&y, &x)).abs() < 1e-14);
        prop_assert!(d(&x, &z) <= d(&x, &y) + d(&y, &z) + 1e-14);
        Ok(())
    })
    .unwrap();
}

#[test]
fn d_geo_is_invariant_under_the_left_action() {
    for_all(|a, b, c| {
        let (x, y, g) = (a.element::<SE3>(), b.element::<SE3>(), c.element::<SE3>());
        let (here, there) = (geodesic_distance(&x, &y), geodesic_distance(&(g * x), &(g * y)));
        prop_assert!((here.rotation_rad - there.rotation_rad).abs() < 1e-13);
        prop_assert!((here.translation_m - there.translation_m).abs() < 1e-14);
        Ok(())
    })
    .unwrap();
}

/// Negative control: a change of gripper frame is no symmetry of D_geo, because a lever turns angles into metres.
#[test]
fn d_geo_is_not_invariant_under_the_right_action() {
    let x = SE3::identity();
    let y = SE3::new(SO3::exp(&Vector3::z()), Vector3::zeros());
    let g = SE3::new(SO3::identity(), Vector3::x());
    let (here, there) = (geodesic_distance(&x, &y).d_geo(), geodesic_distance(&(x * g), &(y * g)).d_geo());
    assert!((here - there).abs() > 0.3, "{here} {there}");
}

#[test]
fn the_parts_are_the_norms_of_the_product_displacement() {
    for_all(|a, b, _| {
        let (x, y) = (a.element::<SE3>(), b.element::<SE3>());
        let BodyTwist { angular, linear } = x.product_displacement_to(&y);
        let distance = geodesic_distance(&x, &y);
        prop_assert!((distance.rotation_rad - angular.norm()).abs() < 1e-12);
        prop_assert!((distance.translation_m - linear.norm()).abs() < 1e-14);
        prop_assert!(
            (distance.d_geo().powi(2) - angular.norm_squared() - linear.norm_squared()).abs() < 1e-11
        );
        Ok(())
    })
    .unwrap();
}
