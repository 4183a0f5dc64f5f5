//! What augmentations keep, and what they change.

use super::*;
use rand_chacha::rand_core::SeedableRng;
use reseflow_data::PointCloud;
use reseflow_lie::{SO3, Vector3, geodesic_distance};

fn rng(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

fn pose(angle: f64, position: [f64; 3]) -> SE3 {
    SE3::new(SO3::exp(&Vector3::new(angle, 0.3, -angle)), Vector3::from(position))
}

fn seen() -> Observation {
    let points = (0..20_u8).map(|i| [0.01 * f32::from(i), 0.1 * f32::from(i % 7), -0.05 * f32::from(i % 3)]);
    Observation {
        cloud: PointCloud { points: points.collect(), colors: vec![[200, 40, 90]; 20] },
        world_from_gripper: pose(0.7, [0.1, -0.2, 0.5]),
        gripper_opening: 0.4,
    }
}

fn next() -> Action {
    Action { world_from_gripper: pose(0.4, [0.2, 0.0, 0.1]), opening: 1.0 }
}

fn chunk(pose: SE3) -> ActionChunk {
    ActionChunk(vec![Action { world_from_gripper: pose, opening: 0.5 }])
}

fn first(chunk: &ActionChunk) -> SE3 {
    chunk.0[0].world_from_gripper
}

/// What `drawn` makes of the observation and of recorded actions and noise.
fn changed(drawn: &Augmentation) -> (Observation, ActionChunk, ActionChunk) {
    let (mut after, mut actions, mut noise) =
        (seen(), chunk(pose(2.0, [0.3; 3])), chunk(pose(1.0, [0.2; 3])));
    drawn.observation(&mut after);
    drawn.actions(&mut actions);
    drawn.noise(&mut noise, true);
    (after, actions, noise)
}

fn assert_same(one: &SE3, other: &SE3) {
    let apart = geodesic_distance(one, other);
    assert!(apart.rotation_rad < 1e-6 && apart.translation_m < 1e-6, "{apart:?}");
}

#[test]
fn augmentations_that_are_off_draw_and_change_nothing() {
    let (mut one, mut other) = (rng(3), rng(3));
    let before = seen();
    let drawn = Augmentation::draw(0, &before, &next(), &[], false, &AugmentConfig::NONE, &mut one);
    let (mut after, actions, noise) = changed(&drawn);
    drop_points(&mut after.cloud, 0.0, &mut one);
    assert_eq!(after, before);
    assert_eq!((first(&actions), first(&noise)), (pose(2.0, [0.3; 3]), pose(1.0, [0.2; 3])));
    assert_eq!(one.random::<u64>(), other.random::<u64>());
}

#[test]
fn a_moved_gripper_takes_its_noise_along_and_leaves_cloud_actions_and_noise_about_the_cloud() {
    let config = AugmentConfig { gripper_std_rad: 0.2, gripper_std_m: 0.05, ..AugmentConfig::NONE };
    let mut squared = [0.0; 2];
    // Far from any choice between half-turns.
    let next = Action { world_from_gripper: seen().world_from_gripper, opening: 1.0 };
    for seed in 0..300 {
        let before = seen();
        let drawn = Augmentation::draw(0, &before, &next, &[], false, &config, &mut rng(seed));
        let (after, actions, noise) = changed(&drawn);
        let mut about_the_cloud = chunk(pose(1.0, [0.2; 3]));
        drawn.noise(&mut about_the_cloud, false);
        assert_eq!(first(&about_the_cloud), pose(1.0, [0.2; 3]));
        assert_eq!(after.cloud, before.cloud);
        assert_eq!(first(&actions), pose(2.0, [0.3; 3]));
        let relative = |gripper: &SE3, pose: &SE3| gripper.inverse() * *pose;
        assert_same(
            &relative(&before.world_from_gripper, &pose(1.0, [0.2; 3])),
            &relative(&after.world_from_gripper, &first(&noise)),
        );
        let moved = (before.world_from_gripper.inverse() * after.world_from_gripper).log();
        squared[0] += moved.angular.norm_squared() / 900.0;
        squared[1] += moved.linear.norm_squared() / 900.0;
    }
    assert!(
        (squared[0].sqrt() - 0.2).abs() < 0.02 && (squared[1].sqrt() - 0.05).abs() < 0.005,
        "{squared:?}"
    );
}

#[test]
fn a_gripper_that_may_hold_something_stays_where_it_is() {
    let config = AugmentConfig { gripper_std_m: 0.05, gripper_yaw_rad: 1.0, ..AugmentConfig::NONE };
    let closing = Action { opening: 0.0, ..next() };
    for (step, action, moves) in
        [(0, closing, true), (1, next(), true), (1, closing, false), (7, closing, false)]
    {
        let drawn = Augmentation::draw(step, &seen(), &action, &[], false, &config, &mut rng(4));
        assert_eq!(drawn.gripper_move.is_some(), moves, "step {step}, opening {}", action.opening);
    }
}

#[test]
fn a_mirrored_scene_leaves_the_gripper_and_keeps_distances_between_cloud_and_actions() {
    let config = AugmentConfig { mirror_share: 1.0, ..AugmentConfig::NONE };
    let before = seen();
    let drawn = Augmentation::draw(0, &before, &next(), &[], false, &config, &mut rng(1));
    let (mut after, mut actions) = (before.clone(), chunk(pose(2.0, [0.3; 3])));
    drawn.observation(&mut after);
    drawn.actions(&mut actions);
    assert_same(&after.world_from_gripper, &before.world_from_gripper);
    let to = |point: [f32; 3], pose: &SE3| (Vector3::from(point.map(f64::from)) - pose.translation).norm();
    for (new, old) in after.cloud.points.iter().zip(&before.cloud.points) {
        assert!((to(*new, &first(&actions)) - to(*old, &pose(2.0, [0.3; 3]))).abs() < 1e-6);
    }
    assert!(geodesic_distance(&first(&actions), &pose(2.0, [0.3; 3])).rotation_rad > 0.1);
}

#[test]
fn an_upright_mirror_shows_the_gripper_its_other_mirror_image() {
    let config = AugmentConfig { mirror_share: 1.0, mirror_upright: true, ..AugmentConfig::NONE };
    let before = seen();
    let drawn = Augmentation::draw(0, &before, &next(), &[], false, &config, &mut rng(1));
    let (after, actions, noise) = changed(&drawn);
    let fingers = Vector3::new(1.0, -1.0, 1.0);
    let relative = |seen: &Observation, point: [f32; 3]| {
        seen.world_from_gripper.inverse().act(&Vector3::from(point.map(f64::from)))
    };
    for (new, old) in after.cloud.points.iter().zip(&before.cloud.points) {
        let (new, old, height) = (relative(&after, *new), relative(&before, *old), new[2] - old[2]);
        assert!((new - old.component_mul(&fingers)).norm() < 1e-6 && height.abs() < 1e-6);
    }
    for (new, old) in [(&actions, pose(2.0, [0.3; 3])), (&noise, pose(1.0, [0.2; 3]))] {
        let new = after.world_from_gripper.inverse() * first(new);
        let old = before.world_from_gripper.inverse() * old;
        assert!((new.translation - old.translation.component_mul(&fingers)).norm() < 1e-9);
        // Two reflections: D R D.
        for (axis, sign) in [(Vector3::x(), 1.0), (Vector3::y(), -1.0), (Vector3::z(), 1.0)] {
            let expected = old.rotation.act(&axis).component_mul(&fingers) * sign;
            assert!((new.rotation.act(&axis) - expected).norm() < 1e-9);
        }
    }
}

#[test]
fn a_half_turn_swaps_the_fingers_of_gripper_noise_and_actions() {
    let config = AugmentConfig { half_turn_share: 1.0, ..AugmentConfig::NONE };
    let before = seen();
    let drawn = Augmentation::draw(0, &before, &next(), &[], false, &config, &mut rng(1));
    let (after, actions, noise) = changed(&drawn);
    assert_eq!(after.cloud, before.cloud);
    for (new, old) in [
        (after.world_from_gripper, before.world_from_gripper),
        (first(&actions), pose(2.0, [0.3; 3])),
        (first(&noise), pose(1.0, [0.2; 3])),
    ] {
        assert_eq!(new.translation, old.translation);
        for (axis, sign) in [(Vector3::x(), -1.0), (Vector3::y(), -1.0), (Vector3::z(), 1.0)] {
            assert!((new.rotation.act(&axis) - old.rotation.act(&axis) * sign).norm() < 1e-12);
        }
    }
}

#[test]
fn a_turned_scene_takes_gripper_noise_and_actions_along_whatever_else_is_done() {
    let plain = AugmentConfig {
        scale_std: 0.2,
        gripper_std_rad: 0.2,
        gripper_std_m: 0.05,
        bend_std: 0.2,
        mirror_share: 1.0,
        half_turn_share: 0.5,
        ..AugmentConfig::NONE
    };
    let seen_by_the_gripper = |config: &AugmentConfig| {
        let drawn = Augmentation::draw(0, &seen(), &next(), &[], false, config, &mut rng(6));
        let (after, actions, noise) = changed(&drawn);
        let gripper_from_world = after.world_from_gripper.inverse();
        let point = |point: &[f32; 3]| gripper_from_world.act(&Vector3::from(point.map(f64::from)));
        let points: Vec<_> = after.cloud.points.iter().map(point).collect();
        let poses = [&actions, &noise].map(|chunk| gripper_from_world * first(chunk));
        (after.world_from_gripper, points, poses)
    };
    let (still, points, poses) = seen_by_the_gripper(&plain);
    let (turned, same_points, same_poses) =
        seen_by_the_gripper(&AugmentConfig { scene_rotation: true, ..plain });
    assert!(geodesic_distance(&still, &turned).rotation_rad > 0.1, "nothing turned");
    points.iter().zip(&same_points).for_each(|(one, other)| assert!((one - other).norm() < 1e-6));
    poses.iter().zip(&same_poses).for_each(|(one, other)| assert_same(one, other));
}

#[test]
fn an_earlier_pose_goes_with_the_scene_but_not_with_the_grippers_own_move() {
    let config = AugmentConfig {
        scale_std: 0.2,
        gripper_std_m: 0.05,
        bend_std: 0.2,
        mirror_share: 0.5,
        half_turn_share: 0.5,
        scene_rotation: true,
        ..AugmentConfig::NONE
    };
    let held = Action { opening: 0.0, ..next() };
    for seed in 0..20 {
        for (step, action, moves) in [(3, held, false), (0, next(), true)] {
            let before = seen();
            let drawn = Augmentation::draw(step, &before, &action, &[], false, &config, &mut rng(seed));
            let mut after = before.clone();
            drawn.observation(&mut after);
            let earlier = drawn.earlier(before.world_from_gripper);
            let off = geodesic_distance(&earlier, &after.world_from_gripper);
            assert_eq!(off.translation_m > 1e-6, moves, "{off:?}");
        }
    }
}

#[test]
fn shares_are_the_chances_of_a_mirror_and_of_a_half_turn() {
    let config = AugmentConfig { mirror_share: 0.3, half_turn_share: 0.6, ..AugmentConfig::NONE };
    let mut rng = rng(5);
    let drawn: Vec<_> =
        (0..1000).map(|_| Augmentation::draw(0, &seen(), &next(), &[], false, &config, &mut rng)).collect();
    let mirrored = drawn.iter().filter(|drawn| drawn.mirror.is_some()).count();
    let turned = drawn.iter().filter(|drawn| drawn.is_half_turned).count();
    // Four standard deviations are 62.
    assert!(mirrored.abs_diff(300) < 62 && turned.abs_diff(600) < 62, "{mirrored} and {turned}");
}
