//! What the kernels answer: invariant and equivariant, scene by scene, waypoint by waypoint.

use burn::tensor::Tensor;
use reseflow_data::ActionChunk;
use reseflow_flow::{AnchoredChunk, Denoiser};
use reseflow_lie::geodesic_distance;

use super::{
    HORIZON, apart, config, device, equivariant, invariant, moved, net, numbers, of_degrees_0_to_2, pose,
    rng, scene, state, view,
};
use crate::convert::host;
use crate::etseed::denoiser::NetDenoiser;
use crate::etseed::input::{KernelInput, SceneView};

/// Of degree 0 alone: vectors would turn.
#[test]
fn the_invariant_kernel_answers_the_same_wherever_the_scene_lies() {
    for config in [config(), of_degrees_0_to_2()] {
        let mut draws = rng(1);
        let net = net(&config, &device());
        for stream in 10..14 {
            let (frames, state) = (scene(stream), state(40, stream));
            let here = numbers(&invariant(&net, &[&view(&frames, &config)], std::slice::from_ref(&state)));
            let world = pose(&mut draws, 1.0);
            let there = numbers(&invariant(
                &net,
                &[&view(&moved(&world, &frames), &config)],
                std::slice::from_ref(&state),
            ));
            assert!(apart(&here, &there) < 1e-4, "{}", apart(&here, &there));

            let mut left_behind = moved(&world, &frames);
            for (frame, still) in left_behind.iter_mut().zip(&frames) {
                frame.world_from_gripper = still.world_from_gripper;
            }
            let control =
                numbers(&invariant(&net, &[&view(&left_behind, &config)], std::slice::from_ref(&state)));
            assert!(apart(&here, &control) > 1e-3, "control: moving the cloud alone changes too little");
        }
    }
}

/// Columns everywhere: rows would turn by no group action.
#[test]
fn the_left_factor_of_the_last_step_is_conjugated_by_a_motion_of_the_scene() {
    for config in [config(), of_degrees_0_to_2()] {
        let mut draws = rng(2);
        let net = net(&config, &device());
        for stream in 20..24 {
            let frames = scene(stream);
            let world = pose(&mut draws, 1.0);
            let factors = |frames: &[reseflow_data::Observation; 2]| {
                let view = view(frames, &config);
                let trajectory = view.anchor.place(&state(1, stream));
                let views = [view];
                let mut denoiser = NetDenoiser::new(&net, &views, 100, &device()).unwrap();
                denoiser.equivariant(std::slice::from_ref(&trajectory)).unwrap().remove(0)
            };
            for (here, there) in factors(&frames).iter().zip(&factors(&moved(&world, &frames))) {
                let expected = world * here.clean_from_noisy * world.inverse();
                let error = geodesic_distance(&there.clean_from_noisy, &expected).d_geo();
                assert!(error < 1e-3, "{error}");
                assert!((there.opening - here.opening).abs() < 1e-4);
                let plain = geodesic_distance(&there.clean_from_noisy, &here.clean_from_noisy);
                assert!(plain.translation_m > 1e-3, "control: the factor is an invariant one");
                assert!(here.clean_from_noisy.rotation.angle() > 1e-3, "control: the kernel says nothing");
            }
        }
    }
}

#[test]
fn the_order_of_the_points_does_not_matter() {
    let config = config();
    let net = net(&config, &device());
    let (frames, state) = (scene(30), state(30, 30));
    let mut reversed = frames.clone();
    for frame in &mut reversed {
        frame.cloud.points.reverse();
        frame.cloud.colors.reverse();
    }
    let (one, other) = (view(&frames, &config), view(&reversed, &config));
    let states = std::slice::from_ref(&state);
    assert!(
        apart(&numbers(&invariant(&net, &[&one], states)), &numbers(&invariant(&net, &[&other], states)))
            < 1e-4
    );
    let placed = [one.anchor.place(&state)];
    let answer = |view: &SceneView| numbers(&equivariant(&net, &[view], &placed));
    assert!(apart(&answer(&one), &answer(&other)) < 1e-4);
}

