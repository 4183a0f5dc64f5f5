//! What is drawn on a plane, otherwise: redrawn, or the whole plane bent.

use rand_chacha::ChaCha8Rng;
use reseflow_data::{ActionChunk, PointCloud};
use reseflow_lie::SE3;

use super::bend::Bend;
use super::chance;
use super::redraw::Redraw;
use crate::AugmentConfig;

/// What a warp has to know of a window.
pub(super) struct Recorded<'a> {
    pub(super) cloud: &'a PointCloud,
    pub(super) gripper: SE3,
    pub(super) next: SE3,
    /// All the episode's actions, or none where its line is not to be redrawn.
    pub(super) route: Vec<SE3>,
    /// Whether the gripper is on its way along the route, not still anywhere.
    pub(super) is_under_way: bool,
    /// Whether what is taught is the same wherever the gripper stands, so that a redrawn line may begin in any direction from it.
    pub(super) is_taught_along_motion: bool,
}

/// A map of the plane across the approach axis.
#[derive(Debug)]
pub(super) enum Warp {
    Bend(Bend),
    Redraw(Redraw),
}

impl Warp {
    /// The warp of a window, and what takes gripper and noise along; `None` where `config` asks for none.
    pub(super) fn draw(
        recorded: &Recorded<'_>,
        config: &AugmentConfig,
        rng: &mut ChaCha8Rng,
    ) -> Option<(Self, SE3)> {
        let Recorded { cloud, gripper, next, route, is_under_way, is_taught_along_motion } = recorded;
        let anchor = if *is_under_way { gripper } else { next };
        // Its own pose is not quite what was commanded: the plane is that of the next action.
        let plane = SE3::new(next.rotation, anchor.translation);
        let redraw = chance(config.redraw_share, rng)
            .then(|| Redraw::draw(route, &plane, *is_taught_along_motion, rng))
            .flatten();
        if let Some(redraw) = redraw {
            // A gripper that is under way stays, as its place on the line does; another one goes with what is far from the line.
            let follow = if *is_under_way { SE3::identity() } else { redraw.rest() };
            return Some((Self::Redraw(redraw), follow));
        }
        let bend = Bend::draw(cloud, next, config, rng)?;
        Some((Self::Bend(bend), bend.pose(next) * next.inverse()))
    }

    /// The warped scene's points.
    pub(super) fn points(&self, points: &mut [[f32; 3]]) {
        match self {
            Self::Bend(bend) => bend.points(points),
            Self::Redraw(redraw) => redraw.points(points),
        }
    }

    /// A pose of the warped scene.
    pub(super) fn pose(&self, pose: &SE3) -> SE3 {
        match self {
            Self::Bend(bend) => bend.pose(pose),
            Self::Redraw(redraw) => redraw.pose(pose),
        }
    }

