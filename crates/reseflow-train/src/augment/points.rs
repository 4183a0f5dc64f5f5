//! What is done to points one by one: some left out, all moved a little, and their colours turned.

use std::f64::consts::TAU;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use reseflow_data::PointCloud;
use reseflow_lie::{SO3, Vector3};

/// Leaves out a random share of the points, uniform in 0 … `share`; those that stay keep their order.
pub(crate) fn drop_points(cloud: &mut PointCloud, share: f64, rng: &mut ChaCha8Rng) {
    if share == 0.0 || cloud.is_empty() {
        return;
    }
    let count = cloud.len();
    let most = (share * count as f64).floor() as usize;
    let dropped = rng.random_range(0..=most);
    // Walking over the points, each goes with the chance that makes every set of `dropped` points equally likely.
    let mut left = dropped;
    let keep: Vec<bool> = (0..count)
        .map(|index| {
            let drop = rng.random_range(0..count - index) < left;
            left -= usize::from(drop);
            !drop
        })
        .collect();
    let mut kept = keep.iter();
    cloud.points.retain(|_| kept.next().is_some_and(|keep| *keep));
    let mut kept = keep.iter();
    cloud.colors.retain(|_| kept.next().is_some_and(|keep| *keep));
}

/// Moves every point by independent noise.
pub(crate) fn jitter(cloud: &mut PointCloud, sigma_m: f64, rng: &mut ChaCha8Rng) {
    if let Ok(noise) = Normal::new(0.0, sigma_m) {
        for value in cloud.points.iter_mut().flatten() {
            *value += noise.sample(rng) as f32;
        }
    }
}

/// A turn of all colours about the grey axis: hues move on, greys stay.
#[derive(Debug, Clone, Copy)]
pub(super) struct HueTurn(SO3);

impl HueTurn {
    /// A turn drawn uniformly from ± `largest` of a whole circle; `None` where that is zero.
    pub(super) fn draw(largest: f64, rng: &mut ChaCha8Rng) -> Option<Self> {
        (largest > 0.0).then(|| Self::by(TAU * rng.random_range(-largest..=largest)))
    }

    fn by(angle_rad: f64) -> Self {
        Self(SO3::exp(&(Vector3::repeat(1.0).normalize() * angle_rad)))
    }

    /// Turns `colors`; what would leave the range of colours is clamped to it.
    pub(super) fn colors(&self, colors: &mut [[u8; 3]]) {
        for color in colors {
            let turned = self.0.act(&Vector3::from(color.map(f64::from)));
            *color = turned.map(|value| value.round().clamp(0.0, 255.0) as u8).into();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::rand_core::SeedableRng;

    fn rng(seed: u64) -> ChaCha8Rng {
        ChaCha8Rng::seed_from_u64(seed)
    }

    /// A cloud whose points and colours tell their index.
    fn cloud(count: u8) -> PointCloud {
        let points = (0..count).map(|i| [f32::from(i), 0.1 * f32::from(i % 7), -0.5]);
        PointCloud { points: points.collect(), colors: (0..count).map(|i| [i, 0, 0]).collect() }
    }

    #[test]
    fn a_thinned_cloud_keeps_at_least_its_share_in_order_with_its_colours() {
        let whole = cloud(101);
        let mut counts = Vec::new();
        let mut seen = [0_usize; 101];
        for seed in 0..400 {
            let mut thinned = whole.clone();
            drop_points(&mut thinned, 0.5, &mut rng(seed));
            assert_eq!(thinned.points.len(), thinned.colors.len());
            assert!(2 * thinned.len() >= whole.len(), "{} of 101 points are left", thinned.len());
            let indices: Vec<usize> = thinned.points.iter().map(|point| point[0] as usize).collect();
            assert!(indices.is_sorted_by(|a, b| a < b), "the order changed: {indices:?}");
            for (&index, color) in indices.iter().zip(&thinned.colors) {
                assert_eq!(usize::from(color[0]), index, "a point has another one's colour");
                seen[index] += 1;
            }
            counts.push(thinned.len());
        }
        assert!(counts.iter().min() < Some(&60) && counts.iter().max() > Some(&95), "{counts:?}");
        // On average three quarters stay, and no place in the list is favoured (400 draws: five standard deviations are 45).
        assert!(seen.iter().all(|times| times.abs_diff(300) < 50), "{seen:?}");
    }

    #[test]
    fn a_third_of_a_circle_takes_red_to_green_and_leaves_grey() {
        let mut colors = [[200, 0, 0], [0, 200, 0], [90, 90, 90], [255, 255, 255]];
        HueTurn::by(TAU / 3.0).colors(&mut colors);
        assert_eq!(colors, [[0, 200, 0], [0, 0, 200], [90, 90, 90], [255, 255, 255]]);
    }
}