/// Twice as many points in the same places, twice as many neighbours: a mean stays, a sum doubles.
#[test]
fn a_denser_cloud_gives_the_same_answer() {
    for config in [config(), of_degrees_0_to_2()] {
        let mut denser = config.clone();
        denser.network.encoder.graph.point_neighbors *= 2;
        let net = net(&config, &device());
        let (frames, state) = (scene(40), state(30, 40));
        let doubled = frames.clone().map(|mut frame| {
            frame.cloud.points.extend_from_within(..);
            frame.cloud.colors.extend_from_within(..);
            frame
        });
        let (once, twice) = (view(&frames, &config), view(&doubled, &denser));
        let (states, placed) = (std::slice::from_ref(&state), [once.anchor.place(&state)]);
        for [once, twice] in [
            [&once, &twice].map(|view| numbers(&invariant(&net, &[view], states))),
            [&once, &twice].map(|view| numbers(&equivariant(&net, &[view], &placed))),
        ] {
            assert!(apart(&once, &twice) < 1e-4, "{}", apart(&once, &twice));
        }
    }
}

/// Clouds and actions of a batch belong together scene by scene.
#[test]
fn scenes_of_a_batch_get_the_answers_that_they_get_alone() {
    let config = config();
    let net = net(&config, &device());
    let views: Vec<SceneView> = (50..53).map(|stream| view(&scene(stream), &config)).collect();
    let states: Vec<AnchoredChunk> = (50..53).map(|stream| state(60, stream)).collect();
    let placed: Vec<ActionChunk> =
        views.iter().zip(&states).map(|(view, state)| view.anchor.place(state)).collect();
    let all: Vec<&SceneView> = views.iter().collect();
    let together = [invariant(&net, &all, &states), equivariant(&net, &all, &placed)];
    for index in 0..3 {
        let alone = [
            invariant(&net, &[&views[index]], &states[index..=index]),
            equivariant(&net, &[&views[index]], &placed[index..=index]),
        ];
        for (together, alone) in together.iter().zip(&alone) {
            let rows = index * HORIZON;
            let of = |tensor: &Tensor<2>| host(&tensor.clone().narrow(0, rows, HORIZON)).unwrap();
            let rotations = host(&together.rotations.clone().narrow(0, rows, HORIZON)).unwrap();
            assert!(apart(&rotations, &host(&alone.rotations).unwrap()) < 1e-4);
            assert!(apart(&of(&together.positions_m), &host(&alone.positions_m).unwrap()) < 1e-4);
            assert!(apart(&of(&together.openings), &host(&alone.openings).unwrap()) < 1e-4);
        }
    }
    let first = numbers(&invariant(&net, &all[..1], &states[..1]));
    let swapped = numbers(&invariant(&net, &all[1..2], &states[..1]));
    assert!(apart(&first, &swapped) > 1e-3, "control: which scene it is changes too little");
}

#[test]
fn waypoints_with_the_same_noise_differ_and_know_of_each_other() {
    let config = config();
    let net = net(&config, &device());
    let view = view(&scene(60), &config);
    let same = AnchoredChunk(vec![state(100, 60).0[0]; HORIZON]);
    let mut changed = same.clone();
    changed.0[3] = state(100, 61).0[1];
    let rows = |state: &AnchoredChunk| {
        let placed = view.anchor.place(state);
        let answers =
            [invariant(&net, &[&view], std::slice::from_ref(state)), equivariant(&net, &[&view], &[placed])];
        answers.map(|answer| {
            let rotations = host(&answer.rotations).unwrap();
            rotations.chunks_exact(9).map(<[f64]>::to_vec).collect::<Vec<_>>()
        })
    };
    for (same, changed) in rows(&same).iter().zip(&rows(&changed)) {
        for (one, other) in [(0, 1), (1, 2), (0, 3)] {
            assert!(apart(&same[one], &same[other]) > 1e-4, "waypoints {one} and {other} are one");
        }
        assert!(apart(&same[0], &changed[0]) > 1e-6, "waypoint 0 does not see waypoint 3");
    }
}

/// Colours in bytes and levels up to 100 would drown the geometry.
#[test]
fn every_number_that_enters_is_of_order_one() {
    let config = config();
    for level in [2, 50, 100] {
        let view = view(&scene(70), &config);
        let states = [state(level, 70)];
        let input = KernelInput::invariant(&[&view], &states, &[level], 100, &device()).unwrap();
        let colors = view.graphs.iter().flat_map(|graph| graph.colors.iter().flatten().copied());
        let entering = [
            host(&input.tokens.scalars).unwrap(),
            host(&input.tokens.vectors).unwrap(),
            host(&input.pose_numbers).unwrap(),
            colors.collect(),
        ];
        for values in entering {
            let largest = values.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
            assert!(largest <= 6.0, "level {level}: {largest}");
        }
    }
}
