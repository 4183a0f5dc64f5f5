//! The smallest real scene: a gripper that follows its command exactly and is to end at a goal.

use std::cell::RefCell;
use std::rc::Rc;

use reseflow_data::{
    Action, ActionChunk, Contact, Halt, Observation, ObservationHistory, Outcome, Plan, PointCloud, Policy,
    PolicyError, Scene, SceneBody, Shape, TaskSpec, Tick,
};
use reseflow_lie::{BodyTwist, SE3, SO3, Vector3};

pub(crate) const TICK_NANOS: i64 = 50_000_000;

pub(crate) fn spec(action_steps: usize, ticks_per_action: usize) -> TaskSpec {
    TaskSpec {
        name: "point".into(),
        description: "Bring the gripper to the goal.".into(),
        points: 2,
        action_steps,
        ticks_per_action,
        tick_nanos: TICK_NANOS,
        disturb_before: action_steps,
    }
}

/// What happened, in order; shared by scene, policy and test.
pub(crate) type Diary = Rc<RefCell<Vec<String>>>;

pub(crate) struct PointScene {
    pub(crate) state: Action,
    pub(crate) goal: Action,
    pub(crate) ticks: i64,
    pub(crate) commands: Vec<Action>,
    /// The scene gives up at this tick, if at any.
    pub(crate) object_lost_at: Option<i64>,
    pub(crate) diary: Diary,
}

impl PointScene {
    pub(crate) fn new(diary: &Diary) -> Self {
        let start = SE3::new(SO3::exp(&Vector3::new(0.2, 0.0, 0.1)), Vector3::new(0.3, -0.1, 0.2));
        let goal = start.plus(&BodyTwist::new(Vector3::new(0.0, 0.4, 1.0), Vector3::new(0.2, 0.1, -0.1)));
        Self {
            state: Action { world_from_gripper: start, opening: 0.25 },
            goal: Action { world_from_gripper: goal, opening: 1.0 },
            ticks: 0,
            commands: Vec::new(),
            object_lost_at: None,
            diary: diary.clone(),
        }
    }

    fn distance_m(&self) -> f64 {
        (self.state.world_from_gripper.translation - self.goal.world_from_gripper.translation).norm()
    }

    fn note(&self, event: String) {
        self.diary.borrow_mut().push(event);
    }
}

impl Scene for PointScene {
    fn observe(&mut self) -> Observation {
        let point = |pose: &SE3| std::array::from_fn(|i| pose.translation[i] as f32);
        Observation {
            cloud: PointCloud {
                points: vec![point(&self.state.world_from_gripper), point(&self.goal.world_from_gripper)],
                colors: vec![[255, 0, 0], [0, 128, 64]],
            },
            world_from_gripper: self.state.world_from_gripper,
            gripper_opening: self.state.opening,
        }
    }

    fn tick(&mut self, command: &Action) -> Result<Tick, Halt> {
        if self.object_lost_at == Some(self.ticks) {
            return Err(Halt::ObjectLost);
        }
        self.ticks += 1;
        self.state = *command;
        self.commands.push(*command);
        let contact = Contact {
            body_a: "finger".into(),
            body_b: "handle".into(),
            point_m: [0.1, 0.2, 0.3],
            force_n: 4.0,
            depth_m: 0.0005,
        };
        Ok(Tick {
            time_nanos: self.ticks * TICK_NANOS,
            command: *command,
            world_from_gripper: command.world_from_gripper,
            gripper_opening: command.opening,
            contacts: if self.ticks % 2 == 0 { vec![contact] } else { Vec::new() },
            measure: self.distance_m(),
        })
    }

    fn bodies(&self) -> Vec<SceneBody> {
        let body = |name: &str, shape: Shape, color, pose: &SE3| SceneBody {
            name: name.into(),
            shape,
            color,
            world_from_body: *pose,
        };
        let mesh = Shape::Mesh {
            vertices_m: vec![[0.0; 3], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]],
            triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        };
        let table = Shape::Box { half_extents_m: [0.5, 0.4, 0.01] };
        vec![
            body("table", table, [200, 180, 160], &SE3::identity()),
            body("gripper", mesh, [51, 102, 255], &self.state.world_from_gripper),
        ]
    }

    fn judge(&mut self) -> Outcome {
        self.note("judge".into());
        let measure = self.distance_m();
        Outcome { success: measure < 1e-9, measure, measure_name: "distance_m".into(), halt: None }
    }

    fn expert(&self) -> Box<dyn Policy> {
        Box::new(WaypointPolicy::towards(self, 10, &self.diary))
    }

    fn disturb(&mut self, seed: u64) {
        self.note(format!("disturb {seed}"));
        self.state.world_from_gripper.translation.z += 0.5;
    }
}

/// Knows all T waypoints and plans the next `horizon` of them.
pub(crate) struct WaypointPolicy {
    pub(crate) waypoints: Vec<Action>,
    pub(crate) horizon: usize,
    pub(crate) uncertainty: Option<Vec<f64>>,
    pub(crate) diary: Diary,
}

impl WaypointPolicy {
    pub(crate) fn towards(scene: &PointScene, steps: usize, diary: &Diary) -> Self {
        let waypoint = |step: usize| scene.state.interpolate(&scene.goal, (step + 1) as f64 / steps as f64);
        Self {
            waypoints: (0..steps).map(waypoint).collect(),
            horizon: steps,
            uncertainty: None,
            diary: diary.clone(),
        }
    }
}

impl Policy for WaypointPolicy {
    fn name(&self) -> &str {
        "waypoints"
    }

    fn reset(&mut self, seed: u64) {
        self.diary.borrow_mut().push(format!("reset {seed}"));
    }

    fn plan(&mut self, history: &ObservationHistory) -> Result<Plan, PolicyError> {
        let step = history.elapsed_steps();
        self.diary.borrow_mut().push(format!("plan {step} from {} frames", history.frames().len()));
        let next = self.waypoints.iter().skip(step).take(self.horizon).copied().collect();
        Ok(Plan { actions: ActionChunk(next), uncertainty: self.uncertainty.clone() })
    }
}
