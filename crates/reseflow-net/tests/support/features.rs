//! Features on the host in f64, so that what a layer is given is moved without rounding to the suite's float type first.

use burn::tensor::Device;
use rand_chacha::ChaCha8Rng;
use reseflow_net::Features;

use super::world::World;
use super::{normals, tensor, values, worse, worst_difference};

/// Features of P points; the layout of [`Features`].
#[derive(Debug, Clone)]
pub(crate) struct HostFeatures {
    pub(crate) points: usize,
    pub(crate) scalars: Vec<f64>,
    pub(crate) vectors: Vec<f64>,
}

impl HostFeatures {
    /// Standard normal features with these scalar and vector channels.
    pub(crate) fn random(points: usize, channels: [usize; 2], rng: &mut ChaCha8Rng) -> HostFeatures {
        HostFeatures {
            points,
            scalars: normals(points * channels[0], rng),
            vectors: normals(3 * points * channels[1], rng),
        }
    }

    pub(crate) fn of(features: &Features) -> HostFeatures {
        HostFeatures {
            points: features.scalars.dims()[0],
            scalars: values(&features.scalars),
            vectors: values(&features.vectors),
        }
    }

    pub(crate) fn tensors(&self, device: &Device) -> Features {
        let points = self.points;
        Features {
            scalars: tensor(self.scalars.clone(), [points, self.scalars.len() / points], device),
            vectors: tensor(self.vectors.clone(), [3, points, self.vectors.len() / points / 3], device),
        }
    }

    /// The same features in a world moved by `world`: vectors turn, scalars stay.
    pub(crate) fn moved(&self, world: &World) -> HostFeatures {
        let stride = self.vectors.len() / 3;
        let mut vectors = vec![0.0; 3 * stride];
        for index in 0..stride {
            let turned = world.vector(&[0, 1, 2].map(|axis| self.vectors[axis * stride + index]));
            for (axis, value) in turned.into_iter().enumerate() {
                vectors[axis * stride + index] = value;
            }
        }
        HostFeatures { vectors, ..self.clone() }
    }

    pub(crate) fn difference(&self, other: &HostFeatures) -> f64 {
        worse(
            worst_difference(&self.scalars, &other.scalars),
            worst_difference(&self.vectors, &other.vectors),
        )
    }
}

/// The largest |f(g x) − g f(x)| over `worlds`, where `layer` is handed g and says f(g x).
///
/// This one check is what every layer must pass and every control must fail.
pub(crate) fn deviation(worlds: &[World], layer: impl Fn(&World) -> HostFeatures) -> f64 {
    let still = layer(&World::identity());
    worlds.iter().map(|world| layer(world).difference(&still.moved(world))).fold(0.0, worse)
}
