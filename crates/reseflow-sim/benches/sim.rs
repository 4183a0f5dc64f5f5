//! How fast it runs on one core: control ticks without and with the camera, clouds, pictures; and, on all cores, the
//! paper's data sets.
#![allow(clippy::expect_used, reason = "a benchmark that cannot be set up has nothing to measure")]

use divan::{Bencher, counter::ItemsCount};
use reseflow_data::{Action, EpisodeKey, ObservationHistory, Scene, Split};
use reseflow_sim::{GenerateRequest, generate, overview_camera, render, task};

const TASKS: [&str; 3] = ["door", "painting", "triangle"];
/// The paper's demonstrations.
const PAPER: [(&str, usize); 3] = [("door", 10), ("painting", 31), ("triangle", 500)];
const TICKS: usize = 100;

fn main() {
    divan::main();
}

fn scene(name: &str) -> Box<dyn Scene> {
    let key = EpisodeKey { task: name.to_owned(), split: Split::Train, seed: 0, index: 0, attempt: 0 };
    let task = task(name).expect("the task is registered");
    task.reset(&key).expect("the scene can be set up")
}

/// The expert's commands, tick by tick.
fn expert_commands(name: &str) -> Vec<Action> {
    let mut scene = scene(name);
    let first = scene.observe();
    let mut command = Action { world_from_gripper: first.world_from_gripper, opening: first.gripper_opening };
    let history = ObservationHistory::new(first, 1);
    let plan = scene.expert().plan(&history).expect("the expert can plan");
    let mut commands = Vec::with_capacity(TICKS);
    for target in plan.actions.iter() {
        commands.extend((1..=10).map(|tick| command.interpolate(target, f64::from(tick) / 10.0)));
        command = *target;
    }
    commands
}

/// 100 control ticks of the expert, with a frame after each `frame_every` ticks.
fn run_expert(bencher: Bencher, name: &str, frame_every: Option<usize>) {
    let inputs = || (scene(name), expert_commands(name));
    bencher.counter(ItemsCount::new(TICKS)).with_inputs(inputs).bench_values(|(mut scene, commands)| {
        for (tick, command) in commands.iter().enumerate() {
            divan::black_box(scene.tick(command)).expect("the expert's commands can be followed");
            if frame_every.is_some_and(|every| tick % every == 0) {
                divan::black_box(scene.observe());
            }
        }
    });
}

#[divan::bench(args = TASKS)]
fn control_ticks(bencher: Bencher, name: &str) {
    run_expert(bencher, name, None);
}

#[divan::bench(args = TASKS)]
fn control_ticks_with_a_frame_each_action_step(bencher: Bencher, name: &str) {
    run_expert(bencher, name, Some(10));
}

#[divan::bench(args = TASKS)]
fn control_ticks_with_a_frame_each_tick(bencher: Bencher, name: &str) {
    run_expert(bencher, name, Some(1));
}

#[divan::bench(args = TASKS)]
fn clouds(bencher: Bencher, name: &str) {
    bencher.counter(ItemsCount::new(1_usize)).with_inputs(|| scene(name)).bench_refs(|scene| scene.observe());
}

#[divan::bench(args = TASKS)]
fn pictures_320_by_240(bencher: Bencher, name: &str) {
    let bodies = scene(name).bodies();
    let camera = overview_camera(&bodies, 320, 240);
    bencher.counter(ItemsCount::new(1_usize)).bench(|| render(&bodies, &camera));
}

#[divan::bench(args = PAPER, sample_count = 1, sample_size = 1)]
fn paper_data_sets_on_all_cores(bencher: Bencher, (name, episodes): (&str, usize)) {
    let task = task(name).expect("the task is registered");
    let request = GenerateRequest::new(Split::Train, 0, episodes);
    bencher
        .counter(ItemsCount::new(episodes))
        .bench(|| generate(task.as_ref(), &request, &|| ()).expect("the expert succeeds"));
}
