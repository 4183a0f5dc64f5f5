//! Which points send to which: the nearest, or the nearest within a radius.
//!
//! Choosing is discontinuous, and rounding alone flips a near tie when a scene is turned. So distances are compared in f64, and a
//! message fades to zero as its source approaches where it would no longer be a neighbour: an envelope scaled by the (k+1)-th distance
//! or the radius, whichever is less. Where all neighbours lie at that border, the receiver hears nothing.

use crate::NetError;

/// How many neighbours a point has, and how far away they may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NeighborConfig {
    /// Edges per receiver, k, at least 1: no more than the k nearest send.
    pub per_receiver: usize,
    /// Sources at this distance in metres or farther do not send; without it the nearest do however far they are.
    pub radius_m: Option<f64>,
}

impl NeighborConfig {
    fn validate(&self) -> Result<(), NetError> {
        if self.per_receiver == 0 {
            return Err(NetError::Config("neighbors.per_receiver must be at least 1, got 0".to_owned()));
        }
        match self.radius_m {
            Some(radius) if radius.is_nan() || radius <= 0.0 => {
                Err(NetError::Config(format!("neighbors.radius_m must be greater than 0, got {radius}")))
            }
            _ => Ok(()),
        }
    }
}

/// Edges into M receivers, a fixed number each, grouped by receiver.
#[derive(Debug, Clone, PartialEq)]
pub struct EdgeList {
    /// Edges per receiver.
    pub per_receiver: usize,
    /// The sending node of each edge.
    pub sources: Vec<usize>,
    /// Source minus receiver, metres.
    pub displacement_m: Vec<[f64; 3]>,
    /// Envelope weights; those of one receiver sum to one, to less where all its neighbours are about to stop being such, and are zero
    /// where it has none.
    pub weights: Vec<f64>,
}

/// Envelopes of one receiver that sum to less than this are not scaled up to one: among sources that are all at the border, rounding
/// would say which counts.
const LEAST_TOTAL: f64 = 0.01;

impl EdgeList {
    /// Edges from `sources` to `receivers`, both in metres; a source at the very place of a receiver sends too.
    ///
    /// # Errors
    /// [`NetError::Config`] where there are no edges per receiver, or the radius is no length.
    pub fn between(
        receivers: &[[f64; 3]],
        sources: &[[f64; 3]],
        config: &NeighborConfig,
    ) -> Result<Self, NetError> {
        edges(receivers, sources, config, false)
    }

    /// Edges among `points`, in metres, none from a point to itself.
    ///
    /// # Errors
    /// As [`Self::between`].
    pub fn among(points: &[[f64; 3]], config: &NeighborConfig) -> Result<Self, NetError> {
        edges(points, points, config, true)
    }
}

