//! Features of degrees 0 … l_max on the host in f64, and how a layer of them is checked; [`super::features`] for any degree.

use burn::tensor::Device;
use rand_chacha::ChaCha8Rng;
use reseflow_net::degrees::{Fiber, FiberFeatures};
use reseflow_net::irreps::{WignerMatrices, components};

use super::world::World;
use super::{normals, tensor, values, worse, worst_difference};

/// Features of P points; the layout of [`FiberFeatures`].
#[derive(Debug, Clone)]
pub(crate) struct HostFiber {
    pub(crate) points: usize,
    pub(crate) degrees: Vec<Vec<f64>>,
}

impl HostFiber {
    pub(crate) fn random(points: usize, fiber: &Fiber, rng: &mut ChaCha8Rng) -> HostFiber {
        let channels = fiber.channels.iter().enumerate();
        let degree =
            |(degree, channels): (usize, &usize)| normals(components(degree) * points * channels, rng);
        HostFiber { points, degrees: channels.map(degree).collect() }
    }

    pub(crate) fn of(features: &FiberFeatures) -> HostFiber {
        HostFiber { points: features.points(), degrees: features.degrees.iter().map(values).collect() }
    }

    pub(crate) fn tensors(&self, device: &Device) -> FiberFeatures {
        let degree = |(degree, all): (usize, &Vec<f64>)| {
            let channels = all.len() / components(degree) / self.points;
            tensor(all.clone(), [components(degree), self.points, channels], device)
        };
        FiberFeatures { degrees: self.degrees.iter().enumerate().map(degree).collect() }
    }

    /// The same features in a world moved by `world`; under a reflection degree l changes sign as l vectors do.
    pub(crate) fn moved(&self, world: &World) -> HostFiber {
        let handedness = world.turn.determinant().signum();
        let turn = world.turn * handedness;
        let rows = [0, 1, 2].map(|row| [0, 1, 2].map(|column| turn[(row, column)]));
        let matrices = WignerMatrices::new(self.degrees.len() - 1, &rows);
        let degree = |(degree, all): (usize, &Vec<f64>)| {
            let sign = if degree % 2 == 1 { handedness } else { 1.0 };
            let stride = all.len() / components(degree);
            let mut moved = vec![0.0; all.len()];
            for (row, entries) in matrices.blocks[degree].chunks_exact(components(degree)).enumerate() {
                for (column, entry) in entries.iter().enumerate() {
                    for index in 0..stride {
                        moved[row * stride + index] += sign * entry * all[column * stride + index];
                    }
                }
            }
            moved
        };
        HostFiber { points: self.points, degrees: self.degrees.iter().enumerate().map(degree).collect() }
    }

    pub(crate) fn difference(&self, other: &HostFiber) -> f64 {
        let degrees = self.degrees.iter().zip(&other.degrees);
        degrees.map(|(a, b)| worst_difference(a, b)).fold(0.0, worse)
    }

    /// The largest number in it.
    pub(crate) fn size(&self) -> f64 {
        self.degrees.iter().flatten().fold(0.0, |size, value| worse(size, value.abs()))
    }
}

/// The largest |f(g x) − g f(x)| over `worlds`, relative to the largest number of f(x) where that exceeds one.
pub(crate) fn fiber_deviation(worlds: &[World], layer: impl Fn(&World) -> HostFiber) -> f64 {
    let still = layer(&World::identity());
    let size = still.size().max(1.0);
    worlds.iter().map(|world| layer(world).difference(&still.moved(world)) / size).fold(0.0, worse)
}
