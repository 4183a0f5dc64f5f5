//! The registered tasks, by name.

pub(crate) mod door;
mod draws;
pub(crate) mod triangle;

use reseflow_data::Task;

use crate::camera::CameraSettings;
use crate::world::settings::PhysicsSettings;
use door::DoorTask;
use triangle::TriangleTask;

/// The names of all tasks.
pub fn tasks() -> &'static [&'static str] {
    &[door::NAME, triangle::NAME]
}

/// The task with its default settings; `None` where no task has that name.
pub fn task(name: &str) -> Option<Box<dyn Task>> {
    configured_task(name, PhysicsSettings::default(), CameraSettings::default())
}

/// The task in a given world under a given camera; `None` where no task has that name.
pub fn configured_task(
    name: &str,
    physics: PhysicsSettings,
    camera: CameraSettings,
) -> Option<Box<dyn Task>> {
    match name {
        door::NAME => Some(Box::new(DoorTask { physics, camera })),
        triangle::NAME => Some(Box::new(TriangleTask { physics, camera })),
        _ => None,
    }
}
