//! Operations of our own read tensors as slices: here their inputs lie in memory in every other order, or are results of other operations.

use burn::tensor::{Device, Tensor};
use reseflow_net::degrees::edge_message;
use reseflow_net::degrees::{EdgeFrames, EdgeProduct, FiberFeatures};
use reseflow_net::message::{self, EdgeActivations};
use reseflow_net::silu::silu;
use reseflow_net::{EdgeList, EdgeTensors, Features, RadialBasis};

use super::degree_layers::uniform;
use super::gradients::weighed;
use super::{assert_small, devices, normals, rng, tensor, values, worse, worst_difference};

/// How a tensor lies in memory.
#[derive(Debug, Clone, Copy)]
enum View {
    InOrder,
    Transposed,
    RowsOfMore,
    ColumnsOfMore,
    Backwards,
}

const VIEWS: [View; 5] =
    [View::InOrder, View::Transposed, View::RowsOfMore, View::ColumnsOfMore, View::Backwards];

/// The tensor that owns the memory, and a view of it that has the same values whatever the view.
fn viewed<const D: usize>(view: View, plain: &Tensor<D>) -> (Tensor<D>, Tensor<D>) {
    let fresh = |other: Tensor<D>| tensor(values(&other), other.dims(), &plain.device());
    let among_more = |axis: usize| {
        let owner =
            fresh(Tensor::cat(vec![plain.clone().add_scalar(9.0), plain.clone(), plain.clone()], axis));
        let owner = owner.require_grad();
        let size = plain.dims()[axis];
        (owner.clone(), owner.narrow(axis, size, size))
    };
    match view {
        View::InOrder => {
            let owner = fresh(plain.clone()).require_grad();
            (owner.clone(), owner.mul_scalar(1.0))
        }
        View::Transposed => {
            let owner = fresh(plain.clone().swap_dims(0, D - 1)).require_grad();
            (owner.clone(), owner.swap_dims(0, D - 1))
        }
        View::RowsOfMore => among_more(0),
        View::ColumnsOfMore => among_more(D - 1),
        View::Backwards => {
            let owner = fresh(plain.clone().flip([0])).require_grad();
            (owner.clone(), owner.flip([0]))
        }
    }
}

const RADIAL: RadialBasis = RadialBasis { count: 2, max_m: 0.2 };

/// Several receivers, the second of which hears nothing, and one that has one edge, from where it is itself.
fn lists() -> [(EdgeList, usize); 2] {
    let mut rng = rng(55);
    let mut several = EdgeList {
        per_receiver: 3,
        sources: vec![2, 0, 1, 0, 0, 0, 3, 3, 2, 1, 0, 3],
        displacement_m: (0..12).map(|_| [0, 1, 2].map(|_| 0.1 * normals(1, &mut rng)[0])).collect(),
        weights: (0..12).map(|edge| 0.1 + 0.05 * f64::from(edge)).collect(),
    };
    several.weights[3..6].fill(0.0);
    several.displacement_m[3..6].fill([0.0; 3]);
    let lone =
        EdgeList { per_receiver: 1, sources: vec![0], displacement_m: vec![[0.0; 3]], weights: vec![1.0] };
    [(several, 4), (lone, 1)]
}

/// Every number that two forms say, relative to the largest of its tensor.
fn apart(fast: &[Vec<f64>], plain: &[Vec<f64>]) -> f64 {
    assert_eq!(fast.len(), plain.len());
    let relative = |(fast, plain): (&Vec<f64>, &Vec<f64>)| {
        let size = plain.iter().fold(0.0, |size, value| worse(size, value.abs()));
        worst_difference(fast, plain) / size.max(1e-3)
    };
    fast.iter().zip(plain).map(relative).fold(0.0, worse)
}

type Convolved = fn(&Features, EdgeActivations, &EdgeTensors) -> Features;

fn convolved(
    form: Convolved,
    view: View,
    (list, nodes): &(EdgeList, usize),
    channels: usize,
    paths: usize,
    device: &Device,
) -> Vec<Vec<f64>> {
    let mut rng = rng(56);
    let mut edges = EdgeTensors::collate([(list, *nodes)], &RADIAL, device).expect("the list is sound");
    edges.directions = viewed(view, &edges.directions).1;
    edges.weights = viewed(view, &edges.weights).1;
    let (count, receivers) = (list.sources.len(), list.sources.len() / list.per_receiver);
    let mut owners = Vec::new();
    let mut input = |rows: usize, width: usize| {
        let (owner, view) = viewed(view, &tensor(normals(rows * width, &mut rng), [rows, width], device));
        owners.push(owner);
        view
    };
    let activations = EdgeActivations {
        sources: input(*nodes, channels),
        receivers: input(receivers, channels),
        edges: input(count, channels),
        matrix: input(channels, paths * channels),
    };
    let scalars = input(*nodes, channels);
    let vectors = tensor(normals(3 * nodes * channels, &mut rng), [3, *nodes, channels], device);
    let (owner, vectors) = viewed(view, &vectors);
    let output = form(&Features { scalars, vectors }, activations, &edges);
    let mut all = vec![values(&output.scalars), values(&output.vectors)];
    let loss = weighed(output.scalars.swap_dims(0, 1), &mut rng) + weighed(output.vectors, &mut rng);
    let gradients = loss.backward();
    all.extend(owners.iter().map(|owner| values(&owner.grad(&gradients).expect("every input is tracked"))));
    all.push(owner.grad(&gradients).map_or_else(Vec::new, |gradient| values(&gradient)));
    // Without their paths the vectors have a gradient of zero, or none.
    if paths == 2 {
        let none = all.pop().expect("it was pushed");
        assert!(none.iter().all(|value| *value == 0.0));
    }
    all
}

