//! Tensors of other shapes than the weights were drawn for end in a panic that says what was expected; lists and frames that do not go
//! together are refused.

use std::panic::{AssertUnwindSafe, catch_unwind};

use burn::tensor::{Device, Tensor};
use reseflow_net::degrees::{
    EdgeFrames, EdgeProduct, Fiber, FiberFeatures, FiberHeatMap, FiberHeatMapConfig, FiberLayerNormConfig,
    FiberLinearConfig, GatedNonlinearityConfig, NeighborAttentionConfig, NormNonlinearityConfig,
    TensorProductConvolutionConfig, edge_message,
};
use reseflow_net::message::{self, EdgeActivations};
use reseflow_net::{EdgeList, EdgeTensors, Features, NetError, RadialBasis, SceneFrames};

use crate::support::degree_layers::{RADIAL_MLP, centre_edges, frames, uniform};
use crate::support::layers::{GRAPH, RADIAL, batch, clouds};
use crate::support::world::World;
use crate::support::{devices, rng};

/// Asserts that `call` panics with a message that has all of `words`.
#[track_caller]
fn assert_panics<T>(words: &[&str], call: impl FnOnce() -> T) {
    let Err(panic) = catch_unwind(AssertUnwindSafe(call)) else {
        panic!("expected a panic about {words:?}");
    };
    let message = panic.downcast_ref::<String>().expect("the message is put together").as_str();
    assert!(words.iter().all(|word| message.contains(word)), "{words:?} are not in: {message}");
}

/// Zeros of this fiber at P points.
fn features(points: usize, channels: &[usize], device: &Device) -> FiberFeatures {
    let degree =
        |(degree, &channels): (usize, &usize)| Tensor::zeros([2 * degree + 1, points, channels], device);
    FiberFeatures { degrees: channels.iter().enumerate().map(degree).collect() }
}

#[test]
fn layers_name_the_degree_that_is_missing_or_has_another_shape() {
    let [(_, device), _] = devices();
    let fiber = Fiber { channels: vec![4, 3] };
    let given = |channels: &[usize]| features(6, channels, &device);
    let linear = FiberLinearConfig { input: fiber.clone(), output: fiber.clone(), bias: true };
    let linear = linear.init(&device, &mut rng(1));
    linear.forward(&given(&[4, 3, 2]));
    assert_panics(&["FiberLinear", "degree 1", "[3, 6, 3]", "None"], || linear.forward(&given(&[4])));
    assert_panics(&["FiberLinear", "degree 1", "[3, 6, 3]", "[3, 6, 5]"], || linear.forward(&given(&[4, 5])));
    let flat = FiberFeatures { degrees: vec![Tensor::zeros([1, 6, 4], &device); 2] };
    assert_panics(&["FiberLinear", "degree 1", "[1, 6, 4]"], || linear.forward(&flat));

    let norm = NormNonlinearityConfig { fiber: fiber.clone() }.init(&device);
    let gated = GatedNonlinearityConfig { fiber: fiber.clone() }.init(&device, &mut rng(2));
    let layer_norm = FiberLayerNormConfig { fiber: fiber.clone() }.init(&device);
    let heat_map = FiberHeatMapConfig { fiber, nodes: 2 }.init(&device, &mut rng(3));
    type Forward<'a> = (&'a str, &'a dyn Fn(FiberFeatures));
    let layers: [Forward; 4] = [
        ("NormNonlinearity", &|input| drop(norm.forward(input))),
        ("GatedNonlinearity", &|input| drop(gated.forward(input))),
        ("FiberLayerNorm", &|input| drop(layer_norm.forward(input))),
        ("FiberHeatMap", &|input| drop(heat_map.weights(2, &input))),
    ];
    for (name, forward) in layers {
        forward(given(&[4, 3]));
        assert_panics(&[name, "number of degrees", "2", "3"], || forward(given(&[4, 3, 3])));
        assert_panics(&[name, "number of degrees", "2", "1"], || forward(given(&[4])));
        assert_panics(&[name, "degree 0", "[1, 6, 4]", "[1, 6, 2]"], || forward(given(&[2, 3])));
    }
    assert_panics(&["FiberHeatMap", "whole scenes"], || heat_map.weights(4, &given(&[4, 3])));
    let weights = Tensor::zeros([2, 2, 4], &device);
    assert_panics(&["FiberHeatMap", "8", "6"], || FiberHeatMap::pool(&weights, &given(&[4, 3])));
    assert_panics(&["concat", "6", "5"], || given(&[4]).concat(features(5, &[4], &device)));
    assert_panics(&["sum of features", "[1, 6, 4]", "[1, 6, 2]"], || given(&[4]) + given(&[2]));
}

