//! The `gripper` prior: it moves with the gripper draw by draw, and its spread is what the configuration says.

use reseflow_flow::{FlowError, GripperPrior};
use reseflow_lie::{Matrix6, SE3, Vector6};

use crate::{apart, moved, pose, rng};

#[test]
fn the_same_draws_about_a_moved_gripper_are_the_moved_draws() {
    let mut poses = rng(21);
    let prior = GripperPrior::default();
    for stream in 0..20 {
        let (gripper, world) = (pose(&mut poses), pose(&mut poses));
        let draw = |gripper: &SE3| prior.sample(gripper, 0.7, 8, &mut rng(100 + stream));
        let expected = moved(&world, &draw(&gripper));
        assert!(apart(&draw(&(world * gripper)), &expected) < 1e-12);
        assert!(apart(&draw(&gripper), &expected) > 1e-3, "control: a gripper that stays behind");
    }
}

#[test]
fn another_stream_draws_another_trajectory_of_different_steps() {
    let prior = GripperPrior::default();
    let draw = |stream| prior.sample(&SE3::identity(), 0.5, 3, &mut rng(stream));
    assert_eq!(draw(1), draw(1));
    assert!(apart(&draw(1), &draw(2)) > 1e-3);
    let steps = draw(1);
    assert!(steps.0[0] != steps.0[1] && steps.0[1] != steps.0[2]);
    assert_eq!(prior.sample(&SE3::identity(), 0.5, 0, &mut rng(1)).len(), 0);
}

#[test]
fn the_moments_match_the_sigmas() {
    const COUNT: usize = 20_000;
    let prior = GripperPrior { sigma_rotation_rad: 0.4, sigma_translation_m: 0.07, sigma_opening: 0.15 };
    let gripper = pose(&mut rng(22));
    let draws = prior.sample(&gripper, 0.3, COUNT, &mut rng(23));
    assert_eq!(draws.len(), COUNT);
    // Standardised body twists: all entries of the covariance are known. 0.4 rad keeps 3σ well below the cut at π.
    let sigmas = Vector6::new(0.4, 0.4, 0.4, 0.07, 0.07, 0.07);
    let (mut mean, mut covariance) = (Vector6::zeros(), Matrix6::zeros());
    let (mut opening_mean, mut opening_square) = (0.0, 0.0);
    for draw in draws.iter() {
        let twist = gripper.body_twist_to(&draw.world_from_gripper).vector6().component_div(&sigmas);
        mean += twist / COUNT as f64;
        covariance += twist * twist.transpose() / COUNT as f64;
        let opening = (draw.opening - 0.3) / 0.15;
        opening_mean += opening / COUNT as f64;
        opening_square += opening * opening / COUNT as f64;
    }
    // Five standard errors: of a mean 1/√n, of a variance √(2/n), of a covariance 1/√n.
    let error = 5.0 / (COUNT as f64).sqrt();
    assert!(mean.amax() < error && opening_mean.abs() < error, "{mean} {opening_mean}");
    for row in 0..6 {
        for column in 0..6 {
            let (expected, bound) = if row == column { (1.0, error * 2f64.sqrt()) } else { (0.0, error) };
            let found = covariance[(row, column)];
            assert!((found - expected).abs() < bound, "covariance {row} {column}: {found}");
        }
    }
    assert!((opening_square - 1.0).abs() < error * 2f64.sqrt(), "{opening_square}");
}

#[test]
fn no_spread_is_the_gripper_itself() {
    let prior = GripperPrior { sigma_rotation_rad: 0.0, sigma_translation_m: 0.0, sigma_opening: 0.0 };
    let gripper = pose(&mut rng(24));
    for action in prior.sample(&gripper, 0.25, 3, &mut rng(25)).iter() {
        assert!(gripper.body_twist_to(&action.world_from_gripper).vector6().norm() < 1e-14);
        assert_eq!(action.opening, 0.25);
    }
}

#[test]
fn a_spread_that_makes_no_sense_is_named() {
    type Spoil = fn(&mut GripperPrior, f64);
    let cases: [(&str, Spoil); 3] = [
        ("sigma_rotation_rad", |prior, value| prior.sigma_rotation_rad = value),
        ("sigma_translation_m", |prior, value| prior.sigma_translation_m = value),
        ("sigma_opening", |prior, value| prior.sigma_opening = value),
    ];
    assert_eq!(GripperPrior::default().validate(), Ok(()));
    for (key, spoil) in cases {
        for value in [-0.1, f64::NAN, f64::INFINITY] {
            let mut prior = GripperPrior::default();
            spoil(&mut prior, value);
            let Err(FlowError::Config(text)) = prior.validate() else { panic!("{key} = {value} is taken") };
            assert!(text.contains(&format!("prior.{key}")) && text.contains(&value.to_string()), "{text}");
        }
    }
}
