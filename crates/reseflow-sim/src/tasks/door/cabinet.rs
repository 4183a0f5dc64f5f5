//! The cabinet and its door: walls, panel, hinge strip, handle bar, and where each lies.

use nalgebra::Vector3;
use rapier3d::prelude::{CoefficientCombineRule, Collider, ColliderBuilder, RigidBodyBuilder};
use reseflow_data::Shape;
use reseflow_lie::{SE3, SO3};

use super::setup::DoorSetup;
use crate::convert::vec3;
use crate::world::hinge::Hinge;
use crate::world::{Object, World};

const WALL_M: f64 = 0.008;
/// Between the cabinet's front and the door.
const GAP_M: f64 = 0.002;
const DOOR_THICKNESS_M: f64 = 0.012;
/// The share of the door's width that the dark strip along the hinge covers.
const STRIP_SHARE: f64 = 0.14;
/// From the door's free edge to the middle of the handle bar.
const HANDLE_INSET_M: f64 = 0.03;
/// From the door's face to the middle of the handle bar.
const HANDLE_STANDOFF_M: f64 = 0.042;
/// Half of each edge of the handle bar.
const BAR_HALF_M: [f64; 3] = [0.007, 0.007, 0.042];
/// Half of the edge of the posts that hold the bar.
const POST_HALF_M: f64 = 0.004;
const DENSITY_KG_M3: f32 = 600.0;
const FRICTION: f32 = 0.4;
/// The hinge's dry friction, newton metres: about a newton at the handle.
const HINGE_FRICTION_NM: f64 = 0.2;
/// Where the open door stops.
const OPEN_STOP_RAD: f64 = 1.92;

/// A box: its middle in its body's frame and half of each edge, metres.
struct Block {
    center_m: Vector3<f64>,
    half_m: Vector3<f64>,
}

impl Block {
    fn new(center_m: [f64; 3], half_m: [f64; 3]) -> Block {
        Block { center_m: center_m.into(), half_m: half_m.into() }
    }

    fn collider(&self) -> Collider {
        let half = vec3(&self.half_m);
        ColliderBuilder::cuboid(half.x, half.y, half.z)
            .translation(vec3(&self.center_m))
            .density(DENSITY_KG_M3)
            .friction(FRICTION)
            .friction_combine_rule(CoefficientCombineRule::Max)
            .build()
    }

    fn draw(&self, world: &mut World, name: &str, object: Object, color: [u8; 3]) {
        let shape = Shape::Box { half_extents_m: self.half_m.into() };
        world.add_object_part_at(name, object, self.center_m, shape, color);
    }
}

/// The pose of the door's frame in the cabinet's when the door is open by `angle_rad`.
///
/// The door's frame stands where the hinge's axis meets the table and has the cabinet's axes when the door is closed.
pub(super) fn cabinet_from_door(setup: &DoorSetup, angle_rad: f64) -> SE3 {
    let [width, _, depth] = setup.size_m;
    let side = setup.hinge.sign();
    SE3::new(
        SO3::exp(&(Vector3::z() * (side * angle_rad))),
        Vector3::new(0.5 * depth + GAP_M, 0.5 * side * width, 0.0),
    )
}

/// The middle of the handle bar in the door's frame, metres.
pub(super) fn handle_in_door(setup: &DoorSetup) -> Vector3<f64> {
    let across = setup.size_m[0] - HANDLE_INSET_M;
    Vector3::new(DOOR_THICKNESS_M + HANDLE_STANDOFF_M, -setup.hinge.sign() * across, setup.handle_height_m)
}

/// Puts the cabinet and its closed door on the table; returns the door.
pub(super) fn insert(world: &mut World, setup: &DoorSetup) -> Object {
    let world_from_cabinet = setup.world_from_cabinet();
    let walls = walls(setup.size_m);
    let colliders = walls.iter().map(|(_, wall)| wall.collider()).collect();
    let cabinet = world.add_object("cabinet", &world_from_cabinet, RigidBodyBuilder::fixed(), colliders);
    for (name, wall) in &walls {
        wall.draw(world, name, cabinet, setup.cabinet_color);
    }

    let pieces = door_pieces(setup);
    let colliders = pieces.iter().map(|(_, piece, _)| piece.collider()).collect();
    let world_from_door = world_from_cabinet * cabinet_from_door(setup, 0.0);
    let body = RigidBodyBuilder::dynamic().can_sleep(false);
    let door = world.add_object("door", &world_from_door, body, colliders);
    for (name, piece, color) in &pieces {
        piece.draw(world, name, door, *color);
    }
    let hinge = Hinge {
        axis: Vector3::z() * setup.hinge.sign(),
        anchor_m: cabinet_from_door(setup, 0.0).translation,
        hung_anchor_m: Vector3::zeros(),
        limits_rad: [0.0, OPEN_STOP_RAD],
        friction_nm: HINGE_FRICTION_NM,
    };
    world.add_hinge(cabinet, door, &hinge);
    door
}

/// The cabinet's five walls, in its frame; the front is open.
fn walls([width, height, depth]: [f64; 3]) -> [(&'static str, Block); 5] {
    let (y, z, x) = (0.5 * width, 0.5 * height, 0.5 * depth);
    let wall = 0.5 * WALL_M;
    [
        ("cabinet_back", Block::new([wall - x, 0.0, z], [wall, y, z])),
        ("cabinet_left", Block::new([0.0, wall - y, z], [x, wall, z])),
        ("cabinet_right", Block::new([0.0, y - wall, z], [x, wall, z])),
        ("cabinet_floor", Block::new([0.0, 0.0, wall], [x, y, wall])),
        ("cabinet_top", Block::new([0.0, 0.0, height - wall], [x, y, wall])),
    ]
}

/// The door's pieces in its frame, with their colours.
fn door_pieces(setup: &DoorSetup) -> [(&'static str, Block, [u8; 3]); 5] {
    let [width, height, _] = setup.size_m;
    let away = -setup.hinge.sign();
    let (thick, z) = (0.5 * DOOR_THICKNESS_M, 0.5 * height);
    let strip = STRIP_SHARE * width;
    // A millimetre over the table, so that the door does not rub on it.
    let half_height = z - 0.001;
    let bar = handle_in_door(setup);
    let post_x = DOOR_THICKNESS_M + 0.5 * (HANDLE_STANDOFF_M - BAR_HALF_M[0]);
    let post = |end: f64| {
        let z = bar.z + end * (BAR_HALF_M[2] - POST_HALF_M);
        let half = [0.5 * (HANDLE_STANDOFF_M - BAR_HALF_M[0]), POST_HALF_M, POST_HALF_M];
        Block::new([post_x, bar.y, z], half)
    };
    [
        (
            "door_panel",
            Block::new([thick, away * 0.5 * (strip + width), z], [thick, 0.5 * (width - strip), half_height]),
            setup.door_color,
        ),
        (
            "door_hinge",
            Block::new([thick, away * 0.5 * strip, z], [thick, 0.5 * strip, half_height]),
            setup.hinge_color,
        ),
        ("door_handle", Block { center_m: bar, half_m: BAR_HALF_M.into() }, setup.handle_color),
        ("door_handle_upper_post", post(1.0), setup.handle_color),
        ("door_handle_lower_post", post(-1.0), setup.handle_color),
    ]
}
