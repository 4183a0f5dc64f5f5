//! A deterministic tabletop simulator on rapier: gripper, depth camera, scripted experts and tasks.
//!
//! A world holds the table, a two-finger gripper on a force-limited carriage, and what a task puts on the
//! table; contacts are the only thing that moves an object. The camera casts rays, hidden surfaces stay hidden. The
//! same [`reseflow_data::EpisodeKey`] gives the same bytes, whatever the number of threads.
//!
//! # The gripper's frame
//!
//! The origin lies midway between the two pads, 8 mm before the finger tips; z is the approach direction, out of the palm; y is the
//! direction in which the fingers close; x = y × z lies along the pads. Opening 1 is [`gripper::MAX_GAP_M`] between the
//! pads, opening 0 closes them with the grip force.
//!
//! # Adding a task
//!
//! A module under `tasks` with a setup (everything random, drawn from the key), a scene (a tabletop with a
//! measure) and an expert (a script for the scene as it stands), and one line in the registry.

mod camera;
mod color;
mod convert;
mod disturbed;
mod error;
mod expert;
mod generate;
mod mesh;
mod render;
mod scripted;
mod tabletop;
mod tasks;
mod world;

pub use camera::{Camera, CameraSettings, Selection, is_salient};
pub use disturbed::disturbance_seed;
pub use error::SimError;
pub use generate::{GenerateRequest, Generated, generate};
pub use render::{RgbPicture, overview_camera, render};
pub use scripted::{Scripted, Still};
pub use tasks::door::{DoorSetup, DoorTask, HingeSide};
pub use tasks::painting::{PaintingSetup, PaintingTask, Stroke};
pub use tasks::triangle::{TriangleGoal, TriangleSetup, TriangleTask};
pub use tasks::{configured_task, task, tasks};
pub use world::gripper;
pub use world::settings::PhysicsSettings;
