//! The loop that lets a policy act in a scene.

use std::rc::Rc;

use reseflow_data::{
    EpisodeObserver, Halt, IgnoreEvents, Observation, Outcome, Plan, RolloutConfig, RolloutRecord, Scene,
    Tick, rollout,
};

use crate::point_scene::{Diary, PointScene, WaypointPolicy, spec};

const CONFIG: RolloutConfig =
    RolloutConfig { observation_horizon: 2, n_action_steps: 3, disturb_before: None, policy_seed: 77 };

fn run(scene: &mut PointScene, policy: &mut WaypointPolicy, config: RolloutConfig) -> RolloutRecord {
    rollout(scene, &spec(10, 4), policy, &config, &mut IgnoreEvents).unwrap()
}

fn scene_and_expert(diary: &Diary) -> (PointScene, WaypointPolicy) {
    let scene = PointScene::new(diary);
    let policy = WaypointPolicy::towards(&scene, 10, diary);
    (scene, policy)
}

#[test]
fn the_policy_plans_again_after_n_action_steps() {
    let diary = Diary::default();
    let (mut scene, mut policy) = scene_and_expert(&diary);
    let record = run(&mut scene, &mut policy, CONFIG);
    let expected = [
        "reset 77",
        "plan 0 from 2 frames",
        "plan 3 from 2 frames",
        "plan 6 from 2 frames",
        "plan 9 from 2 frames",
        "judge",
    ];
    assert_eq!(*diary.borrow(), expected);
    assert_eq!(record.plan_secs.len(), 4);
    assert_eq!(record.episode.actions, policy.waypoints);
    assert!(record.outcome.success && record.outcome.halt.is_none(), "{:?}", record.outcome);

    // The recorded frames are those at the start of each action step: the previous waypoint, reached.
    for (step, observation) in record.episode.observations.iter().enumerate().skip(1) {
        assert_eq!(observation.world_from_gripper, policy.waypoints[step - 1].world_from_gripper);
        assert_eq!(observation.gripper_opening, policy.waypoints[step - 1].opening);
    }
}

#[test]
fn between_actions_the_command_follows_the_screw() {
    let diary = Diary::default();
    let (mut scene, mut policy) = scene_and_expert(&diary);
    let start = scene.state;
    run(&mut scene, &mut policy, CONFIG);
    assert_eq!(scene.commands.len(), 40);
    for (tick, command) in scene.commands.iter().enumerate() {
        let (step, within) = (tick / 4, (tick % 4 + 1) as f64 / 4.0);
        let from = if step == 0 { start } else { policy.waypoints[step - 1] };
        let expected = if within == 1.0 {
            policy.waypoints[step]
        } else {
            from.interpolate(&policy.waypoints[step], within)
        };
        assert_eq!(*command, expected, "tick {tick}");
    }
    // An oracle that does not go through `interpolate`: along a screw, equal fractions are equal body twists.
    let twist = |from: usize| {
        let pose = |tick: usize| scene.commands[tick].world_from_gripper;
        pose(from).body_twist_to(&pose(from + 1)).vector6()
    };
    assert!((twist(0) - twist(2)).norm() < 1e-12 && twist(0).norm() > 1e-3);
}

#[test]
fn a_plan_shorter_than_n_action_steps_is_used_up_before_the_next() {
    let diary = Diary::default();
    let (mut scene, mut policy) = scene_and_expert(&diary);
    policy.horizon = 4;
    let record = run(&mut scene, &mut policy, RolloutConfig { n_action_steps: 100, ..CONFIG });
    assert_eq!(record.plan_secs.len(), 3, "plans of 4, 4 and 2 actions");
    assert!(record.outcome.success);
    policy.horizon = 0;
    let mut scene = PointScene::new(&diary);
    let error = rollout(&mut scene, &spec(10, 4), &mut policy, &CONFIG, &mut IgnoreEvents).unwrap_err();
    assert_eq!(error.to_string(), "policy waypoints cannot plan: its plan holds no action");
}

