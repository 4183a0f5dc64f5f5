//! How fast it runs on one core: control ticks without and with the camera, clouds, whole demonstrations, pictures.
#![allow(clippy::expect_used, reason = "a benchmark that cannot be set up has nothing to measure")]

use divan::{Bencher, counter::ItemsCount};
use reseflow_data::{EpisodeKey, Scene, Split, Task};
use reseflow_sim::{GenerateRequest, TriangleTask, generate, overview_camera, render};

const TICKS: usize = 100;

fn main() {
    divan::main();
}

fn scene() -> Box<dyn Scene> {
    let key = EpisodeKey { task: "triangle".into(), split: Split::Train, seed: 0, index: 0, attempt: 0 };
    TriangleTask::default().reset(&key).expect("the default triangle can be set up")
}

/// 100 control ticks of the expert, with a frame after each `frame_every` ticks.
fn run_expert(bencher: Bencher, frame_every: Option<usize>) {
    bencher.counter(ItemsCount::new(TICKS)).with_inputs(|| (scene(), expert_commands())).bench_values(
        |(mut scene, commands)| {
            for (tick, command) in commands.iter().enumerate() {
                divan::black_box(scene.tick(command)).expect("the expert's commands can be followed");
                if frame_every.is_some_and(|every| tick % every == 0) {
                    divan::black_box(scene.observe());
                }
            }
        },
    );
}

/// The expert's commands, tick by tick.
fn expert_commands() -> Vec<reseflow_data::Action> {
    let mut scene = scene();
    let first = scene.observe();
    let mut command = reseflow_data::Action { world_from_gripper: first.world_from_gripper, opening: 1.0 };
    let history = reseflow_data::ObservationHistory::new(first, 1);
    let plan = scene.expert().plan(&history).expect("the expert can plan");
    let mut commands = Vec::with_capacity(TICKS);
    for target in plan.actions.iter() {
        commands.extend((1..=10).map(|tick| command.interpolate(target, f64::from(tick) / 10.0)));
        command = *target;
    }
    commands
}

#[divan::bench]
fn control_ticks(bencher: Bencher) {
    run_expert(bencher, None);
}

#[divan::bench]
fn control_ticks_with_a_frame_each_action_step(bencher: Bencher) {
    run_expert(bencher, Some(10));
}

#[divan::bench]
fn control_ticks_with_a_frame_each_tick(bencher: Bencher) {
    run_expert(bencher, Some(1));
}

#[divan::bench]
fn clouds(bencher: Bencher) {
    bencher.counter(ItemsCount::new(1_usize)).with_inputs(scene).bench_refs(|scene| scene.observe());
}

#[divan::bench]
fn pictures_320_by_240(bencher: Bencher) {
    let bodies = scene().bodies();
    let camera = overview_camera(&bodies, 320, 240);
    bencher.counter(ItemsCount::new(1_usize)).bench(|| render(&bodies, &camera));
}

#[divan::bench(sample_count = 5, sample_size = 1)]
fn demonstrations_on_all_cores(bencher: Bencher) {
    let request = GenerateRequest::new(Split::Train, 0, 20);
    bencher
        .counter(ItemsCount::new(20_usize))
        .bench(|| generate(&TriangleTask::default(), &request, &|| ()).expect("the expert succeeds"));
}
