//! What the decoder's options do: a half-turn is chosen by the gripper, and pointers read what is near their tips.

use burn::tensor::{Device, Tensor};
use reseflow_lie::{Matrix3, Vector3};
use reseflow_net::{DriftNetConfig, Features, PointerAttentionConfig};

use crate::support::laws::example;
use crate::support::scene::Scene;
use crate::support::trajectory::{Trajectory, predict};
use crate::support::weights::shaken;
use crate::support::{devices, rng, small, tensor, values};

/// What the same weights predict with and without the choice of a half-turn.
fn with_and_without(device: &Device, index: u64) -> (Scene, [Trajectory; 2]) {
    let config = small();
    let scene = example(index, &config);
    let trajectories = [true, false].map(|half_turn| {
        let mut config: DriftNetConfig = config.clone();
        config.decoder.half_turn = half_turn;
        let mut rng = rng(9000 + index);
        let net = shaken(config.init(device, &mut rng), 0.05, &mut rng);
        predict(&net, std::slice::from_ref(&scene), device).remove(0)
    });
    (scene, trajectories)
}

#[test]
fn every_node_begins_within_a_quarter_turn_of_the_gripper_and_turns_as_a_whole() {
    let nodes = small().encoder.nodes;
    let half_turn = Matrix3::from_diagonal(&Vector3::new(-1.0, -1.0, 1.0));
    for (name, device) in devices() {
        let (mut kept, mut turned) = (0, 0);
        for index in 0..12 {
            let (scene, [chosen, plain]) = with_and_without(&device, index);
            let closing = Vector3::from(scene.grippers[scene.grippers.len() - 1].columns[1]);
            for node in 0..nodes {
                let of = |trajectory: &Trajectory| -> Vec<Matrix3<f64>> {
                    trajectory.nodes.iter().skip(node).step_by(nodes).map(|pose| pose.0).collect()
                };
                let (chosen, plain) = (of(&chosen), of(&plain));
                assert!(chosen[0].column(1).dot(&closing) > -1e-5, "{name}: it begins on the far side");
                let is_turned = plain[0].column(1).dot(&closing) < 0.0;
                let expected = if is_turned { half_turn } else { Matrix3::identity() };
                for (chosen, plain) in chosen.iter().zip(&plain) {
                    assert!((chosen - plain * expected).norm() < 1e-5, "{name}: scene {index}, node {node}");
                }
                (kept, turned) = (kept + usize::from(!is_turned), turned + usize::from(is_turned));
            }
        }
        assert!(kept > 5 && turned > 5, "{name}: {kept} kept and {turned} turned say little");
    }
}

#[test]
fn a_pointer_reads_what_is_near_its_tip() {
    let config = PointerAttentionConfig { query: [6, 4], memory: [5, 3], heads: 2, key: 4 };
    for (name, device) in devices() {
        let layer = config.init(&device, &mut rng(9100));
        // No vectors: both pointers end at the origin. No scalars: nothing but the distance decides.
        let tokens =
            Features { scalars: Tensor::zeros([1, 6], &device), vectors: Tensor::zeros([3, 1, 4], &device) };
        let read = |rows: [(f64, f64); 2]| {
            let scalars = rows.iter().flat_map(|(value, _)| [*value; 5]).collect();
            let mut vectors = vec![0.0; 3 * 2 * 3];
            for (row, (_, x)) in rows.iter().enumerate() {
                vectors[row * 3 + 2] = *x;
            }
            let memory = Features {
                scalars: tensor(scalars, [2, 5], &device),
                vectors: tensor(vectors, [3, 2, 3], &device),
            };
            values(&layer.forward(1, &tokens, &memory).scalars)
        };
        let (alone, with_far, with_near) = (
            read([(1.0, 0.1), (1.0, 0.1)]),
            read([(1.0, 0.1), (-2.0, 3.0)]),
            read([(1.0, 0.1), (-2.0, 0.15)]),
        );
        let apart = |one: &[f64], other: &[f64]| {
            one.iter().zip(other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        assert!(apart(&alone, &with_far) < 1e-6, "{name}: what is far away was read");
        assert!(apart(&alone, &with_near) > 0.1, "{name}: what is near was not read");
    }
}