#[test]
fn layers_on_edges_name_what_does_not_fit_them() {
    let [(_, device), _] = devices();
    let lists = centre_edges(&clouds(&mut rng(4)), &World::identity());
    let (points, edges) = (2 * GRAPH.centres, frames(&lists, 1, &device));
    let count = points * GRAPH.centre_neighbors;
    let given = |points: usize, channels: &[usize]| features(points, channels, &device);
    let config =
        TensorProductConvolutionConfig { input: uniform(1, 3), output: uniform(1, 2), radial: RADIAL_MLP };
    let convolution = config.init(&device, &mut rng(5));
    convolution.forward(&given(points, &[3, 3]), &edges);
    assert_panics(&["edge messages", "degree 1", "[3, 24, 3]", "[3, 24, 4]"], || {
        convolution.forward(&given(points, &[3, 4]), &edges)
    });
    let low = frames(&lists, 0, &device);
    assert_panics(&["frames of edges", "up to 1", "up to 0"], || {
        convolution.forward(&given(points, &[3, 3]), &low)
    });
    let higher = TensorProductConvolutionConfig { output: uniform(3, 2), ..config };
    assert_panics(&["frames of edges", "up to 3", "up to 1"], || {
        higher.init(&device, &mut rng(6)).forward(&given(points, &[3, 3]), &edges)
    });

    let attention =
        NeighborAttentionConfig { input: uniform(1, 3), output: uniform(1, 2), heads: 1, radial: RADIAL_MLP };
    let attention = attention.init(&device, &mut rng(7)).expect("one head divides the channels");
    assert_panics(&["frames of edges", "edges of all receivers", "120", "125"], || {
        attention.forward(&given(points + 1, &[3, 3]), &edges)
    });

    let product = EdgeProduct { input: uniform(1, 3), outputs: vec![uniform(1, 2)] };
    let weights = product.weight_count();
    for form in [edge_message::fused, edge_message::composed] {
        let call = |rows: usize, matrix: [usize; 2]| {
            let radial = Tensor::zeros([rows, 7], &device);
            form(&product, &given(points, &[3, 3]), radial, Tensor::zeros(matrix, &device), &edges)
        };
        call(count, [7, weights]);
        assert_panics(&["edge messages", "radial features", "120", "119"], || call(count - 1, [7, weights]));
        assert_panics(&["edge messages", "matrix"], || call(count, [6, weights]));
        assert_panics(&["edge messages", "matrix"], || call(count, [7, weights + 1]));
    }
    assert_panics(&["frames of edges", "messages", "120", "3"], || {
        edges.sum_at_receivers(Tensor::zeros([3, 4, 2], &device), 1)
    });
}

#[test]
fn messages_name_the_tensor_that_has_another_shape() {
    let [(_, device), _] = devices();
    let batch = batch(&clouds(&mut rng(8)), &World::identity(), &device);
    let (nodes, edges) = (2 * GRAPH.centres, &batch.centre_edges);
    let count = nodes * GRAPH.centre_neighbors;
    type Spoil = fn(&mut Features, &mut EdgeActivations);
    let zeros = |rows: usize| Tensor::<2>::zeros([rows, 4], &device);
    let call = |form: fn(&Features, EdgeActivations, &EdgeTensors) -> Features, spoil: Spoil| {
        let mut sources = Features { scalars: zeros(nodes), vectors: Tensor::zeros([3, nodes, 4], &device) };
        let mut activations = EdgeActivations {
            sources: zeros(nodes),
            receivers: zeros(nodes),
            edges: zeros(count),
            matrix: Tensor::zeros([4, 20], &device),
        };
        spoil(&mut sources, &mut activations);
        form(&sources, activations, edges)
    };
    let cases: [(&str, Spoil); 7] = [
        ("activations of sources", |_, said| said.sources = said.sources.clone().narrow(0, 0, 3)),
        ("activations of receivers", |_, said| said.receivers = said.receivers.clone().narrow(1, 0, 3)),
        ("activations of edges", |_, said| said.edges = said.edges.clone().narrow(0, 0, 119)),
        ("the matrix of path weights", |_, said| said.matrix = said.matrix.clone().narrow(0, 0, 3)),
        ("the matrix of path weights", |_, said| said.matrix = said.matrix.clone().narrow(1, 0, 19)),
        ("vectors of sources", |sources, _| sources.vectors = sources.vectors.clone().narrow(2, 0, 3)),
        ("activations of sources", |sources, _| sources.scalars = sources.scalars.clone().narrow(1, 0, 3)),
    ];
    for form in [message::fused, message::composed] {
        call(form, |_, _| ());
        for (what, spoil) in cases {
            assert_panics(&["messages: ", what], || call(form, spoil));
        }
    }
}

