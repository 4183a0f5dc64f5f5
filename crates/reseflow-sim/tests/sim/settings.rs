//! Settings of the world and the camera: what cannot be simulated is refused, and the number of points is what clouds have.

use reseflow_data::Split;
use reseflow_sim::{CameraSettings, PhysicsSettings, configured_task, tasks};

use crate::support::key;

fn fault(name: &str, physics: PhysicsSettings, camera: CameraSettings) -> String {
    match configured_task(name, physics, camera) {
        Ok(_) => panic!("{physics:?} and {camera:?} were accepted"),
        Err(fault) => fault.to_string(),
    }
}

#[test]
fn a_world_that_cannot_be_simulated_is_refused_with_key_value_and_range() {
    let good = PhysicsSettings::default();
    for (physics, sentence) in [
        (PhysicsSettings { substeps: 0, ..good }, "`substeps` is 0, expected 12 to 1000"),
        (PhysicsSettings { substeps: 10, ..good }, "`substeps` is 10, expected 12 to 1000"),
        (
            PhysicsSettings { grip_force_n: f64::NAN, ..good },
            "`grip_force_n` is NaN, expected a number greater than 0",
        ),
        (
            PhysicsSettings { carriage_force_n: -1.0, ..good },
            "`carriage_force_n` is -1, expected a number greater than 0",
        ),
        (
            PhysicsSettings { carriage_rate_rad_s: 97.0, ..good },
            "`carriage_rate_rad_s` is 97, expected at most 96.0 with 16 substeps",
        ),
        (
            PhysicsSettings { pad_friction: -0.5, ..good },
            "`pad_friction` is -0.5, expected a number, 0 or more",
        ),
    ] {
        assert_eq!(fault("door", physics, CameraSettings::default()), sentence);
    }
    let least = PhysicsSettings { substeps: 12, pad_friction: 0.0, ..good };
    assert!(configured_task("door", least, CameraSettings::default()).is_ok());
}

#[test]
fn a_camera_that_cannot_be_is_refused_with_key_value_and_range() {
    let good = CameraSettings::default();
    for (camera, sentence) in [
        (CameraSettings { points: Some(0), ..good }, "`points` is 0, expected 1 to 10000"),
        (CameraSettings { points: Some(10_001), ..good }, "`points` is 10001, expected 1 to 10000"),
        (CameraSettings { depth_noise_m: f64::NAN, ..good }, "`depth_noise_m` is NaN, expected 0 to 1"),
        (CameraSettings { depth_noise_m: -0.001, ..good }, "`depth_noise_m` is -0.001, expected 0 to 1"),
        (CameraSettings { drop_fraction: 1.5, ..good }, "`drop_fraction` is 1.5, expected 0 to 1"),
        (CameraSettings { crop_below_m: f64::NAN, ..good }, "`crop_below_m` is NaN, expected -1 to 1"),
        (
            CameraSettings { second_view_rad: Some(f64::INFINITY), ..good },
            "`second_view_rad` is inf, expected a finite number",
        ),
    ] {
        assert_eq!(fault("painting", PhysicsSettings::default(), camera), sentence);
    }
    let edges = CameraSettings { points: Some(1), depth_noise_m: 0.0, drop_fraction: 1.0, ..good };
    assert!(configured_task("painting", PhysicsSettings::default(), edges).is_ok());
}

#[test]
fn an_unknown_task_is_refused_with_the_names_of_all() {
    let sentence = fault("dor", PhysicsSettings::default(), CameraSettings::default());
    assert!(sentence.starts_with("unknown task `dor`, expected one of door, "), "{sentence}");
}

#[test]
fn clouds_have_as_many_points_as_the_camera_was_told() {
    for name in tasks() {
        for points in [1, 2, 64, 1500] {
            let camera = CameraSettings { points: Some(points), ..CameraSettings::default() };
            let task = configured_task(name, PhysicsSettings::default(), camera).unwrap();
            assert_eq!(task.spec().points, points);
            let cloud = task.reset(&key(name, Split::Train, 15, 0)).unwrap().observe().cloud;
            assert_eq!((cloud.points.len(), cloud.colors.len()), (points, points), "{name}");
            assert!(cloud.points.iter().flatten().all(|coordinate| coordinate.is_finite()));
        }
    }
}
