//! Values computed elsewhere, by scipy and by mpmath with 60 digits: `scripts/lie_golden.py` made them.

use nalgebra::{Matrix4, Matrix6, Vector3, Vector6};
use reseflow_lie::{BodyTwist, SE3, SO3};
use serde_json::Value;
use std::f64::consts::PI;

fn entries(key: &str, fewest: usize) -> Vec<Value> {
    let golden: Value = serde_json::from_str(include_str!("../golden/lie.json")).unwrap();
    let entries = golden[key].as_array().unwrap().clone();
    assert!(entries.len() >= fewest, "only {} entries of {key}", entries.len());
    entries
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect()
}

fn twist(entry: &Value) -> BodyTwist {
    BodyTwist::from_vector6(&Vector6::from_column_slice(&numbers(&entry["twist"])))
}

fn matrix(entry: &Value) -> Matrix4<f64> {
    Matrix4::from_row_slice(&numbers(&entry["matrix"]))
}

#[test]
fn exp_and_left_jacobian_agree_with_scipy_expm() {
    for entry in entries("exp", 20) {
        let twist = twist(&entry);
        assert!((SE3::exp(&twist).matrix() - matrix(&entry)).amax() < 2e-14);
        let jacobian = Matrix6::from_row_slice(&numbers(&entry["left_jacobian"]));
        let error = (SE3::left_jacobian(&twist) - jacobian).amax();
        assert!(error < 2e-14, "angle {}: {error:e}", twist.angular.norm());
    }
}

#[test]
fn log_agrees_with_scipy_logm() {
    for entry in entries("log", 10) {
        let log = SE3::from_matrix(&matrix(&entry)).unwrap().log();
        let error = (log - twist(&entry)).vector6().amax();
        assert!(error < 1e-12, "angle {}: {error:e}", log.angular.norm());
    }
}

#[test]
fn exp_and_log_agree_with_sixty_digit_arithmetic_near_the_identity_and_near_half_turns() {
    for entry in entries("precise", 12) {
        let twist = twist(&entry);
        let error = (SE3::exp(&twist).matrix() - matrix(&entry)).amax();
        assert!(error < 2e-15, "exp at angle {}: {error:e}", twist.angular.norm());
        let error = (SE3::from_matrix(&matrix(&entry)).unwrap().log() - twist).vector6().amax();
        assert!(error < 1e-14 || (error < 1e-13 && twist.angular.norm() > PI - 1e-2), "log: {error:e}");
    }
}

#[test]
fn quaternions_agree_with_scipy_in_order_and_sign() {
    for entry in entries("quaternion", 5) {
        let rotation = SO3::exp(&Vector3::from_column_slice(&numbers(&entry["omega"])));
        for (got, want) in rotation.quaternion_xyzw().iter().zip(numbers(&entry["xyzw"])) {
            assert!((got - want).abs() < 1e-15);
        }
    }
}
