//! Equivariance from end to end over many random clouds: how far the worst of them is off, and how often moving a scene changes which
//! points are centres and neighbours.

use burn::module::Module;
use burn::optim::{AdamConfig, GradientsParams};
use burn::tensor::Device;
use rand::RngExt;
use reseflow_lie::Vector3;
use reseflow_net::{CloudGraph, DriftNet, DriftNetConfig, EdgeList};

use super::scene::{Cloud, Scene};
use super::trajectory::{endpoint, graphs, predict_on};
use super::weights::drawn_net;
use super::world::World;
use super::{assert_caught, assert_small, devices, rng, small, tensor};

/// Metres that count as much as a radian, the length scale of the losses.
const LENGTH_SCALE_M: f64 = 0.15;

/// Scenes that go through the network together.
const BATCH: usize = 16;

/// What becomes of a cloud on its way to the network.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Storage {
    /// Coordinates in f64: moving a cloud rounds them at 1e-16.
    Exact,
    /// Coordinates in f32, in the world's frame, as a data set has them.
    Single,
    /// Coordinates in whole millimetres: a control, which changes graphs and poses.
    Millimetres,
}

/// What moving scenes did.
#[derive(Debug, Clone, Default)]
pub(crate) struct Statistics {
    /// The worst error of every scene's consensus poses with the graph of the scene that stands still, radians and metres over ℓ.
    pub(crate) graph_fixed: Vec<f64>,
    /// The same with the graph built again of the moved clouds.
    pub(crate) graph_rebuilt: Vec<f64>,
    /// Clouds seen.
    pub(crate) clouds: usize,
    /// Clouds of which a centre became another.
    pub(crate) changed_centres: usize,
    /// Clouds with the same centres, of which one's neighbours became others.
    pub(crate) changed_neighbors: usize,
}

/// The largest, and the one that 999 of 1000 do not exceed.
pub(crate) fn worst_and_99_9th(errors: &[f64]) -> (f64, f64) {
    let mut sorted = errors.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let rank = (0.999 * sorted.len() as f64).ceil() as usize;
    (sorted[sorted.len() - 1], sorted[rank.clamp(1, sorted.len()) - 1])
}

/// A network that has learned to say orthonormal columns: an untrained one's are anything, and orthonormalising nearly parallel ones
/// amplifies rounding. It is taught the way from the cloud's centroid to the gripper, turned as the gripper.
pub(crate) fn trained(config: &DriftNetConfig, updates: u64, device: &Device) -> DriftNet {
    let device = device.clone().autodiff();
    let mut net = drawn_net(config, &device, &mut rng(11_000));
    let mut optimizer = AdamConfig::new().init();
    for update in 0..updates {
        let scenes: Vec<_> = (0..8).map(|index| random_scene(config, 12_000 + 8 * update + index)).collect();
        let (prediction, _, origins_m) = endpoint(&net, &scenes, &device);
        let (mut rotations, mut positions) = (Vec::new(), Vec::new());
        for (scene, origin) in scenes.iter().zip(&origins_m) {
            let gripper = scene.grippers[scene.grippers.len() - 1];
            for step in 0..config.decoder.horizon {
                rotations.extend((0..9).map(|entry| gripper.columns[entry % 3][entry / 3]));
                let part = (step + 1) as f64 / config.decoder.horizon as f64;
                positions.extend((0..3).map(|axis| part * (gripper.position_m[axis] - origin[axis])));
            }
        }
        let rows = rotations.len() / 9;
        let rotations = prediction.rotations - tensor(rotations, [rows, 3, 3], &device);
        let positions = prediction.positions_m - tensor(positions, [rows, 3], &device);
        let loss = rotations.square().mean() + positions.square().mean().mul_scalar(LENGTH_SCALE_M.powi(-2));
        let gradients = GradientsParams::from_grads(loss.backward(), &net);
        net = optimizer.step(3e-3, net, gradients);
    }
    net.valid()
}

/// What `examples/equivariance.rs` reports over thousands of clouds, over some dozens; one tolerance for each [`Storage`].
pub(crate) fn a_trained_network_turns_with_the_world_on_graphs_built_again(tolerances: [f64; 2]) {
    for (name, device) in devices() {
        let net = trained(&small(), 40, &device);
        for (storage, tolerance) in [Storage::Exact, Storage::Single].into_iter().zip(tolerances) {
            let statistics = measure(&net, 16, storage, &device);
            assert_eq!(statistics.clouds, 16 * 3);
            let (fixed, _) = worst_and_99_9th(&statistics.graph_fixed);
            assert_small(&format!("{name} {storage:?}, graph fixed"), fixed, tolerance);
            let (rebuilt, _) = worst_and_99_9th(&statistics.graph_rebuilt);
            assert_small(&format!("{name} {storage:?}, graph built again"), rebuilt, tolerance);
        }
        let coarse = measure(&net, 16, Storage::Millimetres, &device);
        println!(
            "{name} in millimetres: {} other centres, {} other neighbours",
            coarse.changed_centres, coarse.changed_neighbors
        );
        assert!(coarse.changed_centres > 0 && coarse.changed_neighbors > 0, "changed graphs are counted");
        assert_caught(&format!("{name} in millimetres"), worst_and_99_9th(&coarse.graph_rebuilt).0, 1e-4);
    }
}

