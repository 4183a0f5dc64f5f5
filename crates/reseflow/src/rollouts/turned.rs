//! The `turned` split: the test episodes with the whole world moved, gravity included.
//!
//! A scene whose every pose is g ∘ (pose of the test scene) obeys the same physics as the test scene under g-turned gravity. So the
//! test scene runs as it is, and everything that goes in or out of it is moved: observations, ticks and bodies by g, commands by
//! g⁻¹. Episode by episode it is paired with the test split.

use rand::RngExt;
use reseflow_data::{
    Action, Contact, EpisodeKey, Halt, Observation, ObservationHistory, Outcome, Plan, Policy, PolicyError,
    Scene, SceneBody, Task, TaskError, TaskSpec, Tick,
};
use reseflow_lie::{SE3, SO3, Vector3};

/// Moves go up to so far along each axis, metres.
const MAX_SHIFT_M: f64 = 0.5;

/// A task with each scene moved by a random rigid motion of its own.
pub struct TurnedTask(pub Box<dyn Task>);

struct TurnedScene {
    scene: Box<dyn Scene>,
    motion: SE3,
}

struct TurnedPolicy {
    policy: Box<dyn Policy>,
    motion: SE3,
}

/// The motion of the episode that `key` names: uniform on SO(3), and a shift.
pub(crate) fn motion_of(key: &EpisodeKey) -> SE3 {
    let mut rng = key.rng("turned");
    let rotation = SO3::sample_haar(&mut rng);
    let shift = Vector3::from_fn(|_, _| rng.random_range(-MAX_SHIFT_M..MAX_SHIFT_M));
    SE3::new(rotation, shift)
}

fn move_point(motion: &SE3, point: [f64; 3]) -> [f64; 3] {
    motion.act(&Vector3::from(point)).into()
}

/// The command in the moved world.
pub(crate) fn move_action(motion: &SE3, action: &Action) -> Action {
    Action { world_from_gripper: *motion * action.world_from_gripper, opening: action.opening }
}

/// The observation in the moved world.
pub(crate) fn move_observation(motion: &SE3, mut observation: Observation) -> Observation {
    for point in &mut observation.cloud.points {
        *point = move_point(motion, point.map(f64::from)).map(|coordinate| coordinate as f32);
    }
    observation.world_from_gripper = *motion * observation.world_from_gripper;
    observation
}

impl Task for TurnedTask {
    fn spec(&self) -> TaskSpec {
        self.0.spec()
    }

    fn reset(&self, key: &EpisodeKey) -> Result<Box<dyn Scene>, TaskError> {
        Ok(Box::new(TurnedScene { scene: self.0.reset(key)?, motion: motion_of(key) }))
    }
}

impl Scene for TurnedScene {
    fn observe(&mut self) -> Observation {
        move_observation(&self.motion, self.scene.observe())
    }

    fn tick(&mut self, command: &Action) -> Result<Tick, Halt> {
        let tick = self.scene.tick(&move_action(&self.motion.inverse(), command))?;
        let contact =
            |contact: Contact| Contact { point_m: move_point(&self.motion, contact.point_m), ..contact };
        Ok(Tick {
            command: *command,
            world_from_gripper: self.motion * tick.world_from_gripper,
            contacts: tick.contacts.into_iter().map(contact).collect(),
            ..tick
        })
    }

    fn bodies(&self) -> Vec<SceneBody> {
        let moved =
            |body: SceneBody| SceneBody { world_from_body: self.motion * body.world_from_body, ..body };
        self.scene.bodies().into_iter().map(moved).collect()
    }

    fn judge(&mut self) -> Outcome {
        self.scene.judge()
    }

    fn expert(&self) -> Box<dyn Policy> {
        Box::new(TurnedPolicy { policy: self.scene.expert(), motion: self.motion })
    }

    fn alternative(&self) -> Option<Vec<SE3>> {
        let poses = self.scene.alternative()?;
        Some(poses.into_iter().map(|pose| self.motion * pose).collect())
    }

    fn disturb(&mut self, seed: u64) {
        self.scene.disturb(seed);
    }
}

impl Policy for TurnedPolicy {
    fn name(&self) -> &str {
        self.policy.name()
    }

    fn reset(&mut self, seed: u64) {
        self.policy.reset(seed);
    }

    fn plan(&mut self, history: &ObservationHistory) -> Result<Plan, PolicyError> {
        let back = self.motion.inverse();
        let unmoved = history.map(|frame| move_observation(&back, frame.clone()), |pose| back * *pose);
        let plan = self.policy.plan(&unmoved)?;
        let actions = plan.actions.iter().map(|action| move_action(&self.motion, action)).collect();
        Ok(Plan { actions: reseflow_data::ActionChunk(actions), ..plan })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use reseflow_data::{IgnoreEvents, RolloutConfig, Split, rollout};
    use reseflow_lie::geodesic_distance;

    /// The expert, moved along with the world, does the same thing in it: the same outcome, and every pose moved by g.
    #[test]
    fn a_turned_episode_is_the_test_episode_moved() {
        for name in reseflow_sim::tasks() {
            check(name);
        }
    }

    fn check(name: &str) {
        let plain = reseflow_sim::task(name).unwrap();
        let turned = TurnedTask(reseflow_sim::task(name).unwrap());
        let key = EpisodeKey { task: name.to_owned(), split: Split::Test, seed: 3, index: 0, attempt: 0 };
        let spec = plain.spec();
        let config =
            RolloutConfig { observation_horizon: 2, n_action_steps: 3, disturb_before: None, policy_seed: 0 };
        let run = |task: &dyn Task| {
            let mut scene = task.reset(&key).unwrap();
            let mut expert = scene.expert();
            rollout(scene.as_mut(), &spec, expert.as_mut(), &config, &mut IgnoreEvents).unwrap()
        };
        let (expected, got) = (run(plain.as_ref()), run(&turned));
        assert_eq!(expected.outcome.success, got.outcome.success);
        assert!((expected.outcome.measure - got.outcome.measure).abs() < 1e-3);
        let motion = motion_of(&key);
        assert!(motion.rotation.angle() > 0.1, "a motion worth the name");
        for (a, b) in expected.episode.actions.iter().zip(&got.episode.actions) {
            let moved = move_action(&motion, a);
            assert!(geodesic_distance(&moved.world_from_gripper, &b.world_from_gripper).d_geo() < 1e-3);
        }
        let alternative = |task: &dyn Task| task.reset(&key).unwrap().alternative();
        match (alternative(plain.as_ref()), alternative(&turned)) {
            (Some(expected), Some(got)) => {
                for (a, b) in expected.iter().zip(&got) {
                    assert!(geodesic_distance(&(motion * *a), b).d_geo() < 1e-9);
                }
            }
            (expected, got) => assert!(expected.is_none() && got.is_none(), "{name}"),
        }
        let (first, moved) = (&expected.episode.observations[0], &got.episode.observations[0]);
        for (a, b) in first.cloud.points.iter().zip(&moved.cloud.points) {
            let a = move_point(&motion, a.map(f64::from));
            assert!((0..3).all(|axis| (a[axis] - f64::from(b[axis])).abs() < 1e-5));
        }
    }
}