pub(crate) fn sub(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn squared_norm(a: &[f64; 3]) -> f64 {
    a[0] * a[0] + a[1] * a[1] + a[2] * a[2]
}

/// With `skip_same`, a receiver is not its own neighbour.
fn edges(
    receivers: &[[f64; 3]],
    sources: &[[f64; 3]],
    config: &NeighborConfig,
    skip_same: bool,
) -> Result<EdgeList, NetError> {
    config.validate()?;
    let count = config.per_receiver;
    let mut edges = EdgeList {
        per_receiver: count,
        sources: Vec::with_capacity(receivers.len() * count),
        displacement_m: Vec::with_capacity(receivers.len() * count),
        weights: Vec::with_capacity(receivers.len() * count),
    };
    let reach = config.radius_m.map_or(f64::INFINITY, |radius| radius * radius);
    let mut order: Vec<(f64, usize)> = Vec::with_capacity(sources.len());
    for (receiver_index, receiver) in receivers.iter().enumerate() {
        order.clear();
        order.extend(
            (sources.iter().enumerate())
                .filter(|&(index, _)| !(skip_same && index == receiver_index))
                .map(|(index, source)| (squared_norm(&sub(source, receiver)), index))
                .filter(|entry| entry.0 < reach),
        );
        if order.len() > count {
            order.select_nth_unstable_by(count, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        }
        let farthest = order.iter().take(count + 1).map(|entry| entry.0).fold(0.0, f64::max).sqrt();
        let border = match config.radius_m {
            _ if order.len() > count => farthest,
            Some(radius) => radius,
            // Every source is a neighbour: nothing can be swapped at the border, and the farthest keeps some weight.
            None => 1.25 * farthest,
        };
        order.truncate(count);
        // A fixed order of summation, so that the same cloud gives the same bits.
        order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let weights: Vec<f64> = order.iter().map(|entry| envelope(entry.0.sqrt(), border)).collect();
        let total = weights.iter().sum::<f64>().max(LEAST_TOTAL);
        let mut filled = order.iter().zip(&weights);
        for _ in 0..count {
            match filled.next() {
                Some((&(_, index), weight)) => {
                    edges.sources.push(index);
                    edges.displacement_m.push(sub(&sources[index], receiver));
                    edges.weights.push(weight / total);
                }
                None => {
                    edges.sources.push(0);
                    edges.displacement_m.push([0.0; 3]);
                    edges.weights.push(0.0);
                }
            }
        }
    }
    Ok(edges)
}

/// 1 at the receiver, 0 with zero slope at `border` (1 everywhere where all sources coincide with the receiver).
fn envelope(distance: f64, border: f64) -> f64 {
    if border <= 0.0 {
        return 1.0;
    }
    let inside = (1.0 - (distance / border).powi(2)).max(0.0);
    inside * inside
}

#[cfg(test)]
mod tests {
    use super::*;

    fn nearest(per_receiver: usize) -> NeighborConfig {
        NeighborConfig { per_receiver, radius_m: None }
    }

    #[test]
    fn the_envelope_vanishes_at_the_first_point_left_out_and_weights_sum_to_one() {
        let points: Vec<_> = (0..10).map(|i| [0.01 * f64::from(i * i), 0.0, 0.0]).collect();
        let edges = EdgeList::between(&points, &points, &nearest(4)).unwrap();
        for weights in edges.weights.chunks(4) {
            assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        }
        assert_eq!(envelope(0.3, 0.3), 0.0);
        assert!(envelope(0.299, 0.3) < 1e-3);
    }

    #[test]
    fn a_radius_keeps_what_is_nearer_and_the_nearest_of_too_many() {
        let sources: Vec<_> = (1..=6).map(|i| [0.1 * f64::from(i), 0.0, 0.0]).collect();
        let within = |radius| {
            EdgeList::between(
                &[[0.0; 3]],
                &sources,
                &NeighborConfig { per_receiver: 4, radius_m: Some(radius) },
            )
            .unwrap()
        };
        let few = within(0.35);
        assert_eq!(few.sources[..3], [0, 1, 2]);
        assert_eq!(few.weights[3], 0.0, "{few:?}");
        let expected = [0.1, 0.2, 0.3].map(|distance| envelope(distance, 0.35));
        let total: f64 = expected.iter().sum();
        for (weight, expected) in few.weights.iter().zip(expected) {
            assert!((weight - expected / total).abs() < 1e-12, "{few:?}");
        }
        assert_eq!(within(10.0), EdgeList::between(&[[0.0; 3]], &sources, &nearest(4)).unwrap());
        assert_eq!(within(0.1).weights, [0.0; 4], "what is at the radius does not send");
        assert_eq!(
            EdgeList::among(&sources, &nearest(5)).unwrap().sources[..5],
            [1, 2, 3, 4, 5],
            "none to itself"
        );
    }

    /// At the radius, and where two sources change places, for one neighbour and for two.
    #[test]
    fn weights_of_lone_neighbours_do_not_jump() {
        let weight_of_first = |distance: f64, config: &NeighborConfig| {
            let sources = [[distance, 0.0, 0.0], [0.0, 0.2, 0.0], [0.0, 0.0, -0.2]];
            let edges = EdgeList::between(&[[0.0; 3]], &sources, config).unwrap();
            (edges.sources.iter().zip(&edges.weights))
                .filter(|(source, _)| **source == 0)
                .map(|(_, weight)| weight)
                .sum::<f64>()
        };
        let within = NeighborConfig { per_receiver: 1, radius_m: Some(0.15) };
        for (config, border) in [(nearest(1), 0.2), (nearest(2), 0.2), (within, 0.15)] {
            assert_eq!(weight_of_first(0.5 * border, &config), 1.0, "{config:?}");
            let mut last = weight_of_first(0.9 * border, &config);
            for step in 1..=400 {
                let next = weight_of_first(border * (0.9 + 0.0005 * f64::from(step)), &config);
                assert!((next - last).abs() < 0.02, "{config:?} jumps from {last} to {next}");
                last = next;
            }
            assert_eq!(last, 0.0, "{config:?}");
        }
    }

    #[test]
    fn no_edges_and_a_radius_that_is_no_length_are_refused() {
        let points = [[0.0; 3], [0.1, 0.0, 0.0]];
        for config in [
            nearest(0),
            NeighborConfig { per_receiver: 0, radius_m: Some(0.1) },
            NeighborConfig { per_receiver: 2, radius_m: Some(f64::NAN) },
            NeighborConfig { per_receiver: 2, radius_m: Some(-0.1) },
        ] {
            let key = if config.per_receiver == 0 { "neighbors.per_receiver" } else { "neighbors.radius_m" };
            for refused in [EdgeList::between(&points, &points, &config), EdgeList::among(&points, &config)] {
                let fault = refused.unwrap_err().to_string();
                assert!(fault.contains(key), "{config:?}: {fault}");
            }
        }
    }

    /// Three neighbours of every corner of a cube are equally far; turned, rounding orders them.
    #[test]
    fn rounding_does_not_choose_among_neighbours_that_are_equally_far() {
        let (sin, cos) = 0.7_f64.sin_cos();
        let corners: Vec<[f64; 3]> = (0..8)
            .map(|bits| [0, 1, 2].map(|axis| if bits >> axis & 1 == 0 { -0.1 } else { 0.1 }))
            .map(|[x, y, z]| [cos * x - sin * y, sin * x + cos * y, z])
            .map(|[x, y, z]| [x, cos * y - sin * z, sin * y + cos * z])
            .collect();
        let edges = EdgeList::among(&corners, &nearest(2)).unwrap();
        let heaviest = edges.weights.iter().copied().fold(0.0, f64::max);
        assert!(heaviest < 1e-20, "{heaviest:e}");
    }
}
