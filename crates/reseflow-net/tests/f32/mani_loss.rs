//! The loss of SE3ManiNet against its formula on the host.

use reseflow_lie_tensor::SE3Tensor;
use reseflow_net::{ManiLossConfig, Nonlinearity};

use crate::support::degree_laws::example;
use crate::support::mani_net::{homes, nodes, small_mani_net};
use crate::support::world::World;
use crate::support::{assert_small, devices, values};

#[test]
fn the_loss_is_the_consensus_and_the_mean_of_the_nodes_and_the_overlap() {
    for (name, device) in devices() {
        let (net, clouds) = example(&small_mani_net(Nonlinearity::Norm), &device, 9500);
        let found = nodes(&net, &clouds, &homes(clouds.len()), &World::identity(), &device);
        let per_scene = net.config().nodes;
        // Every scene's first node has its pose right.
        let first = |size: usize, all: Vec<f64>| -> Vec<f64> {
            let of_scene = all.chunks_exact(size * per_scene).map(|scene| scene[..size].to_vec());
            of_scene.flatten().collect()
        };
        let rotations = first(9, values(&found.rotations));
        let positions = first(3, values(&found.translations_m));
        let scenes = clouds.len();
        let targets = SE3Tensor {
            rotation: crate::support::tensor(rotations.clone(), [scenes, 3, 3], &device),
            translation: crate::support::tensor(positions.clone(), [scenes, 3], &device),
        };
        let config = ManiLossConfig { length_m: 0.2, nodes: 0.7, overlap: 3.0 };
        let mean_square = |size: usize, found: Vec<f64>, wanted: &[f64]| {
            let rows = found.len() / size;
            let per_target = rows / scenes;
            let squares = found.iter().enumerate().map(|(index, value)| {
                (value - wanted[index / size / per_target * size + index % size]).powi(2)
            });
            squares.sum::<f64>() / rows as f64
        };
        let error = |turns, places| {
            0.5 * mean_square(9, turns, &rotations) + mean_square(3, places, &positions) / (0.2 * 0.2)
        };
        let consensus = error(values(&found.consensus_rotations), values(&found.consensus_positions_m));
        let of_nodes = error(values(&found.rotations), values(&found.translations_m));
        assert!(consensus > 1e-2 && of_nodes > 1e-2, "{consensus} {of_nodes}");
        let expected = consensus + 0.7 * of_nodes + 3.0 * values(&found.overlap())[0];
        let loss = values(&found.loss(&targets, &config))[0];
        assert_small(&format!("{name} loss of SE3ManiNet"), (loss - expected).abs() / expected, 1e-5);
    }
}
