//! One running episode: the scene trait and what a scene reports.

use reseflow_lie::SE3;
use serde::{Deserialize, Serialize};

use crate::{Action, Observation, Policy};

/// Why an episode ended before its last step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, thiserror::Error)]
#[serde(rename_all = "snake_case")]
pub enum Halt {
    /// The command holds a NaN or an infinity.
    #[error("the action is not finite")]
    NonFiniteAction,
    /// The command lies outside the workspace.
    #[error("the action is out of reach")]
    OutOfReach,
    /// The gripper starts inside something.
    #[error("the gripper starts inside an object")]
    StartsInCollision,
    /// The gripper was pushed too far from its command to follow it.
    #[error("the gripper lost its command")]
    LostTracking,
    /// The object left the table.
    #[error("the object left the table")]
    ObjectLost,
    /// The physics engine returned a value that is not finite.
    #[error("the simulation diverged")]
    Diverged,
}

/// A touch between two bodies in the last physics step of a control tick; what parts before the tick ends is not reported.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Contact {
    /// The first body's name.
    pub body_a: String,
    /// The second body's name.
    pub body_b: String,
    /// Where, world frame, metres.
    pub point_m: [f64; 3],
    /// Normal force, newtons.
    pub force_n: f64,
    /// Penetration depth, metres, 0 where the bodies only touch.
    pub depth_m: f64,
}

/// What is true at the end of one control tick.
#[derive(Debug, Clone)]
pub struct Tick {
    /// Time since the episode's start, nanoseconds.
    pub time_nanos: i64,
    /// The command in force.
    pub command: Action,
    /// The gripper's reached pose.
    pub world_from_gripper: SE3,
    /// The gripper's reached opening.
    pub gripper_opening: f64,
    /// What touches what at that moment.
    pub contacts: Vec<Contact>,
    /// The task's success measure so far (what `Outcome::measure` will hold).
    pub measure: f64,
}

/// A rigid shape for drawing.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// A box, centred at its origin.
    Box {
        /// Half of each edge, metres.
        half_extents_m: [f64; 3],
    },
    /// A triangle mesh.
    Mesh {
        /// Vertices in the body's frame, metres.
        vertices_m: Vec<[f64; 3]>,
        /// Vertex indices, counter-clockwise seen from outside.
        triangles: Vec<[u32; 3]>,
    },
}

/// A body as it stands now, for drawing and for logs.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneBody {
    /// A name that is unique in the scene.
    pub name: String,
    /// Its shape.
    pub shape: Shape,
    /// Its colour, sRGB.
    pub color: [u8; 3],
    /// Where it is.
    pub world_from_body: SE3,
}

/// How an episode ended.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Whether the task's success criterion holds.
    pub success: bool,
    /// The number that the criterion is about.
    pub measure: f64,
    /// What `measure` is, with its unit, for example `turned_rad`.
    pub measure_name: String,
    /// The reason, where the episode was ended early.
    pub halt: Option<Halt>,
}

/// One running episode.
pub trait Scene {
    /// What the camera and the gripper's sensors say now.
    ///
    /// Observing changes nothing that a later tick or observation depends on, so that logs may observe as often as they like.
    fn observe(&mut self) -> Observation;

    /// Follows `command` for one control tick.
    ///
    /// # Errors
    /// A named reason why the episode cannot go on; the scene stays as it was at the last good tick.
    fn tick(&mut self, command: &Action) -> Result<Tick, Halt>;

    /// Everything that can be drawn, as it stands now.
    fn bodies(&self) -> Vec<SceneBody>;

    /// Lets the gripper be still for 0.5 s and judges.
    fn judge(&mut self) -> Outcome;

    /// The scripted expert for this very scene, with the knowledge of its state that no camera gives.
    fn expert(&self) -> Box<dyn Policy>;

    /// The commanded poses, one per action step, of another expert that is as good as [`Scene::expert`], where the task
    /// leaves a choice that no observation shows. The openings are the same.
    fn alternative(&self) -> Option<Vec<SE3>> {
        None
    }

    /// Disturbs the scene by a push, for tests of recovery: the object, or the gripper, is where no plan had it.
    fn disturb(&mut self, seed: u64);
}
