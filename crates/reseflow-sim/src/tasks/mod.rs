//! The registered tasks, by name.

pub(crate) mod triangle;

use reseflow_data::Task;

use triangle::TriangleTask;

/// The names of all tasks.
pub fn tasks() -> &'static [&'static str] {
    &[triangle::NAME]
}

/// The task with its default settings; `None` where no task has that name.
pub fn task(name: &str) -> Option<Box<dyn Task>> {
    match name {
        triangle::NAME => Some(Box::new(TriangleTask::default())),
        _ => None,
    }
}
