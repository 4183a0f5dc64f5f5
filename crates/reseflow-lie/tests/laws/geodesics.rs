//! The screw and the product geodesic: ends, constant speed, their displacements and retractions, frames.

use crate::draw::{Regime, Sample, close, close_vectors, for_all};
use crate::group::LieGroup;
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;
use reseflow_lie::{BodyTwist, SE3, SO3};

type Interpolate = fn(&SE3, &SE3, f64) -> SE3;
type Displacement = fn(&SE3, &SE3) -> BodyTwist;
type Retraction = fn(&SE3, &BodyTwist) -> SE3;

/// Each geodesic with the displacement along it and the retraction that undoes the displacement.
const GEODESICS: [(Interpolate, Displacement, Retraction); 2] = [
    (SE3::interpolate_screw, SE3::body_twist_to, SE3::plus),
    (SE3::interpolate_product, SE3::product_displacement_to, SE3::plus_product),
];

fn matrix(pose: &SE3) -> DMatrix<f64> {
    LieGroup::matrix(pose)
}

fn vector(twist: &BodyTwist) -> DVector<f64> {
    DVector::from_column_slice(twist.vector6().as_slice())
}

/// A second pose at less than a half turn from the first, so that the geodesic is the only one.
fn pair(a: &Sample, b: &Sample) -> (SE3, SE3) {
    let from = a.element::<SE3>();
    let reach = if b.regime == Regime::NearHalfTurn { 0.99 } else { 1.0 };
    (from, from.plus(&(BodyTwist::new(b.angular, b.linear) * reach)))
}

#[test]
fn geodesics_run_from_end_to_end() {
    for (interpolate, _, _) in GEODESICS {
        for_all(|a, b, _| {
            let (from, to) = (a.element::<SE3>(), b.element::<SE3>());
            close(&matrix(&interpolate(&from, &to, 0.0)), &matrix(&from), 1e-15)?;
            close(&matrix(&interpolate(&from, &to, 1.0)), &matrix(&to), 2e-14)
        })
        .unwrap();
    }
}

#[test]
fn retractions_undo_displacements() {
    for (_, displacement, retraction) in GEODESICS {
        for_all(|a, b, _| {
            let (from, to) = (a.element::<SE3>(), b.element::<SE3>());
            close(&matrix(&retraction(&from, &displacement(&from, &to))), &matrix(&to), 2e-14)?;
            let (from, _) = pair(a, b);
            let twist = BodyTwist::new(b.angular, b.linear) * 0.99;
            close_vectors(&vector(&displacement(&from, &retraction(&from, &twist))), &vector(&twist), 2e-13)
        })
        .unwrap();
    }
}

/// The pose at s lies s of the way: what is left is (1 − s) of the displacement, read in the frame reached.
#[test]
fn geodesics_have_constant_speed() {
    for_all(|a, b, c| {
        let (from, to) = pair(a, b);
        let s = 0.5 + 0.2 * c.linear.x;
        let screw = from.body_twist_to(&to);
        let left = from.interpolate_screw(&to, s).body_twist_to(&to);
        close_vectors(&vector(&left), &vector(&(screw * (1.0 - s))), 2e-13)?;
        let product = from.product_displacement_to(&to);
        let left = from.interpolate_product(&to, s).product_displacement_to(&to);
        let turned_back = SO3::exp(&(product.angular * -s));
        let want = BodyTwist::new(product.angular * (1.0 - s), turned_back.act(&product.linear) * (1.0 - s));
        close_vectors(&vector(&left), &vector(&want), 2e-13)
    })
    .unwrap();
}

#[test]
fn a_change_of_world_frame_moves_geodesics_and_leaves_displacements() {
    for (interpolate, displacement, _) in GEODESICS {
        for_all(|a, b, c| {
            let ((from, to), g) = (pair(a, b), c.element::<SE3>());
            let (moved_from, moved_to) = (g * from, g * to);
            let want = displacement(&from, &to);
            close_vectors(&vector(&displacement(&moved_from, &moved_to)), &vector(&want), 2e-13)?;
            let moved = interpolate(&moved_from, &moved_to, 0.3);
            close(&matrix(&moved), &matrix(&(g * interpolate(&from, &to, 0.3))), 2e-13)
        })
        .unwrap();
    }
}

/// The paper's form, Exp(t Log(Y X⁻¹)) X, is the same curve as X Exp(t Log(X⁻¹ Y)).
#[test]
fn spatial_and_body_forms_are_one_geodesic() {
    for_all(|a, b, _| {
        let (from, to) = pair(a, b);
        let spatial = from.spatial_twist_to(&to);
        let body = from.body_twist_to(&to).to_spatial(&from);
        prop_assert!((spatial - body).vector6().amax() < 2e-13);
        close(&matrix(&from.plus_spatial(&spatial)), &matrix(&to), 2e-14)?;
        close(
            &matrix(&from.plus_spatial(&(spatial * 0.3))),
            &matrix(&from.interpolate_screw(&to, 0.3)),
            1e-13,
        )
    })
    .unwrap();
}

#[test]
fn the_product_geodesic_moves_the_origin_on_a_straight_line() {
    for_all(|a, b, _| {
        let (from, to) = pair(a, b);
        let middle = from.interpolate_product(&to, 0.25).translation;
        let want = from.translation * 0.75 + to.translation * 0.25;
        prop_assert!((middle - want).norm() < 1e-14);
        Ok(())
    })
    .unwrap();
}

#[test]
fn so3_interpolation_is_the_rotation_of_the_product_geodesic() {
    for_all(|a, b, _| {
        let (from, to) = pair(a, b);
        let rotation = from.rotation.interpolate(&to.rotation, 0.7);
        prop_assert_eq!(rotation, from.interpolate_product(&to, 0.7).rotation);
        let left = (rotation.inverse() * to.rotation).log();
        let whole = (from.rotation.inverse() * to.rotation).log();
        prop_assert!((left - whole * 0.3).norm() < 2e-13);
        Ok(())
    })
    .unwrap();
}
