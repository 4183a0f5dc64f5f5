//! Our values as Foxglove's messages. All coordinates are in the frame `world`.

use foxglove::messages as fox;
use foxglove::messages::packed_element_field::NumericType;
use foxglove::messages::scene_entity_deletion::Type as Deletion;
use reseflow_lie::SE3;

use crate::{Contact, PointCloud, SceneBody, Shape};

const WORLD: &str = "world";

/// Bytes per point: three `float32` and four `uint8`.
const POINT_STRIDE: u32 = 16;

/// The radius of the ball that marks a contact, metres, and its growth per newton.
const CONTACT_RADIUS_M: f64 = 0.003;
const CONTACT_RADIUS_PER_NEWTON_M: f64 = 0.0001;
const CONTACT_RADIUS_MAX_M: f64 = 0.01;

fn timestamp(nanos: i64) -> fox::Timestamp {
    let seconds = u32::try_from(nanos.div_euclid(1_000_000_000)).unwrap_or(u32::MAX);
    fox::Timestamp::new(seconds, nanos.rem_euclid(1_000_000_000) as u32)
}

pub(super) fn point_cloud(time_nanos: i64, cloud: &PointCloud) -> fox::PointCloud {
    let field = |name: &str, offset: u32, number: NumericType| fox::PackedElementField {
        name: name.to_owned(),
        offset,
        r#type: number as i32,
    };
    let mut data = Vec::with_capacity(cloud.len() * POINT_STRIDE as usize);
    for (point, color) in cloud.points.iter().zip(&cloud.colors) {
        point.iter().for_each(|coordinate| data.extend_from_slice(&coordinate.to_le_bytes()));
        data.extend_from_slice(color);
        data.push(255);
    }
    fox::PointCloud {
        timestamp: Some(timestamp(time_nanos)),
        frame_id: WORLD.to_owned(),
        pose: Some(pose(&SE3::identity())),
        point_stride: POINT_STRIDE,
        fields: vec![
            field("x", 0, NumericType::Float32),
            field("y", 4, NumericType::Float32),
            field("z", 8, NumericType::Float32),
            field("red", 12, NumericType::Uint8),
            field("green", 13, NumericType::Uint8),
            field("blue", 14, NumericType::Uint8),
            field("alpha", 15, NumericType::Uint8),
        ],
        data: data.into(),
    }
}

/// The transform `world_from_child`.
pub(super) fn transform(time_nanos: i64, child: &str, world_from_child: &SE3) -> fox::FrameTransform {
    fox::FrameTransform {
        timestamp: Some(timestamp(time_nanos)),
        parent_frame_id: WORLD.to_owned(),
        child_frame_id: child.to_owned(),
        translation: Some(position(world_from_child)),
        rotation: Some(orientation(world_from_child)),
    }
}

pub(super) fn poses<'a>(time_nanos: i64, poses: impl Iterator<Item = &'a SE3>) -> fox::PosesInFrame {
    fox::PosesInFrame {
        timestamp: Some(timestamp(time_nanos)),
        frame_id: WORLD.to_owned(),
        poses: poses.map(pose).collect(),
    }
}

/// Every body, in place of all that were drawn before.
pub(super) fn bodies(time_nanos: i64, bodies: &[SceneBody]) -> fox::SceneUpdate {
    let entity = |body: &SceneBody| {
        let (pose, color) = (Some(pose(&body.world_from_body)), Some(color(body.color, 1.0)));
        let mut entity = entity(time_nanos, &body.name);
        match &body.shape {
            Shape::Box { half_extents_m } => {
                let size = Some(vector(half_extents_m.map(|half| 2.0 * half)));
                entity.cubes.push(fox::CubePrimitive { pose, size, color });
            }
            Shape::Mesh { vertices_m, triangles } => entity.triangles.push(fox::TriangleListPrimitive {
                pose,
                points: vertices_m.iter().map(|&[x, y, z]| fox::Point3 { x, y, z }).collect(),
                color,
                colors: Vec::new(),
                indices: triangles.as_flattened().to_vec(),
            }),
        }
        entity
    };
    scene_update(time_nanos, bodies.iter().map(entity).collect())
}

/// A ball at each contact, in place of all that were drawn before; the harder the touch, the larger.
pub(super) fn contacts(time_nanos: i64, contacts: &[Contact]) -> fox::SceneUpdate {
    let entity = |(index, contact): (usize, &Contact)| {
        let radius = CONTACT_RADIUS_M + CONTACT_RADIUS_PER_NEWTON_M * contact.force_n;
        let size = Some(vector([2.0 * radius.min(CONTACT_RADIUS_MAX_M); 3]));
        let orientation = Some(orientation(&SE3::identity()));
        let pose = Some(fox::Pose { position: Some(vector(contact.point_m)), orientation });
        let mut entity = entity(time_nanos, &format!("contact {index}"));
        entity.spheres.push(fox::SpherePrimitive { pose, size, color: Some(color([255, 60, 30], 0.9)) });
        let pair = |key: &str, value: String| fox::KeyValuePair { key: key.to_owned(), value };
        entity.metadata = vec![
            pair("body_a", contact.body_a.clone()),
            pair("body_b", contact.body_b.clone()),
            pair("force_n", contact.force_n.to_string()),
            pair("depth_m", contact.depth_m.to_string()),
        ];
        entity
    };
    scene_update(time_nanos, contacts.iter().enumerate().map(entity).collect())
}

/// An update that stands for itself: what earlier ones drew is deleted, so that a viewer may jump to any time.
fn scene_update(time_nanos: i64, entities: Vec<fox::SceneEntity>) -> fox::SceneUpdate {
    let everything = fox::SceneEntityDeletion {
        timestamp: Some(timestamp(time_nanos)),
        r#type: Deletion::All as i32,
        id: String::new(),
    };
    fox::SceneUpdate { deletions: vec![everything], entities }
}

fn entity(time_nanos: i64, id: &str) -> fox::SceneEntity {
    fox::SceneEntity {
        timestamp: Some(timestamp(time_nanos)),
        frame_id: WORLD.to_owned(),
        id: id.to_owned(),
        ..fox::SceneEntity::default()
    }
}

fn pose(target_from_source: &SE3) -> fox::Pose {
    fox::Pose {
        position: Some(position(target_from_source)),
        orientation: Some(orientation(target_from_source)),
    }
}

fn position(pose: &SE3) -> fox::Vector3 {
    vector(pose.translation.into())
}

fn orientation(pose: &SE3) -> fox::Quaternion {
    let [x, y, z, w] = pose.rotation.quaternion_xyzw();
    fox::Quaternion { x, y, z, w }
}

fn vector([x, y, z]: [f64; 3]) -> fox::Vector3 {
    fox::Vector3 { x, y, z }
}

fn color(srgb: [u8; 3], alpha: f64) -> fox::Color {
    let [r, g, b] = srgb.map(|channel| f64::from(channel) / 255.0);
    fox::Color { r, g, b, a: alpha }
}
