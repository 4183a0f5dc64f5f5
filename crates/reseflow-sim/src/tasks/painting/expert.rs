//! The painting expert: over the beginning, down to it, along the stroke, away.
//!
//! The gripper stands upright on the board and turns with the stroke, its closing direction along it. So the screw geodesic from
//! one pose to the next is an arc of a circle in the board's plane, and seven poses follow a curved stroke closely.

use std::f64::consts::FRAC_PI_2;

use nalgebra::Vector3;
use reseflow_data::Action;
use reseflow_lie::SE3;

use super::paint::PAINTING_M;
use super::setup::PaintingSetup;
use super::stroke::{Place, Stroke, wrapped};
use crate::expert::{Script, Tolerance};
use crate::tabletop::ACTION_STEPS;
use crate::world::brush::TIP_Z_M;
use crate::world::gripper;

/// How far the tip is above the beginning at the two approach poses, metres.
const APPROACH_M: [f64; 2] = [0.06, 0.012];
/// How far the tip is above the end at last, metres.
const LIFT_M: f64 = 0.05;
/// Poses on the stroke: what the approach and the lift leave.
const STROKE_POSES: usize = ACTION_STEPS - APPROACH_M.len() - 1;
/// Fewer poses on the stroke than this do not follow it.
const FEWEST_STROKE_POSES: usize = 4;
/// The board is where the script has it within this; the brush is held by the palm.
pub(super) const TOLERANCE: Tolerance = Tolerance { off_m: 0.004, off_rad: 0.03, held_opening: 0.0 };
/// How far the bristles are compressed on the stroke: the middle of the range in which they paint, metres.
const COMPRESSION_M: f64 = 0.5 * (PAINTING_M[0] + PAINTING_M[1]);

/// The gripper upright on the board at a place, the brush's tip `height_m` over the face; in the board's frame.
///
/// `side` is 1 where it closes along the stroke, −1 where it closes against it: the two half-turns.
fn upright(place: &Place, height_m: f64, side: f64) -> SE3 {
    let (sin, cos) = place.heading_rad.sin_cos();
    let close = Vector3::new(cos, sin, 0.0) * side;
    let [x, y] = place.point_m;
    SE3::new(gripper::orientation(&-Vector3::z(), &close), Vector3::new(x, y, TIP_Z_M + height_m))
}

/// The poses on the stroke where there is time for all of them, in the board's frame.
pub(super) fn stroke_poses(stroke: &Stroke, side: f64) -> Vec<SE3> {
    poses_on(stroke, STROKE_POSES, side)
}

fn poses_on(stroke: &Stroke, count: usize, side: f64) -> Vec<SE3> {
    stroke.places(count).iter().map(|place| upright(place, -COMPRESSION_M, side)).collect()
}

/// The turn in \[−π, π) about the board's normal, from the gripper's closing direction at the start to the stroke's at its
/// beginning.
pub(super) fn turn_to_stroke_rad(setup: &PaintingSetup) -> f64 {
    let world_from_board = setup.world_from_board();
    let close =
        world_from_board.rotation.inverse().act(&setup.world_from_gripper.rotation.act(&Vector3::y()));
    wrapped(setup.stroke.place(0.0).heading_rad - close.y.atan2(close.x))
}

/// The script for a board at `world_from_board`: a smooth function of the setup, but for the choice of the half-turn, the one
/// that is nearer at the start.
///
/// With fewer than T action steps the brush goes down sooner, then over fewer poses. `None` where these are too few.
pub(super) fn script(setup: &PaintingSetup, world_from_board: &SE3, steps: usize) -> Option<Script> {
    let approaches = match steps.checked_sub(STROKE_POSES + 1) {
        Some(left) => left.min(APPROACH_M.len()),
        None => 1,
    };
    let stroke_count = steps.checked_sub(approaches + 1).filter(|&count| count >= FEWEST_STROKE_POSES)?;
    let side = if turn_to_stroke_rad(setup).abs() <= FRAC_PI_2 { 1.0 } else { -1.0 };
    let (start, end) = (setup.stroke.place(0.0), setup.stroke.place(setup.stroke.length_m()));
    let heights_m = &APPROACH_M[APPROACH_M.len() - approaches..];
    let approach = heights_m.iter().map(|&height_m| upright(&start, height_m, side));
    let lift = upright(&end, LIFT_M, side);
    let actions: Vec<Action> = approach
        .chain(poses_on(&setup.stroke, stroke_count, side))
        .chain([lift])
        .map(|board_from_gripper| Action {
            world_from_gripper: *world_from_board * board_from_gripper,
            opening: 0.0,
        })
        .collect();
    Some(Script { objects: vec![*world_from_board], held_from: actions.len(), actions })
}

/// The expert's T commands for the board where it stands at the start.
pub(super) fn commands(setup: &PaintingSetup) -> Vec<Action> {
    script(setup, &setup.world_from_board(), ACTION_STEPS).map_or(Vec::new(), |script| script.actions)
}