#[test]
fn a_command_that_is_not_finite_ends_the_episode_and_never_reaches_the_scene() {
    for spoil in [(|action| action.opening = f64::NAN) as fn(&mut reseflow_data::Action), |action| {
        action.world_from_gripper.translation.x = f64::INFINITY
    }] {
        let diary = Diary::default();
        let (mut scene, mut policy) = scene_and_expert(&diary);
        spoil(&mut policy.waypoints[4]);
        let record = run(&mut scene, &mut policy, CONFIG);
        assert_eq!((record.outcome.success, record.outcome.halt), (false, Some(Halt::NonFiniteAction)));
        assert_eq!(scene.commands.len(), 4 * 4);
        assert_eq!((record.episode.observations.len(), record.episode.actions.len()), (5, 5));
    }
}

#[test]
fn a_halt_overrules_success() {
    let diary = Diary::default();
    let (mut scene, mut policy) = scene_and_expert(&diary);
    policy.waypoints = vec![scene.goal; 10]; // at the goal after the first step, so that the judge is content
    scene.object_lost_at = Some(6);
    let record = run(&mut scene, &mut policy, CONFIG);
    assert!(record.outcome.measure < 1e-9);
    assert_eq!((record.outcome.success, record.outcome.halt), (false, Some(Halt::ObjectLost)));
    assert_eq!(record.episode.actions.len(), 2, "the halt fell into the second step");
}

#[test]
fn the_push_comes_once_and_the_policy_sees_it() {
    let diary = Diary::default();
    let (mut scene, mut policy) = scene_and_expert(&diary);
    let record = run(&mut scene, &mut policy, RolloutConfig { disturb_before: Some(6), ..CONFIG });
    let events = diary.borrow();
    let at = |event: &str| events.iter().position(|noted| noted == event).unwrap();
    assert_eq!(events.iter().filter(|event| event.starts_with("disturb")).count(), 1);
    assert_eq!(at("disturb 77") + 1, at("plan 6 from 2 frames"));
    let lift = record.episode.observations[6].world_from_gripper.translation.z
        - policy.waypoints[5].world_from_gripper.translation.z;
    assert!((lift - 0.5).abs() < 1e-12);
}

/// Notes every event.
struct Listener(Diary);

impl EpisodeObserver for Listener {
    fn on_observation(&mut self, step: usize, observation: &Observation, scene: &dyn Scene) {
        self.0.borrow_mut().push(format!(
            "frame {step} {} {}",
            observation.cloud.len(),
            scene.bodies().len()
        ));
    }
    fn on_plan(&mut self, step: usize, plan: &Plan) {
        self.0.borrow_mut().push(format!("planned {step} {}", plan.actions.len()));
    }
    fn on_tick(&mut self, tick: &Tick, scene: &mut dyn Scene) {
        assert_eq!(scene.observe().world_from_gripper, tick.world_from_gripper);
        self.0.borrow_mut().push(format!("tick {}", tick.time_nanos / 50_000_000));
    }
    fn on_outcome(&mut self, outcome: &Outcome) {
        self.0.borrow_mut().push(format!("outcome {}", outcome.success));
    }
}

#[test]
fn observers_hear_everything_in_order() {
    let diary = Diary::default();
    let mut scene = PointScene::new(&Diary::default());
    let mut policy = WaypointPolicy::towards(&scene, 2, &Diary::default());
    let config = RolloutConfig { n_action_steps: 1, ..CONFIG };
    rollout(&mut scene, &spec(2, 2), &mut policy, &config, &mut Listener(Rc::clone(&diary))).unwrap();
    let expected = [
        "frame 0 2 2",
        "planned 0 2",
        "tick 1",
        "tick 2",
        "frame 1 2 2",
        "planned 1 1",
        "tick 3",
        "tick 4",
        "outcome true",
    ];
    assert_eq!(*diary.borrow(), expected);
}
