//! The gripper elsewhere than it was recorded.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use reseflow_lie::{BodyTwist, SE3, SO3, Vector3};

use crate::AugmentConfig;

/// How near to a right angle the closing directions of gripper and next action may come: the cosine of 80°.
///
/// Beyond it an expert might turn the other way, and the recorded actions would be the wrong ones.
const LEAST_ALONG: f64 = 0.17;
/// Draws after which a gripper stays where it is.
const MAX_DRAWS: usize = 16;

/// A move of `gripper`, on the right of its pose, after which an expert would still go to `next` without another half-turn: any move at
/// all where `next` is none.
pub(super) fn gripper_move(
    gripper: &SE3,
    next: Option<&SE3>,
    config: &AugmentConfig,
    rng: &mut ChaCha8Rng,
) -> Option<SE3> {
    if config.gripper_std_rad == 0.0 && config.gripper_std_m == 0.0 && config.gripper_yaw_rad == 0.0 {
        return None;
    }
    let turns = Normal::new(0.0, config.gripper_std_rad).ok()?;
    let shifts = Normal::new(0.0, config.gripper_std_m).ok()?;
    let closing = next.map(|next| next.rotation.act(&Vector3::y()));
    let is_far_from_a_tie = |moved: &SE3| {
        let moved_closing = (gripper.rotation * moved.rotation).act(&Vector3::y());
        closing.is_none_or(|closing| moved_closing.dot(&closing) >= LEAST_ALONG)
    };
    (0..MAX_DRAWS)
        .map(|_| {
            let angular = Vector3::from_fn(|_, _| turns.sample(rng));
            let linear = Vector3::from_fn(|_, _| shifts.sample(rng));
            let yaw = (config.gripper_yaw_rad > 0.0)
                .then(|| rng.random_range(-config.gripper_yaw_rad..=config.gripper_yaw_rad));
            let turned = SO3::exp(&(Vector3::z() * yaw.unwrap_or_default()));
            SE3::new(turned, Vector3::zeros()) * SE3::exp(&BodyTwist::new(angular, linear))
        })
        .find(is_far_from_a_tie)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::rand_core::SeedableRng;

    fn rng(seed: u64) -> ChaCha8Rng {
        ChaCha8Rng::seed_from_u64(seed)
    }

    fn gripper() -> SE3 {
        SE3::new(SO3::exp(&Vector3::new(0.7, 0.3, -0.7)), Vector3::new(0.1, -0.2, 0.5))
    }

    #[test]
    fn a_yawed_gripper_keeps_its_approach_axis_and_covers_the_whole_range() {
        let config = AugmentConfig { gripper_yaw_rad: 1.2, ..AugmentConfig::NONE };
        let (gripper, mut yaws) = (gripper(), Vec::new());
        for seed in 0..300 {
            let Some(moved) = gripper_move(&gripper, Some(&gripper), &config, &mut rng(seed)) else {
                continue;
            };
            let turn = moved.rotation.log();
            assert!(turn.xy().norm() < 1e-12 && moved.translation.norm() < 1e-12, "{turn:?}");
            yaws.push(turn.z);
        }
        let (low, high) =
            yaws.iter().fold((0.0_f64, 0.0_f64), |(low, high), &yaw| (low.min(yaw), high.max(yaw)));
        assert!(
            yaws.len() == 300 && (-1.2..-1.1).contains(&low) && (1.1..1.2).contains(&high),
            "{low} to {high}"
        );
    }

    #[test]
    fn a_moved_gripper_never_comes_near_the_choice_between_half_turns() {
        let config = AugmentConfig { gripper_std_rad: 0.5, ..AugmentConfig::NONE };
        let gripper = gripper();
        // The next action is 70° away from the gripper, about the approach axis.
        let next = SE3::new(gripper.rotation * SO3::exp(&(Vector3::z() * 1.22)), gripper.translation);
        let mut nearest: f64 = 1.0;
        for seed in 0..300 {
            let Some(moved) = gripper_move(&gripper, Some(&next), &config, &mut rng(seed)) else { continue };
            let closing = (gripper * moved).rotation.act(&Vector3::y());
            nearest = nearest.min(closing.dot(&next.rotation.act(&Vector3::y())));
        }
        assert!((LEAST_ALONG..0.25).contains(&nearest), "{nearest}");
    }

    #[test]
    fn where_both_half_turns_are_taught_alike_the_gripper_may_stand_across() {
        let config = AugmentConfig { gripper_yaw_rad: 1.4, ..AugmentConfig::NONE };
        // The next action is 70° away from the gripper, about the approach axis.
        let gripper = gripper();
        let next = SE3::new(gripper.rotation * SO3::exp(&(Vector3::z() * 1.22)), gripper.translation);
        let closing = next.rotation.act(&Vector3::y());
        let along: Vec<f64> = (0..300)
            .filter_map(|seed| gripper_move(&gripper, None, &config, &mut rng(seed)))
            .map(|moved| (gripper * moved).rotation.act(&Vector3::y()).dot(&closing))
            .collect();
        let across = along.iter().filter(|along| along.abs() < LEAST_ALONG).count();
        // Draws from a range of 160°, of which 20° are near the tie: 37.5 are expected.
        assert!(along.len() == 300 && (20..60).contains(&across), "{across} of {}", along.len());
        assert!(along.iter().any(|&along| along < -0.8) && along.iter().any(|&along| along > 0.9));
    }
}
