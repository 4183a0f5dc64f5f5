//! Messages of all degrees and silu, operations with backward passes of their own, against what they stand for.

use burn::tensor::{Device, Tensor};
use reseflow_net::degrees::edge_message::{composed, fused};
use reseflow_net::degrees::{EdgeFrames, EdgeProduct, FiberFeatures, UniformFiber};
use reseflow_net::silu::silu;

use super::degree_layers::{centre_edges, frames, uniform};
use super::fibers::HostFiber;
use super::gradients::weighed;
use super::layers::{GRAPH, clouds};
use super::world::World;
use super::{assert_small, devices, normals, rng, tensor, values, worse, worst_difference};

type Form = fn(&EdgeProduct, &FiberFeatures, Tensor<2>, Tensor<2>, &EdgeFrames) -> Vec<Tensor<3>>;

/// The degree of the frames, the input and the outputs.
const SHAPES: [(usize, UniformFiber, &[UniformFiber]); 6] = [
    (3, uniform(3, 4), &[uniform(3, 2), uniform(3, 3)]),
    (3, uniform(2, 3), &[uniform(1, 5), uniform(3, 2)]),
    (2, uniform(0, 6), &[uniform(2, 3)]),
    (3, uniform(3, 2), &[uniform(0, 4)]),
    (1, uniform(1, 1), &[uniform(1, 1)]),
    (0, uniform(0, 3), &[uniform(0, 2), uniform(0, 1)]),
];

/// Radial features of an edge.
const RADIAL: usize = 7;

/// What a form gives: its outputs, and the gradients of a random linear function of them by features, radial features and matrix.
fn outcome(
    form: Form,
    (frame_degree, input, outputs): (usize, UniformFiber, &[UniformFiber]),
    device: &Device,
) -> Vec<Vec<f64>> {
    let device = device.clone().autodiff();
    let mut rng = rng(51);
    let product = EdgeProduct { input, outputs: outputs.to_vec() };
    let edges = frames(&centre_edges(&clouds(&mut rng), &World::identity()), frame_degree, &device);
    let count = 2 * GRAPH.centres * GRAPH.centre_neighbors;
    let features = HostFiber::random(2 * GRAPH.centres, &input.fiber(), &mut rng).tensors(&device);
    let features =
        FiberFeatures { degrees: features.degrees.into_iter().map(Tensor::require_grad).collect() };
    let radial = tensor(normals(count * RADIAL, &mut rng), [count, RADIAL], &device).require_grad();
    let weights = product.weight_count();
    let weight = tensor(normals(RADIAL * weights, &mut rng), [RADIAL, weights], &device).require_grad();
    let messages = form(&product, &features, radial.clone(), weight.clone(), &edges);
    let mut all: Vec<Vec<f64>> = messages.iter().map(values).collect();
    let loss = messages.into_iter().map(|message| weighed(message, &mut rng)).reduce(|a, b| a + b);
    let gradients = loss.expect("there is an output").backward();
    for degree in &features.degrees {
        all.push(values(&degree.grad(&gradients).expect("features have a gradient")));
    }
    for matrix in [radial, weight] {
        all.push(values(&matrix.grad(&gradients).expect("matrices have a gradient")));
    }
    all
}

/// Relative to the largest number of each output and gradient.
pub(crate) fn the_edge_messages_equal_their_composed_form(tolerance: f64) {
    for (name, device) in devices() {
        for shape in SHAPES {
            let (fast, plain) = (outcome(fused, shape, &device), outcome(composed, shape, &device));
            assert_eq!(fast.len(), plain.len());
            let apart = fast.iter().zip(&plain).map(|(fast, plain)| {
                let size = plain.iter().fold(0.0, |size, value| worse(size, value.abs()));
                assert!(size > 1e-2, "the comparison is not trivial");
                worst_difference(fast, plain) / size
            });
            let worst = apart.fold(0.0, worse);
            assert_small(&format!("{name} edge messages of {shape:?}"), worst, tolerance);
        }
    }
}

pub(crate) fn silu_is_x_over_one_plus_exp_of_minus_x(tolerance: f64) {
    for (name, device) in devices() {
        let host: Vec<f64> = (-4000..=4000).map(|step| f64::from(step) * 0.01).collect();
        let sigmoid = |x: f64| 1.0 / (1.0 + (-x).exp());
        let input = tensor(host.clone(), [9, 889], &device.clone().autodiff()).require_grad();
        // Out of order in memory, and weighed by something that is not constant.
        let output = silu(input.clone().swap_dims(0, 1));
        let expected: Vec<f64> = host.iter().map(|&x| x * sigmoid(x)).collect();
        let found = values(&output.clone().swap_dims(0, 1));
        assert_small(&format!("{name} silu"), relative(&found, &expected), tolerance);
        let gradients = (output.clone() * output).sum().backward();
        let slope = |&x: &f64| 2.0 * x * sigmoid(x) * (sigmoid(x) + x * sigmoid(x) * (1.0 - sigmoid(x)));
        let expected: Vec<f64> = host.iter().map(slope).collect();
        let found = values(&input.grad(&gradients).expect("the input has a gradient"));
        assert_small(&format!("{name} slope of silu"), relative(&found, &expected), 4.0 * tolerance);
    }
}

/// The largest difference, over the expected number where that exceeds one.
fn relative(found: &[f64], expected: &[f64]) -> f64 {
    let pairs = found.iter().zip(expected);
    pairs.map(|(found, expected)| (found - expected).abs() / expected.abs().max(1.0)).fold(0.0, worse)
}
