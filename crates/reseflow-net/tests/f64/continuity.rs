//! A message fades before its source stops being a neighbour, so the network does not jump where the graph does.

use burn::tensor::Device;
use rand_chacha::ChaCha8Rng;
use reseflow_lie::SE3;
use reseflow_net::{CloudGraph, DriftNet, GraphConfig, GripperState, Nonlinearity, SE3ManiNet};

use crate::support::mani_net::{features_on_host, poses_on_host, small_mani_net};
use crate::support::scene::{Cloud, gripper, random_colors};
use crate::support::weights::{shaken, shaken_net};
use crate::support::{assert_caught, assert_small, devices, rng, small, values, worse, worst_difference};

/// As many centres as there are far corners, so that a point among them never becomes one.
const GRAPH: GraphConfig = GraphConfig { centres: 4, point_neighbors: 6, centre_neighbors: 2, color_m: 0.0 };

/// Four far corners of a tetrahedron and a loose heap between them, the last point of which is elsewhere at each `s`.
struct Passage {
    cloud: Cloud,
    from: [f64; 3],
    to: [f64; 3],
}

impl Passage {
    fn draw(rng: &mut ChaCha8Rng) -> Passage {
        let mut cloud = Cloud::in_a_box(20, rng);
        cloud.points.iter_mut().flatten().for_each(|value| *value *= 0.6);
        for (corner, reach) in
            [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]].iter().zip(1..)
        {
            cloud.points.push(corner.map(|side: f64| side * (0.25 + 0.04 * f64::from(reach))));
        }
        cloud.points.push([0.0; 3]);
        cloud.colors = random_colors(cloud.points.len(), rng);
        Passage { cloud, from: [-0.1, -0.05, 0.02], to: [0.1, 0.08, -0.03] }
    }

    fn graph(&self, s: f64) -> CloudGraph {
        let mut cloud = self.cloud.clone();
        let last = cloud.points.len() - 1;
        cloud.points[last] = [0, 1, 2].map(|axis| self.from[axis] + s * (self.to[axis] - self.from[axis]));
        cloud.graph(&GRAPH)
    }

    /// Pairs of `s` a rounding apart between which some centre's neighbours change.
    fn crossings(&self) -> Vec<(f64, f64)> {
        let neighbors = |s: f64| {
            let mut sets: Vec<Vec<usize>> = (self.graph(s).point_edges.sources)
                .chunks_exact(GRAPH.point_neighbors)
                .map(<[usize]>::to_vec)
                .collect();
            sets.iter_mut().for_each(|set| set.sort_unstable());
            sets
        };
        let mut crossings = Vec::new();
        for index in 0..100 {
            let (mut low, mut high) = (f64::from(index) / 100.0, f64::from(index + 1) / 100.0);
            let before = neighbors(low);
            if neighbors(high) == before {
                continue;
            }
            while high - low > 1e-13 {
                let middle = 0.5 * (low + high);
                *(if neighbors(middle) == before { &mut low } else { &mut high }) = middle;
            }
            crossings.push((low, high));
        }
        crossings
    }
}

/// Some gripper.
fn home() -> GripperState {
    gripper(&SE3::identity(), [2.0, 0.2], &mut rng(5))
}

/// Everything that the encoder says about one graph.
fn encoded(net: &DriftNet, graph: &CloudGraph, device: &Device) -> Vec<f64> {
    let encoded = net.encode([graph], &[home()], device).expect("the graph has the network's sizes");
    let mut all = values(&encoded.positions);
    all.extend(values(&encoded.nodes.scalars));
    all.extend(values(&encoded.nodes.vectors));
    all.extend(values(&encoded.heat));
    all
}

/// The same of SE3ManiNet.
fn mani_nodes(net: &SE3ManiNet, graph: &CloudGraph, device: &Device) -> Vec<f64> {
    let nodes = net.encode([graph], &[home()], device).expect("the graph has the network's sizes");
    let parts = [features_on_host(&nodes), poses_on_host(&nodes)];
    parts.into_iter().flat_map(|part| part.degrees).flatten().collect()
}

/// The graph without its envelope: every neighbour weighs the same.
fn without_envelope(mut graph: CloudGraph) -> CloudGraph {
    graph.point_edges.weights.fill(1.0 / GRAPH.point_neighbors as f64);
    graph
}

#[test]
fn the_encoder_does_not_jump_where_neighbours_change() {
    for (name, device) in devices() {
        let (mut found, mut jump, mut jump_without) = (0, 0.0, f64::INFINITY);
        for stream in 0..5 {
            let mut rng = rng(400 + stream);
            let mut config = small();
            config.encoder.graph = GRAPH;
            let net = shaken_net(&config, &device, &mut rng);
            let passage = Passage::draw(&mut rng);
            for (low, high) in passage.crossings() {
                let [before, after] = [low, high].map(|s| passage.graph(s));
                assert_eq!(before.centres, after.centres, "only neighbours change");
                let difference = |before: &CloudGraph, after: &CloudGraph| {
                    worst_difference(&encoded(&net, before, &device), &encoded(&net, after, &device))
                };
                found += 1;
                jump = worse(jump, difference(&before, &after));
                let hard = difference(&without_envelope(before), &without_envelope(after));
                jump_without = jump_without.min(hard);
            }
        }
        assert!(found >= 5, "only {found} crossings");
        assert_small(&format!("{name} jump at {found} changes of neighbours"), jump, 1e-10);
        assert_caught(&format!("{name} smallest jump without the envelope"), jump_without, 1e-5);
    }
}

/// Every crossing changes the messages from points to centres; the centres' own graph is that of the corners.
#[test]
fn mani_net_does_not_jump_where_neighbours_change() {
    for (name, device) in devices() {
        let (mut found, mut jump, mut jump_without) = (0, 0.0, f64::INFINITY);
        for (stream, nonlinearity) in (450..454).zip([Nonlinearity::Norm, Nonlinearity::Gated].iter().cycle())
        {
            let mut rng = rng(stream);
            let mut config = small_mani_net(*nonlinearity);
            config.graph = GRAPH;
            let net = config.init(&device, &mut rng).expect("the sizes make sense");
            let net = shaken(net, 0.05, &mut rng);
            let passage = Passage::draw(&mut rng);
            for (low, high) in passage.crossings() {
                let [before, after] = [low, high].map(|s| passage.graph(s));
                let difference = |before: &CloudGraph, after: &CloudGraph| {
                    worst_difference(&mani_nodes(&net, before, &device), &mani_nodes(&net, after, &device))
                };
                found += 1;
                jump = worse(jump, difference(&before, &after));
                let hard = difference(&without_envelope(before), &without_envelope(after));
                jump_without = jump_without.min(hard);
            }
        }
        assert!(found >= 4, "only {found} crossings");
        assert_small(&format!("{name} SE3ManiNet, jump at {found} changes of neighbours"), jump, 1e-9);
        assert_caught(&format!("{name} SE3ManiNet, smallest jump without the envelope"), jump_without, 1e-5);
    }
}
