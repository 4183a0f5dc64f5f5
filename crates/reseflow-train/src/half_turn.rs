//! The half-turn of a gripper whose fingers are alike: which of two trajectories that do the same is taught, and which is taken.

use reseflow_data::{ActionChunk, gripper_half_turn};
use reseflow_lie::{SE3, Vector3};
use reseflow_net::{DecoderConfig, Parameterisation};

use crate::PolicySample;

/// The direction in which the fingers close, in the world.
fn closing(world_from_gripper: &SE3) -> Vector3<f64> {
    world_from_gripper.rotation.act(&Vector3::y())
}

/// Turns `sample` by half a turn about the approach axis where its first pose then closes more nearly as the gripper does, its nodes
/// along with it.
///
/// What counts is how the gripper closes as seen along the first pose's approach: there an expert that works on a surface has its quarter
/// turn. The whole angle between both is another measure where the surface is tilted. The decision is invariant under motions of the
/// scene. A pose exactly a quarter turn away stays as it is.
pub(crate) fn take_nearest_half_turn(sample: &mut PolicySample, world_from_gripper: &SE3) {
    let Some(first) = sample.consensus.iter().next() else { return };
    if closing(world_from_gripper).dot(&closing(&first.world_from_gripper)) < 0.0 {
        turn(&mut sample.consensus);
        sample.nodes.iter_mut().for_each(turn);
    }
}

/// Whether networks of these settings are taught trajectories whose fingers close along their motion: where the fingers are alike.
///
/// Not those that answer with velocities. A trajectory half a turn away has a logarithm with two branches, whose mean is neither; they
/// are taught the half-turn that the expert took, which is the nearer one.
pub(crate) fn closes_along_motion(decoder: &DecoderConfig) -> bool {
    decoder.nearest_half_turn && decoder.parameterisation == Parameterisation::Endpoint
}

/// A trajectory that moves less than this along the closing direction does not say which half-turn closes along its motion, metres.
const LEAST_MOTION_M: f64 = 0.002;

/// Turns `chunk` by half a turn about the approach axis where it moves against the closing direction, so that it moves along it.
///
/// Which half-turn is nearer to the gripper jumps where the two are equally near. This choice does not depend on where the gripper is, and
/// changes smoothly with the path ahead, so that it can be learned; [`take_nearest_half_turn`] then restores the other. A trajectory
/// that hardly moves that way, such as the rest of a path at its end, stays as it is.
pub(crate) fn close_along_motion(chunk: &mut ActionChunk) {
    let steps = chunk.0.windows(2).map(|pair| {
        let [from, to] = [pair[0].world_from_gripper, pair[1].world_from_gripper];
        0.5 * (closing(&from) + closing(&to)).dot(&(to.translation - from.translation))
    });
    if steps.sum::<f64>() < -LEAST_MOTION_M {
        turn(chunk);
    }
}

