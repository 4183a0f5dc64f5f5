//! Experts that watch their scene: a script for the scene as it stands, and a new one where the scene is not as the script has it.
//!
//! Undisturbed, an expert that plans again goes on with the script it began with, so that planning once and planning at
//! every action step give the same commands.

use std::cell::Cell;
use std::rc::Rc;

use reseflow_data::{Action, ActionChunk, ObservationHistory, Plan, Policy, PolicyError};
use reseflow_lie::SE3;

use crate::tabletop::ACTION_STEPS;

/// What an expert knows of its scene beyond what is observed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Glance {
    /// Where the object was when the task began, or when a shove had moved the task elsewhere.
    pub(crate) start: SE3,
    /// Where it is now.
    pub(crate) object: SE3,
}

/// The newest glance: the scene writes it, its experts read it.
#[derive(Debug, Clone)]
pub(crate) struct Watch(Rc<Cell<Glance>>);

impl Watch {
    /// An object that is where it starts.
    pub(crate) fn new(start: SE3) -> Watch {
        Watch(Rc::new(Cell::new(Glance { start, object: start })))
    }

    /// To be called after each tick.
    pub(crate) fn set(&self, glance: Glance) {
        self.0.set(glance);
    }

    pub(crate) fn get(&self) -> Glance {
        self.0.get()
    }
}

/// What an expert means to do.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Script {
    /// One command per action step.
    pub(crate) actions: Vec<Action>,
    /// Where the object is before each of them, if all goes well.
    pub(crate) objects: Vec<SE3>,
    /// The first of the steps before which the fingers hold the object; the number of steps where they never do.
    pub(crate) held_from: usize,
}

/// What counts as being on course.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Tolerance {
    /// The object may be so far from where the script has it.
    pub(crate) off_m: f64,
    pub(crate) off_rad: f64,
    /// Fingers that hold the object are open by at least this.
    pub(crate) held_opening: f64,
}

/// An expert that writes its scripts with `W`: from what it knows, the gripper's pose and the action steps that are left;
/// `None` where these are too few to begin anew.
pub(crate) struct Expert<W> {
    watch: Watch,
    write: W,
    tolerance: Tolerance,
    script: Option<Script>,
    /// The action step at which the script began.
    begun: usize,
}

impl<W: Fn(&Glance, &SE3, usize) -> Option<Script>> Expert<W> {
    pub(crate) fn new(watch: Watch, tolerance: Tolerance, write: W) -> Self {
        Self { watch, write, tolerance, script: None, begun: 0 }
    }

    /// Whether the scene is as the script has it before its step `step`.
    fn is_on_course(&self, script: &Script, step: usize, opening: f64) -> bool {
        let Some(expected) = script.objects.get(step.min(script.objects.len().saturating_sub(1))) else {
            return true;
        };
        let off = expected.product_displacement_to(&self.watch.get().object);
        let is_held = step < script.held_from || opening >= self.tolerance.held_opening;
        off.linear.norm() <= self.tolerance.off_m && off.angular.norm() <= self.tolerance.off_rad && is_held
    }
}

impl<W: Fn(&Glance, &SE3, usize) -> Option<Script>> Policy for Expert<W> {
    fn name(&self) -> &str {
        "expert"
    }

    fn reset(&mut self, _seed: u64) {
        self.script = None;
    }

    fn plan(&mut self, history: &ObservationHistory) -> Result<Plan, PolicyError> {
        let now = history.latest();
        let elapsed = history.elapsed_steps();
        let on_course = self.script.as_ref().is_some_and(|script| {
            self.is_on_course(script, elapsed.saturating_sub(self.begun), now.gripper_opening)
        });
        if !on_course {
            let steps = ACTION_STEPS.saturating_sub(elapsed);
            if let Some(script) = (self.write)(&self.watch.get(), &now.world_from_gripper, steps) {
                (self.script, self.begun) = (Some(script), elapsed);
            }
        }
        let script = self.script.as_ref().map_or(&[][..], |script| &script.actions);
        let rest = script.get(elapsed.saturating_sub(self.begun)..).unwrap_or_default();
        match (rest, script.last()) {
            ([], Some(last)) => Ok(plan(vec![*last])),
            ([], None) => {
                Err(PolicyError { policy: "expert".to_owned(), reason: "it has no script".to_owned() })
            }
            (rest, _) => Ok(plan(rest.to_vec())),
        }
    }
}

fn plan(actions: Vec<Action>) -> Plan {
    Plan { actions: ActionChunk(actions), uncertainty: None }
}