    /// The warped trajectory.
    pub(super) fn actions(&self, chunk: &mut ActionChunk) {
        match self {
            Self::Bend(bend) => bend.actions(chunk),
            Self::Redraw(redraw) => {
                for action in &mut chunk.0 {
                    action.world_from_gripper = redraw.pose(&action.world_from_gripper);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::rand_core::SeedableRng;
    use reseflow_lie::{SO3, Vector3, geodesic_distance};
    use std::f64::consts::FRAC_PI_2;

    /// A straight line's poses, 4 cm apart, and a gripper high over its middle, or on it after the third of them.
    fn recorded(cloud: &PointCloud, is_under_way: bool, is_taught_along_motion: bool) -> Recorded<'_> {
        let at = |x: f64, z: f64| SE3::new(SO3::exp(&Vector3::new(0.0, 0.0, -1.5)), Vector3::new(x, 0.2, z));
        let route: Vec<SE3> = (0..7).map(|index| at(0.04 * f64::from(index), 0.0)).collect();
        let (gripper, next) =
            if is_under_way { (at(0.08, 0.001), route[3]) } else { (at(0.12, 0.3), route[0]) };
        Recorded { cloud, gripper, next, route, is_under_way, is_taught_along_motion }
    }

    #[test]
    fn a_redrawn_line_leaves_the_next_action_or_the_gripper_that_is_on_it() {
        let cloud = PointCloud { points: vec![[0.1, 0.2, 0.0]], colors: vec![[0; 3]] };
        let config = AugmentConfig { redraw_share: 1.0, bend_std: 0.2, ..AugmentConfig::NONE };
        let (mut moved, mut farthest) = ([0.0_f64; 2], 0.0_f64);
        for seed in 0..40 {
            for (place, is_under_way) in [false, true].into_iter().enumerate() {
                let recorded = recorded(&cloud, is_under_way, false);
                let drawn = Warp::draw(&recorded, &config, &mut ChaCha8Rng::seed_from_u64(seed));
                let Some((warp @ Warp::Redraw(_), follow)) = drawn else { panic!("it is not redrawn") };
                let Recorded { gripper, next, route, .. } = &recorded;
                let fixed = if is_under_way { gripper } else { next };
                let off = geodesic_distance(fixed, &warp.pose(fixed));
                assert!(off.translation_m < 1e-4 && off.rotation_rad < 0.02, "{off:?}");
                let shift = geodesic_distance(gripper, &(follow * *gripper));
                if !is_under_way {
                    let mut board = [[0.1, 0.4, 0.0]];
                    warp.points(&mut board);
                    let with_gripper = follow.act(&Vector3::new(0.1, 0.4, 0.0));
                    assert!((Vector3::from(board[0].map(f64::from)) - with_gripper).norm() < 1e-6);
                }
                assert!(
                    shift.rotation_rad < 1e-9 && !(is_under_way && shift.translation_m > 1e-9),
                    "{shift:?}"
                );
                farthest = farthest.max(shift.translation_m);
                let end = route[6];
                moved[place] = moved[place].max((warp.pose(&end).translation - end.translation).norm());
            }
        }
        assert!(farthest > 0.03 && moved.iter().all(|moved| *moved > 0.1), "{farthest}, {moved:?}");
    }

    #[test]
    fn where_both_half_turns_are_taught_alike_the_line_begins_in_any_direction_from_board_and_gripper() {
        let cloud = PointCloud { points: vec![[0.1, 0.2, 0.0]], colors: vec![[0; 3]] };
        let config = AugmentConfig { redraw_share: 1.0, ..AugmentConfig::NONE };
        let mut quarters = [0; 4];
        for seed in 0..60 {
            for is_under_way in [false, true] {
                let recorded = recorded(&cloud, is_under_way, true);
                let drawn = Warp::draw(&recorded, &config, &mut ChaCha8Rng::seed_from_u64(seed));
                let Some((warp, follow)) = drawn else { panic!("it is not redrawn") };
                let mut board = [[0.1, 0.4, 0.0], [0.3, -0.1, 0.0]];
                warp.points(&mut board);
                let [one, two] = board.map(|point| Vector3::from(point.map(f64::from)));
                let side = two - one;
                assert!((side.norm() - 0.2_f64.hypot(0.5)).abs() < 1e-6 && side.z.abs() < 1e-6);
                if is_under_way {
                    assert_eq!(follow, SE3::identity());
                } else {
                    assert!((one - follow.act(&Vector3::new(0.1, 0.4, 0.0))).norm() < 1e-6);
                    let turn_rad = follow.rotation.log();
                    assert!(turn_rad.xy().norm() < 1e-9);
                    quarters[(turn_rad.z / FRAC_PI_2 + 2.0).clamp(0.0, 3.9) as usize] += 1;
                }
                let fixed = if is_under_way { &recorded.gripper } else { &recorded.next };
                assert!(geodesic_distance(fixed, &warp.pose(fixed)).rotation_rad < 0.02);
            }
        }
        // Fifteen are expected in each, with a standard deviation of 3.4.
        assert!(quarters.iter().all(|count| *count > 3), "{quarters:?}");
    }
}
