//! Reading rotations and poses from numbers: what is accepted, what is refused, and why.

use crate::draw::for_all;
use nalgebra::{Matrix3, Matrix4, Vector3};
use proptest::prelude::*;
use reseflow_lie::{LieError, SE3, SO3};

fn skewed() -> Matrix3<f64> {
    SO3::exp(&Vector3::new(0.3, -1.2, 0.7)).matrix()
}

#[test]
fn matrices_and_quaternions_round_trip() {
    for_all(|a, b, _| {
        let pose = a.element::<SE3>() * b.element::<SE3>();
        let read = SE3::from_matrix(&pose.matrix())?;
        prop_assert!((read.matrix() - pose.matrix()).amax() < 2e-15);
        let xyzw = pose.rotation.quaternion_xyzw();
        prop_assert!(xyzw[3] >= -1e-13);
        let read = SO3::from_quaternion_xyzw(xyzw)?;
        prop_assert!((read.matrix() - pose.rotation.matrix()).amax() < 1e-15);
        let read = SO3::from_quaternion_xyzw(xyzw.map(|component| -component))?;
        prop_assert!((read.matrix() - pose.rotation.matrix()).amax() < 1e-15);
        Ok(())
    })
    .unwrap();
}

/// Files hold f32: such matrices are accepted, and come back orthonormal to the last bits.
#[test]
fn matrices_rounded_to_f32_are_projected() {
    for_all(|a, b, _| {
        let pose = a.element::<SE3>() * b.element::<SE3>();
        let rounded = pose.matrix().map(|entry| f64::from(entry as f32));
        let read = SE3::from_matrix(&rounded)?;
        prop_assert!((read.matrix() - pose.matrix()).amax() < 5e-7);
        let matrix = read.rotation.matrix();
        prop_assert!((matrix.transpose() * matrix - Matrix3::identity()).amax() < 1e-14);
        Ok(())
    })
    .unwrap();
}

/// The projection is to the nearest rotation, the polar factor: R of R (I + S) with S symmetric, here as large as is read.
#[test]
fn the_projection_is_the_polar_factor() {
    for_all(|a, b, _| {
        let rotation = a.element::<SO3>().matrix();
        let signs = b.linear.map(|component| if component < 0.0 { -1.0 } else { 1.0 });
        let stretched = rotation * (Matrix3::identity() + signs * signs.transpose() * 4.9e-4);
        prop_assert!((SO3::from_matrix(&stretched)?.matrix() - rotation).amax() < 1e-14);
        let disturbed = rotation + Matrix3::from_columns(&[b.linear, a.linear, b.linear]) * 8e-5;
        let svd = disturbed.svd(true, true);
        let nearest = svd.u.unwrap() * svd.v_t.unwrap();
        prop_assert!((SO3::from_matrix(&disturbed)?.matrix() - nearest).amax() < 1e-14);
        Ok(())
    })
    .unwrap();
}

#[test]
fn what_is_no_rotation_is_refused() {
    for poison in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for index in 0..9 {
            let mut matrix = skewed();
            matrix[index] = poison;
            assert!(matches!(SO3::from_matrix(&matrix), Err(LieError::NonFinite { .. })));
        }
    }
    for scale in [1.001, 0.999, 1.5, 0.0, -2.0, 1e200] {
        let refusal = SO3::from_matrix(&(skewed() * scale)).unwrap_err();
        assert!(matches!(refusal, LieError::NotOrthonormal { .. }), "{scale}: {refusal}");
    }
    let shear = Matrix3::new(1.0, 0.01, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
    assert!(matches!(SO3::from_matrix(&(skewed() * shear)), Err(LieError::NotOrthonormal { .. })));
    let mirror = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, -1.0));
    for reflected in [skewed() * mirror, -skewed(), mirror] {
        assert!(matches!(SO3::from_matrix(&reflected), Err(LieError::Reflection { .. })));
    }
    assert!(SO3::from_matrix(&(skewed() * 1.0004)).is_ok());
}