fn turn(chunk: &mut ActionChunk) {
    for action in &mut chunk.0 {
        action.world_from_gripper = action.world_from_gripper * gripper_half_turn();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use reseflow_data::Action;
    use reseflow_lie::{BodyTwist, SO3, geodesic_distance};
    use std::f64::consts::{FRAC_PI_2, PI};

    fn pose(angular: [f64; 3], x_m: f64) -> SE3 {
        SE3::new(SO3::exp(&Vector3::from(angular)), Vector3::new(x_m, 0.0, 0.0))
    }

    fn sample(yaws_rad: [f64; 2]) -> PolicySample {
        let chunk = |off: f64| {
            let actions =
                yaws_rad.map(|yaw| Action { world_from_gripper: pose([0.0, 0.0, yaw], off), opening: 0.3 });
            ActionChunk(actions.to_vec())
        };
        PolicySample { consensus: chunk(0.1), nodes: vec![chunk(0.0), chunk(0.2)], spread: vec![0.1; 2] }
    }

    #[test]
    fn the_first_pose_decides_for_the_whole_trajectory_and_its_nodes() {
        let gripper = pose([0.0, 0.0, 0.2], 1.0);
        // The first one begins within a quarter turn of the gripper, though it does not end there.
        for (yaws, is_turned) in [([1.6, 3.0], false), ([2.0, 0.3], true), ([-1.2, 0.1], false)] {
            let before = sample(yaws);
            let mut after = before.clone();
            take_nearest_half_turn(&mut after, &gripper);
            if !is_turned {
                assert_eq!(after, before);
                continue;
            }
            assert_eq!(after.spread, before.spread);
            let chunks = |sample: &PolicySample| {
                let all = std::iter::once(&sample.consensus).chain(&sample.nodes);
                all.flat_map(|chunk| chunk.0.clone()).collect::<Vec<_>>()
            };
            for (before, after) in chunks(&before).iter().zip(chunks(&after)) {
                let expected = before.world_from_gripper * gripper_half_turn();
                assert!(geodesic_distance(&after.world_from_gripper, &expected).d_geo() < 1e-12);
                assert_eq!(after.opening, before.opening);
            }
            take_nearest_half_turn(&mut after, &gripper);
            let first = after.consensus.0[0].world_from_gripper;
            assert!(geodesic_distance(&first, &gripper).rotation_rad < FRAC_PI_2, "it stays where it is");
        }
    }

    #[test]
    fn on_a_tilted_surface_the_quarter_turn_is_measured_along_the_approach() {
        let gripper = pose([0.0; 3], 0.0);
        let tilt = SO3::exp(&(0.7 * Vector3::new(1.0, 1.0, 0.0).normalize()));
        // Turned about the approach and then tilted: further than a quarter turn by the whole angle, nearer by how the fingers close, and
        // the other way round.
        for (turn_deg, is_turned) in [(-95.0_f64, false), (85.0, true), (-80.0, false), (100.0, true)] {
            let turned = SO3::exp(&(Vector3::z() * turn_deg.to_radians()));
            let first = SE3::new(tilt * turned, Vector3::zeros());
            let consensus = ActionChunk(vec![Action { world_from_gripper: first, opening: 0.3 }]);
            let mut sample = PolicySample { consensus, nodes: Vec::new(), spread: Vec::new() };
            take_nearest_half_turn(&mut sample, &gripper);
            let expected = if is_turned { first * gripper_half_turn() } else { first };
            let apart = geodesic_distance(&sample.consensus.0[0].world_from_gripper, &expected);
            assert!(apart.d_geo() < 1e-12, "{turn_deg}°: {apart:?}");
        }
    }

    /// Down to a line, along it, and up; the closing direction leads along the line or against it.
    fn along_a_line(is_against: bool, length_m: f64) -> ActionChunk {
        let yaw = if is_against { PI } else { 0.0 };
        let places = [[0.0, 0.06], [0.0, 0.0], [0.5 * length_m, 0.0], [length_m, 0.0], [length_m, 0.05]];
        let actions = places.map(|[y, z]| Action {
            world_from_gripper: SE3::new(SO3::exp(&(Vector3::z() * yaw)), Vector3::new(0.0, y, z)),
            opening: 0.3,
        });
        ActionChunk(actions.to_vec())
    }

    #[test]
    fn both_half_turns_are_taught_as_the_one_that_closes_along_the_motion() {
        let motion = SE3::exp(&BodyTwist::new(Vector3::new(0.4, -1.1, 0.7), Vector3::new(0.3, 0.1, -2.0)));
        for is_against in [false, true] {
            let mut chunk = along_a_line(is_against, 0.1);
            chunk
                .0
                .iter_mut()
                .for_each(|action| action.world_from_gripper = motion * action.world_from_gripper);
            close_along_motion(&mut chunk);
            for (action, plain) in chunk.iter().zip(along_a_line(false, 0.1).iter()) {
                let expected = motion * plain.world_from_gripper;
                assert!(geodesic_distance(&action.world_from_gripper, &expected).d_geo() < 1e-9);
            }
        }
    }

    #[test]
    fn a_trajectory_that_hardly_moves_that_way_stays_as_it_is() {
        let mut still = along_a_line(true, 0.001);
        close_along_motion(&mut still);
        assert_eq!(still, along_a_line(true, 0.001));
    }

    #[test]
    fn a_moved_scene_gives_the_moved_choice() {
        let motion = SE3::exp(&BodyTwist::new(Vector3::new(0.4, -1.1, 0.7), Vector3::new(0.3, 0.1, -2.0)));
        let gripper = pose([0.0, 0.0, 0.2], 1.0);
        let mut here = sample([2.0, 0.3]);
        let mut there = here.clone();
        let moved = |chunk: &mut ActionChunk| {
            chunk
                .0
                .iter_mut()
                .for_each(|action| action.world_from_gripper = motion * action.world_from_gripper);
        };
        moved(&mut there.consensus);
        there.nodes.iter_mut().for_each(moved);
        take_nearest_half_turn(&mut here, &gripper);
        take_nearest_half_turn(&mut there, &(motion * gripper));
        for (here, there) in here.consensus.iter().zip(there.consensus.iter()) {
            let expected = motion * here.world_from_gripper;
            assert!(geodesic_distance(&there.world_from_gripper, &expected).d_geo() < 1e-9);
        }
    }
}
