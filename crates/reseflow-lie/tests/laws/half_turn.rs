//! The cut: at a half turn Log is finite, on the documented branch, and keeps it when the world frame turns.

use crate::draw::{close_vectors, for_all};
use nalgebra::{DVector, Vector3};
use reseflow_lie::{SE3, SO3};
use std::f64::consts::PI;

/// Axes of half turns whose first non-zero component is positive: the documented branch.
fn branch_axes() -> Vec<Vector3<f64>> {
    let mut axes = vec![Vector3::x(), Vector3::y(), Vector3::z()];
    for (x, y, z) in [
        (1.0, -1.0, 0.0),
        (1.0, 1.0, 0.0),
        (0.0, 1.0, -1.0),
        (1.0, 0.0, -1.0),
        (0.0, 0.6, -0.8),
        (0.2, -3.0, 1.0),
    ] {
        axes.push(Vector3::new(x, y, z).normalize());
    }
    axes
}

fn dynamic(vector: Vector3<f64>) -> DVector<f64> {
    DVector::from_column_slice(vector.as_slice())
}

#[test]
fn exact_half_turns_take_the_documented_branch_from_either_side() {
    for axis in branch_axes() {
        let [x, y, z] = axis.into();
        for quaternion in [[x, y, z, 0.0], [-x, -y, -z, 0.0]] {
            let omega = SO3::from_quaternion_xyzw(quaternion).unwrap().log();
            assert!((omega - axis * PI).norm() < 1e-14, "{axis} gave {omega}");
        }
        for omega in [axis * PI, axis * -PI] {
            assert!((SO3::exp(&omega).log() - axis * PI).norm() < 1e-12);
        }
        let from_matrix = SO3::from_matrix(&SO3::exp(&(axis * -PI)).matrix()).unwrap().log();
        assert!((from_matrix - axis * PI).norm() < 1e-12);
    }
}

#[test]
fn the_branch_is_only_for_half_turns() {
    for axis in branch_axes() {
        for distance in [1e-3, 1e-6, 1e-9, 1e-12] {
            let omega = axis * (distance - PI);
            let error = (SO3::exp(&omega).log() - omega).norm();
            assert!(error < 1e-14 * 100.0, "π − {distance:e} about {axis}: error {error:e}");
        }
    }
}

/// A half turn H measured as (gR)⁻¹(gRH): the rounding of g must not choose the branch.
#[test]
fn the_branch_is_broken_in_body_coordinates() {
    for axis in branch_axes() {
        let half_turn = SO3::exp(&(axis * PI));
        for_all(|a, b, _| {
            let world_from_body = b.element::<SO3>() * a.element::<SO3>();
            let world_from_turned = b.element::<SO3>() * (a.element::<SO3>() * half_turn);
            let omega = (world_from_body.inverse() * world_from_turned).log();
            close_vectors(&dynamic(omega), &dynamic(axis * PI), 1e-12)?;
            let pose = |rotation| SE3::new(rotation, a.linear);
            let displacement = pose(world_from_body).product_displacement_to(&pose(world_from_turned));
            close_vectors(&dynamic(displacement.angular), &dynamic(axis * PI), 1e-12)
        })
        .unwrap();
    }
}

#[test]
fn angle_is_the_norm_of_log_and_at_most_pi() {
    for_all(|a, b, _| {
        let rotation = a.element::<SO3>() * b.element::<SO3>();
        proptest::prop_assert!((rotation.angle() - rotation.log().norm()).abs() < 1e-12);
        proptest::prop_assert!(rotation.angle() <= PI);
        Ok(())
    })
    .unwrap();
}

#[test]
fn extreme_rotation_vectors_stay_finite() {
    for size in [0.0, 5e-324, 1e-300, 1e-200, 1e-160, 1e-30, 1e3, 1e100] {
        for axis in branch_axes() {
            let rotation = SO3::exp(&(axis * size));
            assert!(rotation.is_finite() && rotation.log().iter().all(|component| component.is_finite()));
            if size < 1.0 {
                let error = (rotation.log() - axis * size).norm();
                assert!(error <= 1e-14 * size, "size {size:e}: error {error:e}");
            }
        }
    }
}