#[test]
fn what_is_no_unit_quaternion_is_refused() {
    for broken in [[f64::NAN, 0.0, 0.0, 1.0], [0.0, f64::INFINITY, 0.0, 1.0]] {
        assert!(matches!(SO3::from_quaternion_xyzw(broken), Err(LieError::NonFinite { .. })));
    }
    for broken in [[0.0; 4], [0.0, 0.0, 0.0, 1.01], [0.5; 4].map(|component: f64| component * 0.99)] {
        assert!(matches!(SO3::from_quaternion_xyzw(broken), Err(LieError::NotUnitQuaternion { .. })));
    }
    let quarter_turn_about_z = [0.0, 0.0, 0.5_f64.sqrt(), 0.5_f64.sqrt()];
    let rotation = SO3::from_quaternion_xyzw(quarter_turn_about_z).unwrap();
    assert!((rotation.act(&Vector3::x()) - Vector3::y()).norm() < 1e-15);
}

#[test]
fn what_is_no_pose_is_refused() {
    let pose = SE3::new(SO3::exp(&Vector3::new(0.3, -1.2, 0.7)), Vector3::new(1.0, 2.0, 3.0));
    assert!(matches!(SE3::from_matrix(&pose.matrix().transpose()), Err(LieError::BottomRow { .. })));
    assert!(matches!(SE3::from_matrix(&(pose.matrix() * 2.0)), Err(LieError::BottomRow { .. })));
    assert!(matches!(SE3::from_matrix(&Matrix4::zeros()), Err(LieError::BottomRow { .. })));
    let mut matrix = pose.matrix();
    matrix[(0, 3)] = f64::NAN;
    assert!(matches!(SE3::from_matrix(&matrix), Err(LieError::NonFinite { .. })));
    let mut matrix = pose.matrix();
    matrix[(0, 0)] += 0.1;
    assert!(matches!(SE3::from_matrix(&matrix), Err(LieError::NotOrthonormal { .. })));
}

#[test]
fn refusals_say_what_was_expected_and_what_was_got() {
    let refusal = SO3::from_quaternion_xyzw([0.0, 0.0, 0.0, 2.0]).unwrap_err().to_string();
    assert_eq!(refusal, "expected a unit quaternion (norm within 0.001 of 1), got norm 2");
    let refusal = SE3::from_matrix(&Matrix4::zeros()).unwrap_err().to_string();
    assert_eq!(refusal, "expected the bottom row (0, 0, 0, 1), got (0, 0, 0, 0)");
}

#[test]
fn gram_schmidt_keeps_the_first_direction_and_the_plane_and_turns_with_them() {
    for_all(|a, b, c| {
        let (g, first, second) = (a.element::<SO3>(), b.linear / b.scale(), c.linear / c.scale());
        prop_assume!(first.norm() > 0.1 && second.norm() > 0.1);
        prop_assume!(first.normalize().cross(&second.normalize()).norm() > 1e-3);
        let rotation = SO3::gram_schmidt(&first, &second)?;
        let [x, y, z] = [0, 1, 2].map(|index| rotation.matrix().column(index).into_owned());
        prop_assert!((x - first.normalize()).norm() < 1e-14);
        prop_assert!(y.dot(&second) > 0.0 && z.dot(&second).abs() < 1e-12);
        let turned = SO3::gram_schmidt(&g.act(&first), &g.act(&second))?;
        prop_assert!((turned.matrix() - (g * rotation).matrix()).amax() < 1e-11);
        Ok(())
    })
    .unwrap();
}

#[test]
fn gram_schmidt_is_orthonormal_up_to_its_limit_and_refuses_beyond() {
    let first = Vector3::new(0.3, -0.7, 0.2);
    let across = Vector3::new(0.7, 0.3, 0.0);
    for sine in [1.0, 1e-3, 1e-6, 1e-9, 1e-11] {
        let matrix = SO3::gram_schmidt(&first, &(first + across * sine)).unwrap().matrix();
        assert!((matrix.transpose() * matrix - Matrix3::identity()).amax() < 1e-14);
        assert!((matrix.column(0) - first.normalize()).norm() < 1e-14);
    }
    for (a, b) in [(first, first * -2.0), (first, Vector3::zeros()), (Vector3::zeros(), first)] {
        assert!(matches!(SO3::gram_schmidt(&a, &b), Err(LieError::DegenerateFrame { .. })));
    }
    let broken = Vector3::new(0.0, f64::NAN, 0.0);
    assert!(matches!(SO3::gram_schmidt(&first, &broken), Err(LieError::NonFinite { .. })));
}
