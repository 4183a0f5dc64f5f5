//! Features of degrees 0 … l_max: how many channels each degree has, and one tensor per degree.
//!
//! As for degree 1 in [`crate::Features`], the axis of the 2l + 1 components comes first: a channel mixing is one matrix product,
//! and what is invariant broadcasts along the outermost axis.

use std::ops::Add;

use burn::tensor::Tensor;
use serde::{Deserialize, Serialize};

use crate::Features;
use crate::irreps::{components, components_up_to};
use crate::shape::must_be;

/// The channels of every degree from 0 on, each at least 1.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fiber {
    /// Channels by degree.
    pub channels: Vec<usize>,
}

/// C channels in every degree 0 … l_max.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct UniformFiber {
    /// The highest degree l_max.
    pub max_degree: usize,
    /// Channels C of each degree.
    pub channels: usize,
}

impl UniformFiber {
    /// As channels by degree.
    pub fn fiber(&self) -> Fiber {
        Fiber { channels: self.by_degree().collect() }
    }

    /// The channels of every degree.
    pub(crate) fn by_degree(&self) -> impl ExactSizeIterator<Item = usize> + use<> {
        std::iter::repeat_n(self.channels, self.max_degree + 1)
    }
}

impl Fiber {
    /// The highest degree l_max.
    pub fn max_degree(&self) -> usize {
        self.channels.len().saturating_sub(1)
    }

    /// Channels of the concatenation with `other`, degree by degree.
    pub fn concat(&self, other: &Fiber) -> Fiber {
        let channels = |fiber: &Fiber, degree: usize| fiber.channels.get(degree).copied().unwrap_or(0);
        let degrees = 0..self.channels.len().max(other.channels.len());
        Fiber { channels: degrees.map(|degree| channels(self, degree) + channels(other, degree)).collect() }
    }
}

/// Features of P points; degree l is turned by Dˡ along the first axis.
#[derive(Debug, Clone)]
pub struct FiberFeatures {
    /// By degree, `[2l + 1, P, Cₗ]`.
    pub degrees: Vec<Tensor<3>>,
}

impl FiberFeatures {
    /// The channels of every degree.
    pub fn fiber(&self) -> Fiber {
        Fiber { channels: self.degrees.iter().map(|degree| degree.dims()[2]).collect() }
    }

    /// The number of points P.
    pub fn points(&self) -> usize {
        self.degrees.first().map_or(0, |scalars| scalars.dims()[1])
    }

    /// Panics where degree l of the features that `whose` forward pass got is not `[2l + 1, P, Cₗ]` with as many points P as degree 0,
    /// for each degree that `channels` speaks of; others are not looked at.
    #[track_caller]
    pub(crate) fn must_have(&self, whose: &str, channels: impl IntoIterator<Item = usize>) {
        let points = self.points();
        for (degree, channels) in channels.into_iter().enumerate() {
            let found = self.degrees.get(degree).map(|tensor| tensor.dims());
            let expected = [components(degree), points, channels];
            must_be(format_args!("{whose}: features of degree {degree}"), Some(expected), found);
        }
    }

    /// As [`Self::must_have`], and panics where there are other degrees.
    #[track_caller]
    pub(crate) fn must_be_of(&self, whose: &str, channels: impl ExactSizeIterator<Item = usize>) {
        must_be(format_args!("{whose}: number of degrees"), channels.len(), self.degrees.len());
        self.must_have(whose, channels);
    }

    /// Degree 0 without its axis of one component, `[P, C₀]`.
    pub fn scalars(&self) -> Tensor<2> {
        let [_, points, channels] = self.degrees[0].dims();
        self.degrees[0].clone().reshape([points, channels])
    }

    /// Channels of both, degree by degree; a degree that only one has is taken from it.
    ///
    /// # Panics
    /// Where the numbers of points differ.
    pub fn concat(self, other: FiberFeatures) -> FiberFeatures {
        must_be("concat: points", self.points(), other.points());
        self.zip(other, |a, b| Tensor::cat(vec![a, b], 2))
    }

    /// Joins two degree by degree.
    fn zip(self, other: FiberFeatures, join: impl Fn(Tensor<3>, Tensor<3>) -> Tensor<3>) -> FiberFeatures {
        let (mut first, mut second) = (self.degrees.into_iter(), other.degrees.into_iter());
        let mut degrees = Vec::new();
        loop {
            degrees.push(match (first.next(), second.next()) {
                (Some(a), Some(b)) => join(a, b),
                (Some(only), None) | (None, Some(only)) => only,
                (None, None) => return FiberFeatures { degrees },
            });
        }
    }

    /// All components of degrees 0 … `max_degree` side by side; these must have the same number of channels.
    ///
    /// # Shapes
    /// - output: `[P, (l_max + 1)², C]`
    pub(crate) fn stacked(&self, max_degree: usize) -> Tensor<3> {
        let channels = self.degrees.first().map_or(0, |scalars| scalars.dims()[2]);
        self.must_have("features side by side", UniformFiber { max_degree, channels }.by_degree());
        let degrees = self.degrees[..=max_degree].to_vec();
        let stacked = if degrees.len() == 1 { degrees[0].clone() } else { Tensor::cat(degrees, 0) };
        stacked.swap_dims(0, 1)
    }

    /// The inverse of [`Self::stacked`].
    pub(crate) fn unstacked(max_degree: usize, stacked: Tensor<3>) -> FiberFeatures {
        debug_assert_eq!(stacked.dims()[1], components_up_to(max_degree));
        let stacked = stacked.swap_dims(0, 1);
        let degree = |l: usize| stacked.clone().narrow(0, l * l, components(l));
        FiberFeatures { degrees: (0..=max_degree).map(degree).collect() }
    }

    /// √(‖x‖² + ε²) of every channel of every degree, invariant and smooth.
    ///
    /// # Shapes
    /// - output: by degree, `[1, P, Cₗ]`
    pub fn soft_norms(&self, epsilon: f64) -> Vec<Tensor<3>> {
        let norm =
            |degree: &Tensor<3>| degree.clone().square().sum_dim(0).add_scalar(epsilon * epsilon).sqrt();
        self.degrees.iter().map(norm).collect()
    }
}

impl Add for FiberFeatures {
    type Output = FiberFeatures;

    /// The sum, degree by degree; a degree that only one has is taken from it.
    ///
    /// # Panics
    /// Where the numbers of points, or the channels of a degree that both have, differ.
    fn add(self, other: FiberFeatures) -> FiberFeatures {
        self.zip(other, |a, b| {
            must_be("sum of features", a.dims(), b.dims());
            a + b
        })
    }
}

impl From<Features> for FiberFeatures {
    /// Scalars as degree 0 and vectors as degree 1, which is (x, y, z) in both.
    fn from(features: Features) -> Self {
        let [points, channels] = features.scalars.dims();
        FiberFeatures { degrees: vec![features.scalars.reshape([1, points, channels]), features.vectors] }
    }
}
