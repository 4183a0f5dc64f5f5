//! The forward process: its two ends, its moments, and that one step back undoes it.

use std::f64::consts::PI;

use reseflow_flow::{AnchoredChunk, Diffusion, DiffusionConfig, LeftFactor};
use reseflow_lie::{Matrix6, SE3, SO3, Vector3, Vector6, geodesic_distance};

use super::{action, anchored, between, diffusion};
use crate::rng;

#[test]
fn without_noise_it_leads_from_the_clean_pose_to_the_identity_as_published() {
    let (diffusion, mut rng) = (diffusion(), rng(81));
    let schedule = diffusion.schedule();
    for _ in 0..50 {
        let clean = action(&mut rng);
        let pose = clean.anchor_from_gripper;
        assert!(between(&diffusion.shrunk(&clean, 0), &clean) < 1e-12, "all of it at level 0");
        for level in 1..=100 {
            let signal = schedule.signal(level);
            // F(s) = Exp((1 − s) Log(I · (H⁰)⁻¹)) H⁰.
            let expected = SE3::exp(&(pose.inverse().log() * (1.0 - signal))) * pose;
            let shrunk = diffusion.shrunk(&clean, level);
            let apart = between(
                &shrunk,
                &reseflow_flow::AnchoredAction { anchor_from_gripper: expected, opening: 0.3 * signal },
            );
            assert!(apart < 1e-9, "level {level}: {apart}");
        }
        let end = diffusion.shrunk(&clean, 100).anchor_from_gripper.log();
        assert!(end.vector6().norm() < 2e-3 * pose.log().vector6().norm().max(1.0), "{end:?}");
    }
}

#[test]
fn the_moments_of_a_level_are_what_the_schedule_says() {
    const COUNT: usize = 20_000;
    let (diffusion, mut draws) = (diffusion(), rng(82));
    let clean = action(&mut draws);
    for level in [1, 30, 70, 100] {
        let noised = diffusion.noised(&AnchoredChunk(vec![clean; COUNT]), level, &mut draws);
        let deviation = (1.0 - diffusion.schedule().signal(level).powi(2)).sqrt();
        let sigmas = Vector6::new(0.05, 0.05, 0.05, 0.03, 0.03, 0.03) * deviation;
        let about = diffusion.shrunk(&clean, level);
        let (mut mean, mut covariance) = (Vector6::zeros(), Matrix6::zeros());
        let mut opening_square = 0.0;
        for state in &noised.0 {
            let twist = about.anchor_from_gripper.spatial_twist_to(&state.anchor_from_gripper).vector6();
            let twist = twist.component_div(&sigmas);
            mean += twist / COUNT as f64;
            covariance += twist * twist.transpose() / COUNT as f64;
            opening_square += ((state.opening - about.opening) / (0.05 * deviation)).powi(2) / COUNT as f64;
        }
        let error = 5.0 / (COUNT as f64).sqrt();
        assert!(mean.amax() < error, "level {level}: {mean}");
        assert!((opening_square - 1.0).abs() < error * 2f64.sqrt(), "level {level}: {opening_square}");
        assert!(
            (covariance - Matrix6::identity()).amax() < error * 2f64.sqrt(),
            "level {level}: {covariance}"
        );
    }
}

#[test]
fn noise_at_the_last_level_is_what_a_sampler_starts_from() {
    let diffusion = diffusion();
    let still = reseflow_flow::AnchoredAction { anchor_from_gripper: SE3::identity(), opening: 0.0 };
    let drawn = diffusion.draw(6, &mut rng(83));
    let noised = diffusion.noised(&AnchoredChunk(vec![still; 6]), 100, &mut rng(83));
    assert_eq!(drawn, noised);
    assert!(between(&drawn.0[0], &drawn.0[1]) > 1e-4, "actions have noise of their own");
}

