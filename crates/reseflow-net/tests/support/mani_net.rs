//! SE3ManiNet at a small size, and its nodes on the host.

use burn::tensor::{Device, Tensor};
use reseflow_lie::SE3;
use reseflow_net::degrees::UniformFiber;
use reseflow_net::{
    GraphConfig, GripperState, ManiNodes, Nonlinearity, SE3ManiNet, SE3ManiNetConfig, SE3TransformerConfig,
};

use super::fibers::HostFiber;
use super::scene::{Cloud, gripper};
use super::world::World;
use super::{rng, values};

/// Degrees 0–2 between the blocks and 0–1 after them; three nodes.
pub(crate) fn small_mani_net(nonlinearity: Nonlinearity) -> SE3ManiNetConfig {
    SE3ManiNetConfig {
        graph: GraphConfig { centres: 10, point_neighbors: 6, centre_neighbors: 4, color_m: 0.0 },
        transformer: SE3TransformerConfig {
            max_degree: 2,
            channels: 4,
            output: UniformFiber { max_degree: 1, channels: 5 },
            layers: 2,
            heads: 2,
            channels_div: 1,
            nonlinearity,
            radial_hidden: 8,
            ..SE3TransformerConfig::default()
        },
        nodes: 3,
        ..SE3ManiNetConfig::default()
    }
}

/// Some gripper for each of `count` scenes.
pub(crate) fn homes(count: usize) -> Vec<GripperState> {
    let mut rng = rng(18);
    (0..count).map(|_| gripper(&SE3::identity(), [2.0, 0.2], &mut rng)).collect()
}

/// The nodes of clouds with these grippers, all moved by `world`.
pub(crate) fn nodes(
    net: &SE3ManiNet,
    clouds: &[Cloud],
    grippers: &[GripperState],
    world: &World,
    device: &Device,
) -> ManiNodes {
    let graphs: Vec<_> = clouds.iter().map(|cloud| cloud.moved(world).graph(&net.config().graph)).collect();
    let grippers: Vec<_> = grippers.iter().map(|state| world.gripper(state)).collect();
    net.encode(&graphs, &grippers, device).expect("one gripper a graph")
}

/// Features of the nodes, with their positions among the vectors and the heat maps after the scalars.
pub(crate) fn features_on_host(nodes: &ManiNodes) -> HostFiber {
    let rows = nodes.features.points();
    let mut features = nodes.features.clone();
    let positions = nodes.positions_m.clone().swap_dims(0, 1).reshape([3, rows, 1]);
    features.degrees[1] = Tensor::cat(vec![features.degrees[1].clone(), positions], 2);
    let mut host = HostFiber::of(&features);
    host.degrees[0].extend(values(&nodes.heat));
    host.degrees[0].extend(values(&nodes.overlap()));
    host.degrees[0].extend(values(&nodes.weights));
    host
}

/// Poses of the nodes and of their consensus as vectors: the first two columns of the rotation, and the position; and the spread.
pub(crate) fn poses_on_host(nodes: &ManiNodes) -> HostFiber {
    let rotations = Tensor::cat(vec![nodes.rotations.clone(), nodes.consensus_rotations.clone()], 0);
    let positions = Tensor::cat(vec![nodes.translations_m.clone(), nodes.consensus_positions_m.clone()], 0);
    let [rows, _] = positions.dims();
    let columns = rotations.narrow(2, 0, 2).swap_dims(0, 1);
    let positions = positions.swap_dims(0, 1).reshape([3, rows, 1]);
    HostFiber {
        points: rows,
        degrees: vec![values(&nodes.spread()), values(&Tensor::cat(vec![columns, positions], 2))],
    }
}