/// 64 to 256 points in a box or on a table.
fn random_scene(config: &DriftNetConfig, stream: u64) -> Scene {
    let mut rng = rng(stream);
    match stream % 4 {
        0 => Scene::on_a_table(&config.decoder, &mut rng),
        _ => {
            let count = rng.random_range(64..=256);
            Scene::in_a_box(count, &config.decoder, &mut rng)
        }
    }
}

/// Moves `scenes` random scenes, each by a rigid motion of its own.
pub(crate) fn measure(net: &DriftNet, scenes: u64, storage: Storage, device: &Device) -> Statistics {
    let mut statistics = Statistics::default();
    let config = net.config();
    let mut first = 0;
    while first < scenes {
        let streams = (first..scenes).take(BATCH);
        first += BATCH as u64;
        let drawn: Vec<(Scene, World)> = streams
            .map(|stream| {
                let world = World::rigid(&mut rng(30_000 + stream));
                (stored(random_scene(config, 1_000_000 + stream), storage), world)
            })
            .collect();
        let still: Vec<_> = drawn.iter().map(|(scene, _)| scene.clone()).collect();
        let moved: Vec<_> = drawn.iter().map(|(scene, world)| stored(scene.moved(world), storage)).collect();
        let (still_graphs, rebuilt) = (graphs(net, &still), graphs(net, &moved));
        let mut fixed = rebuilt.clone();
        for (frame, (fixed, still)) in fixed.iter_mut().zip(&still_graphs).enumerate() {
            for (index, (graph, still)) in fixed.iter_mut().zip(still).enumerate() {
                statistics.clouds += 1;
                if graph.centres != still.centres {
                    statistics.changed_centres += 1;
                } else if neighbors(graph) != neighbors(still) {
                    statistics.changed_neighbors += 1;
                }
                *graph = with_edges_of(still, graph, &moved[index].clouds[frame]);
            }
        }
        let reference = predict_on(net, &still_graphs, &still, device);
        for (graphs, errors) in
            [(&fixed, &mut statistics.graph_fixed), (&rebuilt, &mut statistics.graph_rebuilt)]
        {
            let predicted = predict_on(net, graphs, &moved, device);
            for ((still, moved), (_, world)) in reference.iter().zip(&predicted).zip(&drawn) {
                let deviation = still.deviation(moved, world);
                errors.push(deviation.rotation.max(deviation.position_m / LENGTH_SCALE_M));
            }
        }
    }
    statistics
}

fn stored(scene: Scene, storage: Storage) -> Scene {
    let round = |value: f64| match storage {
        Storage::Exact => value,
        Storage::Single => f64::from(value as f32),
        Storage::Millimetres => (value * 1e3).round() * 1e-3,
    };
    let rounded = |cloud: &Cloud| Cloud {
        points: cloud.points.iter().map(|point| point.map(round)).collect(),
        colors: cloud.colors.clone(),
    };
    Scene { clouds: scene.clouds.iter().map(rounded).collect(), ..scene }
}

/// The neighbours of every centre, whatever their order.
fn neighbors(graph: &CloudGraph) -> Vec<Vec<usize>> {
    let of = |edges: &EdgeList| {
        let sorted = |sources: &[usize]| {
            let mut sources = sources.to_vec();
            sources.sort_unstable();
            sources
        };
        edges.sources.chunks_exact(edges.per_receiver).map(sorted).collect::<Vec<_>>()
    };
    [of(&graph.point_edges), of(&graph.centre_edges)].concat()
}

/// The centres, neighbours and weights of `still` with the places of `moved`, the graph of the moved `cloud`.
fn with_edges_of(still: &CloudGraph, moved: &CloudGraph, cloud: &Cloud) -> CloudGraph {
    let position = |index: usize| Vector3::from(cloud.points[index]);
    let edges = |edges: &EdgeList, source: &dyn Fn(usize) -> usize| {
        let displacement = |(edge, &from): (usize, &usize)| {
            (position(source(from)) - position(still.centres[edge / edges.per_receiver])).into()
        };
        let displacement_m = edges.sources.iter().enumerate().map(displacement).collect();
        EdgeList { displacement_m, ..edges.clone() }
    };
    CloudGraph {
        point_edges: edges(&still.point_edges, &|source| source),
        centre_edges: edges(&still.centre_edges, &|source| still.centres[source]),
        centres: still.centres.clone(),
        ..moved.clone()
    }
}
