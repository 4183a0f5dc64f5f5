//! What the scenes of all tasks share: a world, a camera, the clock, and the rules for ending.

use reseflow_data::{Action, EpisodeKey, Halt, Observation, SceneBody, TaskSpec, Tick};

use crate::camera::{self, Camera, CameraSettings};
use crate::world::World;
use crate::world::settings::TICK_NANOS;

/// Control ticks that the gripper is still before an episode is judged: 0.5 s.
const STILL_TICKS: usize = 10;

/// The control ticks of every task's action step: half a second.
const TICKS_PER_ACTION: usize = 10;
/// Action steps T of every task.
pub(crate) const ACTION_STEPS: usize = 10;

/// The specification that all tasks share.
pub(crate) fn spec(name: &str, description: &str, points: usize, disturb_before: usize) -> TaskSpec {
    TaskSpec {
        name: name.to_owned(),
        description: description.to_owned(),
        points,
        action_steps: ACTION_STEPS,
        ticks_per_action: TICKS_PER_ACTION,
        tick_nanos: TICK_NANOS,
        disturb_before,
    }
}

/// A world under a camera, and how long it has been running.
pub(crate) struct Tabletop {
    pub(crate) world: World,
    camera: Camera,
    camera_settings: CameraSettings,
    key: EpisodeKey,
    points: usize,
    ticks: i64,
    halt: Option<Halt>,
}

impl Tabletop {
    pub(crate) fn new(
        mut world: World,
        camera: Camera,
        camera_settings: CameraSettings,
        key: EpisodeKey,
        points: usize,
    ) -> Tabletop {
        world.finish_setup();
        Tabletop { world, camera, camera_settings, key, points, ticks: 0, halt: None }
    }

    /// What camera and gripper say now: a function of the episode's key, the clock and the state, so that looking
    /// twice, or more often, changes nothing.
    pub(crate) fn observe(&self) -> Observation {
        let mut rng = self.key.rng(&format!("camera noise at tick {}", self.ticks));
        Observation {
            cloud: camera::observe(&self.camera, &self.camera_settings, &self.world, self.points, &mut rng),
            world_from_gripper: self.world.world_from_gripper(),
            gripper_opening: self.world.opening(),
        }
    }

    /// Follows `command` for one control tick.
    ///
    /// # Errors
    /// The reason why the episode cannot go on, and the same again ever after.
    pub(crate) fn tick(&mut self, command: &Action, measure: impl Fn(&World) -> f64) -> Result<Tick, Halt> {
        if let Some(reason) = self.halt {
            return Err(reason);
        }
        if let Err(reason) = self.world.tick(command) {
            self.halt = Some(reason);
            return Err(reason);
        }
        self.ticks += 1;
        Ok(Tick {
            time_nanos: self.ticks * TICK_NANOS,
            command: *command,
            world_from_gripper: self.world.world_from_gripper(),
            gripper_opening: self.world.opening(),
            contacts: self.world.contacts(),
            measure: measure(&self.world),
        })
    }

    /// Holds the last command for 0.5 s; returns why the episode ended early, if it did.
    pub(crate) fn hold_still(&mut self) -> Option<Halt> {
        let command = self.world.command();
        for _ in 0..STILL_TICKS {
            if self.tick(&command, |_| 0.0).is_err() {
                break;
            }
        }
        self.halt
    }

    pub(crate) fn bodies(&self) -> Vec<SceneBody> {
        self.world.bodies()
    }
}