pub(crate) fn messages_do_not_depend_on_how_their_inputs_lie(tolerance: f64) {
    for (name, device) in devices() {
        let device = device.autodiff();
        let mut worst = 0.0;
        for list in &lists() {
            for (channels, paths) in [(1, 5), (3, 5), (1, 2), (3, 2)] {
                for view in VIEWS {
                    let say = |form| convolved(form, view, list, channels, paths, &device);
                    let found = apart(&say(message::fused), &say(message::composed));
                    assert!(found <= tolerance, "{name} {view:?} {channels} {paths}: {found:e}");
                    worst = worse(worst, found);
                }
            }
        }
        assert_small(&format!("{name} messages of views"), worst, tolerance);
    }
}

type Product = fn(&EdgeProduct, &FiberFeatures, Tensor<2>, Tensor<2>, &EdgeFrames) -> Vec<Tensor<3>>;

fn product(
    form: Product,
    view: View,
    (list, nodes): &(EdgeList, usize),
    (degree, channels): (usize, usize),
    device: &Device,
) -> Vec<Vec<f64>> {
    let mut rng = rng(57);
    let product =
        EdgeProduct { input: uniform(degree, channels), outputs: vec![uniform(1, channels), uniform(2, 1)] };
    let edges = EdgeTensors::collate([(list, *nodes)], &RADIAL, device).expect("the list is sound");
    let mut frames = EdgeFrames::new(edges, list.displacement_m.iter(), 2, device)
        .expect("there is one displacement for each edge");
    frames.wigner = viewed(view, &frames.wigner).1;
    let mut owners = Vec::new();
    let degrees = (0..=degree).map(|degree| {
        let size = [2 * degree + 1, *nodes, channels];
        let plain = tensor(normals(size.iter().product(), &mut rng), size, device);
        let (owner, view) = viewed(view, &plain);
        owners.push(owner);
        view
    });
    let features = FiberFeatures { degrees: degrees.collect() };
    let (count, weights) = (list.sources.len(), product.weight_count());
    let mut matrix = |rows: usize, width: usize| {
        viewed(view, &tensor::<2>(normals(rows * width, &mut rng), [rows, width], device))
    };
    let ((of_radial, radial), (of_weight, weight)) = (matrix(count, 2), matrix(2, weights));
    let messages = form(&product, &features, radial, weight, &frames);
    let mut all: Vec<Vec<f64>> = messages.iter().map(values).collect();
    let parts = messages.into_iter().map(|message| weighed(message.swap_dims(0, 2), &mut rng));
    let gradients = parts.reduce(|a, b| a + b).expect("there are outputs").backward();
    let gradient = |gradient: Option<Tensor<3>>| values(&gradient.expect("features are tracked"));
    all.extend(owners.iter().map(|owner| gradient(owner.grad(&gradients))));
    all.extend(
        [of_radial, of_weight].map(|owner| values(&owner.grad(&gradients).expect("matrices are tracked"))),
    );
    all
}

pub(crate) fn edge_messages_do_not_depend_on_how_their_inputs_lie(tolerance: f64) {
    for (name, device) in devices() {
        let device = device.autodiff();
        let mut worst = 0.0;
        for list in &lists() {
            for sizes in [(0, 1), (1, 1), (2, 3)] {
                for view in VIEWS {
                    let say = |form| product(form, view, list, sizes, &device);
                    let found = apart(&say(edge_message::fused), &say(edge_message::composed));
                    assert!(found <= tolerance, "{name} {view:?} {sizes:?}: {found:e}");
                    worst = worse(worst, found);
                }
            }
        }
        assert_small(&format!("{name} edge messages of views"), worst, tolerance);
    }
}

/// Its gradient too: from a sum, where it is one number at every element, and from a transposed product.
pub(crate) fn silu_does_not_depend_on_how_its_input_lies(tolerance: f64) {
    for (name, device) in devices() {
        let device = device.autodiff();
        let plain: Tensor<3> = tensor(normals(60, &mut rng(58)), [3, 4, 5], &device);
        let host = values(&plain);
        let sigmoid = |x: f64| 1.0 / (1.0 + (-x).exp());
        let slope = |x: f64| sigmoid(x) * (1.0 + x * (1.0 - sigmoid(x)));
        for view in VIEWS {
            let (owner, input) = viewed(view, &plain);
            let output = silu(input.clone());
            let expected: Vec<f64> = host.iter().map(|&x| x * sigmoid(x)).collect();
            let error = worst_difference(&values(&output), &expected);
            assert_small(&format!("{name} silu, {view:?}"), error, tolerance);

            let factors: Tensor<3> = tensor(normals(60, &mut rng(59)), [5, 4, 3], &device);
            let loss = output.clone().sum() + (output.swap_dims(0, 2) * factors.clone()).sum();
            let gradients = loss.backward();
            let found = owner.grad(&gradients).expect("the input is tracked");
            // The same by the chain rule, put where the view reads it.
            let by_hand: Vec<f64> = (host.iter().zip(values(&factors.swap_dims(0, 2))))
                .map(|(&x, factor)| slope(x) * (1.0 + factor))
                .collect();
            let (owner, input) = viewed(view, &plain);
            let expected = (input * tensor(by_hand, [3, 4, 5], &device)).sum().backward();
            let expected = owner.grad(&expected).expect("the input is tracked");
            let error = worst_difference(&values(&found), &values(&expected));
            assert_small(&format!("{name} slope of silu, {view:?}"), error, 10.0 * tolerance);
        }
    }
}
