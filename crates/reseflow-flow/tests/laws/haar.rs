//! The `haar` prior: it moves with the scene draw by draw, turns every way equally often, and scatters about the cloud.

use reseflow_data::{Observation, PointCloud};
use reseflow_flow::{FlowError, GripperPrior, HaarPrior, Prior, PriorFrame};
use reseflow_lie::{Matrix3, SE3, Vector3};

use crate::{apart, moved, pose, rng};

fn frame(world_from_gripper: SE3, centroid_m: Vector3<f64>) -> PriorFrame {
    PriorFrame { world_from_gripper, opening: 0.7, centroid_m }
}

#[test]
fn the_same_draws_in_a_moved_scene_are_the_moved_draws() {
    let mut poses = rng(61);
    for prior in [Prior::Haar(HaarPrior::default()), Prior::default()] {
        for stream in 0..20 {
            let (gripper, world) = (pose(&mut poses), pose(&mut poses));
            let centroid = pose(&mut poses).translation;
            let draw = |frame: &PriorFrame| prior.sample(frame, 8, &mut rng(600 + stream));
            let expected = moved(&world, &draw(&frame(gripper, centroid)));
            let scene = frame(world * gripper, world.act(&centroid));
            assert!(apart(&draw(&scene), &expected) < 1e-12);
            let behind = frame(gripper, world.act(&centroid));
            assert!(apart(&draw(&behind), &expected) > 1e-3, "control: a gripper that stays behind");
        }
    }
}

#[test]
fn where_the_gripper_is_makes_no_difference_and_where_the_cloud_is_does() {
    let mut poses = rng(62);
    let (gripper, centroid) = (pose(&mut poses), Vector3::new(0.3, -0.2, 0.1));
    let elsewhere = SE3::new(gripper.rotation, gripper.translation + Vector3::new(1.0, 2.0, 3.0));
    let draw = |prior: Prior, gripper, centroid| prior.sample(&frame(gripper, centroid), 6, &mut rng(63));
    let haar = Prior::Haar(HaarPrior::default());
    assert_eq!(draw(haar, gripper, centroid), draw(haar, elsewhere, centroid));
    assert!(apart(&draw(haar, gripper, centroid), &draw(haar, gripper, Vector3::zeros())) > 0.1);
    let about = Prior::Gripper(GripperPrior::default());
    assert_eq!(draw(about, gripper, centroid), draw(about, gripper, Vector3::zeros()));
    assert!(apart(&draw(about, gripper, centroid), &draw(about, elsewhere, centroid)) > 0.1);
}

#[test]
fn rotations_are_uniform_and_positions_have_the_spread_asked_for() {
    const COUNT: usize = 20_000;
    let prior = HaarPrior { sigma_translation_m: 0.07, sigma_opening: 0.15 };
    let (gripper, centroid) = (pose(&mut rng(64)), Vector3::new(0.3, -0.2, 0.1));
    let draws = prior.sample(&frame(gripper, centroid), COUNT, &mut rng(65));
    assert_eq!(draws.len(), COUNT);
    let (mut matrix, mut angle, mut mean) = (Matrix3::zeros(), 0.0, Vector3::zeros());
    let (mut covariance, mut opening_square) = (Matrix3::zeros(), 0.0);
    for draw in draws.iter() {
        let rotation = gripper.rotation.inverse() * draw.world_from_gripper.rotation;
        matrix += rotation.matrix() / COUNT as f64;
        angle += rotation.angle() / COUNT as f64;
        let offset = (draw.world_from_gripper.translation - centroid) / 0.07;
        mean += offset / COUNT as f64;
        covariance += offset * offset.transpose() / COUNT as f64;
        opening_square += ((draw.opening - 0.7) / 0.15).powi(2) / COUNT as f64;
    }
    let error = 5.0 / (COUNT as f64).sqrt();
    // An entry of a uniform rotation has variance 1/3; its angle has the mean π/2 + 2/π and a deviation of 0.65.
    assert!(matrix.amax() < error / 3f64.sqrt(), "{matrix}");
    let expected = std::f64::consts::FRAC_PI_2 + std::f64::consts::FRAC_2_PI;
    assert!((angle - expected).abs() < 0.65 * error, "{angle}");
    assert!(mean.amax() < error, "{mean}");
    assert!((covariance - Matrix3::identity()).amax() < error * 2f64.sqrt(), "{covariance}");
    assert!((opening_square - 1.0).abs() < error * 2f64.sqrt(), "{opening_square}");
}

#[test]
fn a_frame_is_the_latest_gripper_and_the_mean_of_the_points() {
    let gripper = pose(&mut rng(66));
    let mut seen = Observation {
        cloud: PointCloud { points: vec![[1.0, 2.0, 3.0], [3.0, -2.0, 0.0]], colors: vec![[0; 3]; 2] },
        world_from_gripper: gripper,
        gripper_opening: 0.4,
    };
    let frame = PriorFrame::of(&seen);
    let expected =
        PriorFrame { world_from_gripper: gripper, opening: 0.4, centroid_m: Vector3::new(2.0, 0.0, 1.5) };
    assert_eq!(frame, expected);
    seen.cloud = PointCloud::default();
    assert_eq!(PriorFrame::of(&seen).centroid_m, gripper.translation, "no point: at the gripper");
}

#[test]
fn a_spread_that_makes_no_sense_is_named() {
    for value in [-0.1, f64::NAN, f64::INFINITY] {
        for (key, prior) in [
            ("sigma_translation_m", HaarPrior { sigma_translation_m: value, ..HaarPrior::default() }),
            ("sigma_opening", HaarPrior { sigma_opening: value, ..HaarPrior::default() }),
        ] {
            let Err(FlowError::Config(text)) = Prior::Haar(prior).validate() else {
                panic!("{key} = {value} is taken")
            };
            assert!(text.contains(&format!("prior.{key}")), "{text}");
        }
    }
}