/// The released code's target leaves F out: a network that knows it perfectly names F, and not the clean pose.
#[test]
fn the_whole_relative_transform_leads_back_and_the_factor_of_the_noise_alone_does_not() {
    let (diffusion, mut draws) = (diffusion(), rng(84));
    for level in [2, 40, 100] {
        let clean = anchored(10, &mut draws);
        let noised = diffusion.noised(&clean, level, &mut draws);
        for (noisy, clean) in noised.0.iter().zip(&clean.0) {
            assert!(between(&LeftFactor::between(noisy, clean).apply(noisy), clean) < 1e-9);
            let without = diffusion.shrunk(clean, level);
            let published = LeftFactor::between(noisy, &without).apply(noisy);
            assert!(between(&published, &without) < 1e-9);
            assert!(level == 2 || between(&published, clean) > 0.05, "control: F is far from the data");
        }
    }
}

#[test]
fn a_step_back_from_a_noiseless_state_is_the_noiseless_state_of_the_level_below() {
    let (diffusion, mut draws) = (diffusion(), rng(85));
    for _ in 0..20 {
        let clean = action(&mut draws);
        for (from, to) in [(100, 99), (100, 1), (50, 49), (50, 0), (2, 1), (1, 0)] {
            let back = diffusion.posterior_mean(&diffusion.shrunk(&clean, from), &clean, from, to);
            let apart = between(&back, &diffusion.shrunk(&clean, to));
            assert!(apart < 1e-8, "from {from} to {to}: {apart}");
        }
    }
}

/// The published triangle turns past half a turn, where Log jumps to the other side.
#[test]
fn an_estimate_that_crosses_half_a_turn_does_not_throw_the_state_back() {
    let (diffusion, mut draws) = (diffusion(), rng(87));
    for _ in 0..20 {
        let axis = action(&mut draws).anchor_from_gripper.translation.normalize();
        let turned = |angle: f64| reseflow_flow::AnchoredAction {
            anchor_from_gripper: SE3::new(
                SO3::exp(&(axis * angle)),
                axis * 0.1 + Vector3::new(0.0, 0.2, 0.0),
            ),
            opening: 0.0,
        };
        let (short, beyond) = (turned(PI - 0.02), turned(PI + 0.03));
        for (from, to) in [(40, 39), (40, 1), (10, 5), (2, 1)] {
            let state = diffusion.shrunk(&short, from);
            let straight = diffusion.posterior_mean(&state, &short, from, to);
            let crossing = diffusion.posterior_mean(&state, &beyond, from, to);
            let apart = between(&straight, &crossing);
            assert!(apart < 0.06, "from {from} to {to}: {apart} for estimates that are 0.05 apart");
            let weights = diffusion.schedule().posterior(from, to);
            let principal = beyond.anchor_from_gripper.log() * weights.clean
                + state.anchor_from_gripper.log() * weights.noisy;
            let jumped = geodesic_distance(&SE3::exp(&principal), &straight.anchor_from_gripper).d_geo();
            assert!(from != 10 || jumped > 0.5, "control: the principal logarithm jumps by {jumped}");
        }
        let end = diffusion.posterior_mean(&diffusion.shrunk(&short, 40), &beyond, 40, 0);
        assert!(between(&end, &beyond) < 1e-9, "the last step is the estimate itself");
    }
}

/// Where poses commute with their noise (rotations about one axis), a drawn step back has the moments of the level below.
#[test]
fn a_drawn_step_back_has_the_spread_of_the_level_below() {
    const COUNT: usize = 20_000;
    let config =
        DiffusionConfig { sigma_rotation_rad: 0.02, sigma_translation_m: 0.0, ..DiffusionConfig::default() };
    let diffusion = Diffusion::new(&config).unwrap();
    let still = reseflow_flow::AnchoredAction { anchor_from_gripper: SE3::identity(), opening: 0.0 };
    let mut draws = rng(86);
    let (from, to) = (60, 35);
    let noised = diffusion.noised(&AnchoredChunk(vec![still; COUNT]), from, &mut draws);
    let posterior = diffusion.schedule().posterior(from, to);
    let mut variance = 0.0;
    for noisy in &noised.0 {
        let mean = diffusion.posterior_mean(noisy, &still, from, to).anchor_from_gripper.log().angular;
        variance += mean.norm_squared() / (3 * COUNT) as f64;
    }
    let total = variance / 0.02f64.powi(2) + posterior.deviation.powi(2);
    let expected = diffusion.schedule().noise(to).powi(2);
    assert!((total / expected - 1.0).abs() < 5.0 * (2.0 / (3 * COUNT) as f64).sqrt(), "{total}, {expected}");
}
