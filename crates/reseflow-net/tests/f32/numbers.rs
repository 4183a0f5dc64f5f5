//! Numbers that f32 could not compute with are refused where they come in.

use burn::tensor::Device;
use reseflow_net::{CloudGraph, DriftNet, GripperState, NetError, RadialBasis, SceneBatch, TokenBatch};

use crate::support::laws::example;
use crate::support::scene::Scene;
use crate::support::trajectory::{encode, predict};
use crate::support::weights::drawn_net;
use crate::support::{devices, rng, small};

type Spoil = fn(&mut GripperState);

/// What may be wrong with a gripper, and whether that is a number that is none.
const SPOILT: [(Spoil, bool); 6] = [
    (|state| state.position_m[1] = f64::NAN, true),
    (|state| state.columns[2][0] = f64::INFINITY, true),
    (|state| state.opening = f64::NAN, true),
    (|state| state.position_m[2] = -2e6, false),
    (|state| state.columns[0][1] = 1e30, false),
    (|state| state.opening = 1e300, false),
];

fn refusal(what: &'static str, index: usize, not_finite: bool) -> NetError {
    if not_finite { NetError::NonFinite { what, index } } else { NetError::OutOfRange { what, index } }
}

fn two_scenes() -> (Device, DriftNet, [Scene; 2]) {
    let [(_, device), _] = devices();
    let config = small();
    (device.clone(), drawn_net(&config, &device, &mut rng(91)), [example(0, &config), example(1, &config)])
}

#[test]
fn a_gripper_of_numbers_that_are_none_or_too_large_is_named() {
    let (device, net, scenes) = two_scenes();
    let config = net.config();
    let graphs: Vec<CloudGraph> =
        scenes.iter().map(|scene| scene.clouds[0].graph(&config.encoder.graph)).collect();
    let encoded = encode(&net, &scenes, &device);
    for (spoil, not_finite) in SPOILT {
        let mut grippers = [scenes[0].grippers[0], scenes[1].grippers[0]];
        assert!(net.encode(&graphs, &grippers, &device).is_ok());
        spoil(&mut grippers[1]);
        let refused = net.encode(&graphs, &grippers, &device).map(|_| ());
        assert_eq!(refused, Err(refusal("gripper", 1, not_finite)));

        let mut states: Vec<_> = scenes.iter().map(Scene::state).collect();
        assert!(net.context(&encoded, &states).is_ok());
        spoil(&mut states[1].frames[2]);
        let refused = net.context(&encoded, &states).map(|_| ());
        assert_eq!(refused, Err(refusal("gripper state", 5, not_finite)), "the third of the second scene's");
    }
    let mut states: Vec<_> = scenes.iter().map(Scene::state).collect();
    states[1].grasp.position_m[2] = f64::NAN;
    let refused = net.context(&encoded, &states).map(|_| ());
    assert_eq!(refused, Err(refusal("grasp", 1, true)));
    let mut states: Vec<_> = scenes.iter().map(Scene::state).collect();
    states[0].progress = f64::NAN;
    let refused = net.context(&encoded, &states).map(|_| ());
    assert_eq!(refused, Err(refusal("progress", 0, true)));
}

#[test]
fn a_token_of_numbers_that_are_none_or_too_large_is_named() {
    let (device, _, scenes) = two_scenes();
    let noise: Vec<_> = scenes.iter().map(|scene| scene.noise.clone()).collect();
    let batch = |noise: &[Vec<GripperState>], times: &[f64], origins_m: &[[f64; 3]]| {
        TokenBatch::new(noise, times, origins_m, &device).map(|_| ())
    };
    let (times, origins_m) = ([0.1, 0.2], [[0.0; 3]; 2]);
    assert_eq!(batch(&noise, &times, &origins_m), Ok(()));
    for (spoil, not_finite) in SPOILT {
        let mut noise = noise.clone();
        spoil(&mut noise[1][3]);
        let refused = batch(&noise, &times, &origins_m);
        assert_eq!(refused, Err(refusal("token", 8, not_finite)), "the fourth of the second scene's five");
    }
    assert_eq!(batch(&noise, &[0.1, f64::NAN], &origins_m), Err(refusal("flow time", 1, true)));
    assert_eq!(batch(&noise, &times, &[[2e6, 0.0, 0.0], [0.0; 3]]), Err(refusal("origin", 0, false)));
}

#[test]
fn what_is_just_near_enough_gives_finite_trajectories() {
    for (name, device) in devices() {
        let config = small();
        let net = drawn_net(&config, &device, &mut rng(92));
        let mut far = example(0, &config);
        far.clouds[1].points[0] = [1e6, -1e6, 1e6];
        far.grippers[0].position_m = [-1e6; 3];
        far.noise[2].position_m = [1e6, 0.0, -1e6];
        let trajectory = predict(&net, &[far], &device).remove(0);
        let poses = trajectory.consensus.iter().chain(&trajectory.nodes);
        for (rotation, position) in poses {
            let finite = rotation.iter().chain(position).all(|value| value.is_finite());
            assert!(finite, "{name}: {rotation} {position}");
        }
    }
}

#[test]
fn a_radial_basis_that_is_none_is_refused() {
    let (device, net, scenes) = two_scenes();
    let graph = scenes[0].clouds[0].graph(&net.config().encoder.graph);
    let sound = RadialBasis { count: 4, max_m: 0.2 };
    for bad in [
        RadialBasis { count: 1, ..sound },
        RadialBasis { max_m: 0.0, ..sound },
        RadialBasis { max_m: f64::NAN, ..sound },
    ] {
        for (key, bases) in [("point_radial", [&bad, &sound]), ("centre_radial", [&sound, &bad])] {
            let [points, centres] = bases;
            let refused = SceneBatch::collate([&graph], &scenes[0].grippers[..1], points, centres, &device);
            match refused {
                Err(NetError::Config(fault)) => assert!(fault.contains(key), "{key}: {fault}"),
                other => panic!("{key}: expected a refusal, got {other:?}"),
            }
        }
    }
}