#[test]
fn edges_that_do_not_go_together_are_refused() {
    let [(_, device), _] = devices();
    let list = EdgeList {
        per_receiver: 2,
        sources: vec![0, 1, 2, 0],
        displacement_m: vec![[0.1, 0.0, 0.0]; 4],
        weights: vec![0.5; 4],
    };
    let collate = |list: &EdgeList, basis: &RadialBasis| {
        EdgeTensors::collate([(list, 3)], basis, &device).map(|edges| edges.per_receiver)
    };
    assert_eq!(collate(&list, &RADIAL), Ok(2));
    for bad in [RadialBasis { count: 1, ..RADIAL }, RadialBasis { max_m: f64::NAN, ..RADIAL }] {
        match collate(&list, &bad) {
            Err(NetError::Config(fault)) => assert!(fault.starts_with("radial_basis needs"), "{fault}"),
            other => panic!("{bad:?}: expected a refusal, got {other:?}"),
        }
    }
    type Spoil = fn(&mut EdgeList);
    let cases: [(&str, Spoil, [usize; 2]); 5] = [
        ("edges left over by whole receivers", |list| list.per_receiver = 3, [0, 1]),
        ("edges left over by whole receivers", |list| list.per_receiver = 0, [0, 4]),
        ("displacements of edges", |list| list.displacement_m.truncate(3), [4, 3]),
        ("weights of edges", |list| list.weights.push(0.0), [4, 5]),
        ("nodes that sources of edges index", |list| list.sources[1] = 7, [3, 8]),
    ];
    for (what, spoil, [expected, got]) in cases {
        let mut list = list.clone();
        spoil(&mut list);
        assert_eq!(collate(&list, &RADIAL), Err(NetError::Mismatch { what, expected, got }));
    }
    let refused = |lists: &[(&EdgeList, usize)]| {
        EdgeTensors::collate(lists.iter().copied(), &RADIAL, &device).map(|_| ()).err()
    };
    let wider = EdgeList { per_receiver: 4, ..list.clone() };
    let what = "edges per receiver";
    assert_eq!(refused(&[(&list, 3), (&wider, 3)]), Some(NetError::Mismatch { what, expected: 2, got: 4 }));
    let what = "lists of edges in a batch";
    assert_eq!(refused(&[]), Some(NetError::Mismatch { what, expected: 1, got: 0 }));

    let edges = EdgeTensors::collate([(&list, 3)], &RADIAL, &device).expect("the list is sound");
    let short = EdgeFrames::new(edges, list.displacement_m[1..].iter(), 1, &device).map(|_| ()).err();
    let what = "displacements of edges";
    assert_eq!(short, Some(NetError::Mismatch { what, expected: 4, got: 3 }));
    let clouds = clouds(&mut rng(9));
    let graphs: Vec<_> = clouds.iter().map(|cloud| cloud.graph(&GRAPH)).collect();
    let batch = batch(&clouds, &World::identity(), &device);
    assert!(SceneFrames::new(&batch, &graphs, 1, &device).is_ok());
    let short = SceneFrames::new(&batch, &graphs[1..], 1, &device).map(|_| ()).err();
    let [expected, got] = [2, 1].map(|scenes| scenes * GRAPH.centres * GRAPH.point_neighbors);
    assert_eq!(short, Some(NetError::Mismatch { what, expected, got }));
}
