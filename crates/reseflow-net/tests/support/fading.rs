//! Where all neighbours of a point are about to stop being such, nothing is gathered, and nothing is divided by zero.

use burn::tensor::Tensor;
use reseflow_net::degrees::{FiberFeatures, NeighborAttentionConfig};

use super::degree_layers::{RADIAL_MLP, centre_edges, frames, uniform};
use super::fibers::HostFiber;
use super::gradients::{named_gradients, weighed};
use super::layers::{GRAPH, SHAKE, clouds};
use super::weights::shaken;
use super::world::World;
use super::{assert_small, devices, rng, values};

/// With the envelope times some number below one, attention gives that number times what it gave, although its weights are made relative
/// to one another; down to nothing, with finite gradients.
pub(crate) fn what_attention_gathers_fades_with_all_neighbours(tolerance: f64) {
    let (input, output) = (uniform(3, 3), uniform(3, 4));
    let config = NeighborAttentionConfig { input, output, heads: 2, radial: RADIAL_MLP };
    for (name, device) in devices() {
        let tracked = device.clone().autodiff();
        let mut rng = rng(9500);
        let lists = centre_edges(&clouds(&mut rng), &World::identity());
        let features = HostFiber::random(2 * GRAPH.centres, &input.fiber(), &mut rng);
        let layer = config.init(&tracked, &mut rng).expect("the heads divide the channels");
        let layer = shaken(layer, SHAKE, &mut rng);
        let faded = |fade: f64| {
            let mut edges = frames(&lists, 3, &tracked);
            edges.edges.weights = edges.edges.weights.mul_scalar(fade);
            let features = features.tensors(&tracked).degrees.into_iter().map(Tensor::require_grad);
            let features = FiberFeatures { degrees: features.collect() };
            let gathered = layer.forward(&features, &edges);
            let host = HostFiber::of(&gathered);
            let parts = gathered.degrees.into_iter().map(|degree| weighed(degree, &mut super::rng(9501)));
            let gradients = parts.reduce(|a, b| a + b).expect("there are scalars").backward();
            let mut slopes: Vec<f64> =
                named_gradients(&layer, &gradients).into_iter().flat_map(|(_, slopes)| slopes).collect();
            let of_features = features.degrees.iter().filter_map(|degree| degree.grad(&gradients));
            slopes.extend(of_features.flat_map(|gradient| values(&gradient)));
            (host, slopes)
        };
        let (whole, slopes) = faded(1.0);
        assert!(whole.size() > 0.1, "the output is not trivial");
        let steepest = slopes.iter().fold(0.0_f64, |most, slope| most.max(slope.abs()));
        for fade in [0.5, 1e-2, 1e-3] {
            let expected = HostFiber {
                points: whole.points,
                degrees: whole
                    .degrees
                    .iter()
                    .map(|all| all.iter().map(|value| fade * value).collect())
                    .collect(),
            };
            let error = faded(fade).0.difference(&expected) / expected.size();
            assert_small(&format!("{name} attention, envelope times {fade:e}"), error, tolerance);
        }
        for fade in [1e-6, 1e-9, 1e-12, 1e-20, 1e-30, 1e-42, 0.0] {
            let (gathered, slopes) = faded(fade);
            let size = gathered.size();
            assert!(size <= 1.01 * fade * whole.size(), "{name} envelope times {fade:e}: {size:e}");
            let most = slopes.iter().map(|slope| slope.abs()).fold(0.0, super::worse);
            assert!(most <= steepest, "{name} envelope times {fade:e}: a slope of {most:e}");
        }
    }
}
