//! The registered tasks, by name.

pub(crate) mod door;
mod draws;
pub(crate) mod painting;
pub(crate) mod triangle;

use reseflow_data::Task;

use crate::camera::CameraSettings;
use crate::error::SimError;
use crate::world::settings::PhysicsSettings;
use door::DoorTask;
use painting::PaintingTask;
use triangle::{TriangleGoal, TriangleTask};

/// The names of all tasks.
pub fn tasks() -> &'static [&'static str] {
    const {
        &[
            door::NAME,
            painting::NAME,
            TriangleGoal::Quarter.task_name(),
            TriangleGoal::Sixth.task_name(),
            TriangleGoal::Third.task_name(),
            TriangleGoal::CoinToss.task_name(),
        ]
    }
}

/// The task with its default settings; `None` where no task has that name.
pub fn task(name: &str) -> Option<Box<dyn Task>> {
    configured_task(name, PhysicsSettings::default(), CameraSettings::default()).ok()
}

/// The task in a given world under a given camera.
///
/// # Errors
/// [`SimError::UnknownTask`] where no task has that name, [`SimError::Setting`] where a setting is out of its range.
pub fn configured_task(
    name: &str,
    physics: PhysicsSettings,
    camera: CameraSettings,
) -> Result<Box<dyn Task>, SimError> {
    physics.validate()?;
    camera.validate()?;
    if name == door::NAME {
        return Ok(Box::new(DoorTask { physics, camera }));
    }
    if name == painting::NAME {
        return Ok(Box::new(PaintingTask { physics, camera }));
    }
    let goal = TriangleGoal::ALL.into_iter().find(|goal| goal.task_name() == name);
    let goal = goal.ok_or_else(|| SimError::UnknownTask { name: name.to_owned() })?;
    Ok(Box::new(TriangleTask { goal, physics, camera }))
}
