//! The neighbour graph of one cloud: farthest-point centres, and the nearest points and centres of every centre.
//!
//! Which points are chosen must not depend on how the scene is turned. All distances that decide are compared in f64; the first
//! centre is the point farthest from the centroid; and a message fades to zero as its source approaches the rank at which it would
//! no longer be a neighbour (an envelope scaled by the (k+1)-th distance), so that a near tie at the border changes nothing.

use serde::{Deserialize, Serialize};

use crate::NetError;

/// Sizes of the graph.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GraphConfig {
    /// Centres M chosen by farthest-point sampling.
    pub centres: usize,
    /// Points that send to each centre.
    pub point_neighbors: usize,
    /// Centres that send to each centre.
    pub centre_neighbors: usize,
    /// How far apart, in metres, two colours count that differ by half of a channel's range, when centres are chosen.
    pub color_m: f64,
}

impl Default for GraphConfig {
    fn default() -> Self {
        Self { centres: 32, point_neighbors: 16, centre_neighbors: 12, color_m: 0.1 }
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
    /// Envelope weights; those of one receiver sum to one, or are all zero where it has no neighbour.
    pub weights: Vec<f64>,
}

/// One cloud, centred, with its graph.
#[derive(Debug, Clone, PartialEq)]
pub struct CloudGraph {
    /// The mean of the points, world frame, metres.
    pub centroid_m: [f64; 3],
    /// The points relative to the centroid, metres.
    pub positions_m: Vec<[f64; 3]>,
    /// Their colours, each channel in \[-1, 1\].
    pub colors: Vec<[f64; 3]>,
    /// Indices of the M centres, in the order of choice.
    pub centres: Vec<usize>,
    /// Edges from points to centres; sources index points.
    pub point_edges: EdgeList,
    /// Edges among centres; sources index `centres`.
    pub centre_edges: EdgeList,
}

impl CloudGraph {
    /// Builds the graph. A cloud of fewer than M points repeats its centres in the order of choice.
    ///
    /// # Errors
    /// [`NetError::EmptyCloud`], [`NetError::NonFinitePoint`], and [`NetError::Mismatch`] where colours are missing.
    pub fn build(points: &[[f64; 3]], colors: &[[u8; 3]], config: &GraphConfig) -> Result<Self, NetError> {
        if points.is_empty() {
            return Err(NetError::EmptyCloud);
        }
        if points.len() != colors.len() {
            return Err(NetError::Mismatch { what: "colours", expected: points.len(), got: colors.len() });
        }
        if let Some(index) = points.iter().position(|point| point.iter().any(|value| !value.is_finite())) {
            return Err(NetError::NonFinitePoint { index });
        }
        let count = points.len() as f64;
        let centroid_m = [0, 1, 2].map(|axis| points.iter().map(|point| point[axis]).sum::<f64>() / count);
        let positions_m: Vec<_> = points.iter().map(|point| sub(point, &centroid_m)).collect();
        let colors: Vec<[f64; 3]> =
            colors.iter().map(|color| color.map(|value| f64::from(value) / 127.5 - 1.0)).collect();
        let centres = farthest_points(&positions_m, &colors, config);
        let centre_positions: Vec<_> = centres.iter().map(|&index| positions_m[index]).collect();
        let point_edges = nearest(&centre_positions, &positions_m, config.point_neighbors, false);
        let centre_edges = nearest(&centre_positions, &centre_positions, config.centre_neighbors, true);
        Ok(Self { centroid_m, positions_m, colors, centres, point_edges, centre_edges })
    }
}

fn sub(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn squared_norm(a: &[f64; 3]) -> f64 {
    a[0] * a[0] + a[1] * a[1] + a[2] * a[2]
}

/// Farthest-point sampling among the centred `positions` with their `colors`, starting with the one farthest from the origin.
fn farthest_points(positions: &[[f64; 3]], colors: &[[f64; 3]], config: &GraphConfig) -> Vec<usize> {
    let count = config.centres;
    let color_weight = config.color_m * config.color_m;
    let distinct = count.min(positions.len());
    let mut chosen = Vec::with_capacity(count);
    let mut distance: Vec<f64> = positions.iter().map(squared_norm).collect();
    let mut next = arg_max(&distance);
    distance.fill(f64::INFINITY);
    for _ in 0..distinct {
        chosen.push(next);
        let (centre, color) = (positions[next], colors[next]);
        for ((nearest, position), shade) in distance.iter_mut().zip(positions).zip(colors) {
            let apart =
                squared_norm(&sub(position, &centre)) + color_weight * squared_norm(&sub(shade, &color));
            *nearest = nearest.min(apart);
        }
        // A chosen point never comes again, even where points coincide.
        distance[next] = f64::NEG_INFINITY;
        next = arg_max(&distance);
    }
    for index in distinct..count {
        chosen.push(chosen[index - distinct]);
    }
    chosen
}

fn arg_max(values: &[f64]) -> usize {
    (0..values.len()).max_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap_or(0)
}

/// The `count` nearest of `sources` to each of `receivers`; with `skip_same`, a receiver is not its own neighbour.
fn nearest(receivers: &[[f64; 3]], sources: &[[f64; 3]], count: usize, skip_same: bool) -> EdgeList {
    let mut edges = EdgeList {
        per_receiver: count,
        sources: Vec::with_capacity(receivers.len() * count),
        displacement_m: Vec::with_capacity(receivers.len() * count),
        weights: Vec::with_capacity(receivers.len() * count),
    };
    let mut order: Vec<(f64, usize)> = Vec::with_capacity(sources.len());
    for (receiver_index, receiver) in receivers.iter().enumerate() {
        order.clear();
        order.extend(
            (sources.iter().enumerate())
                .filter(|&(index, _)| !(skip_same && index == receiver_index))
                .map(|(index, source)| (squared_norm(&sub(source, receiver)), index)),
        );
        if order.len() > count {
            order.select_nth_unstable_by(count, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        }
        let farthest = order.iter().take(count + 1).map(|entry| entry.0).fold(0.0, f64::max).sqrt();
        // Where every source is a neighbour nothing can be swapped at the border, and the farthest keeps some weight.
        let radius = if order.len() > count { farthest } else { 1.25 * farthest };
        order.truncate(count);
        // A fixed order of summation, so that the same cloud gives the same bits.
        order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let weights: Vec<f64> = order.iter().map(|entry| envelope(entry.0.sqrt(), radius)).collect();
        let total: f64 = weights.iter().sum();
        let mut filled = order.iter().zip(&weights);
        for _ in 0..count {
            match filled.next() {
                Some((&(_, index), weight)) => {
                    edges.sources.push(index);
                    edges.displacement_m.push(sub(&sources[index], receiver));
                    edges.weights.push(if total > 0.0 { weight / total } else { 0.0 });
                }
                None => {
                    edges.sources.push(0);
                    edges.displacement_m.push([0.0; 3]);
                    edges.weights.push(0.0);
                }
            }
        }
    }
    edges
}

/// 1 at the receiver, 0 with zero slope at `radius` (1 everywhere where all sources coincide with the receiver).
fn envelope(distance: f64, radius: f64) -> f64 {
    if radius <= 0.0 {
        return 1.0;
    }
    let inside = (1.0 - (distance / radius).powi(2)).max(0.0);
    inside * inside
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(count: usize) -> (Vec<[f64; 3]>, Vec<[u8; 3]>) {
        ((0..count).map(|i| [0.01 * (i * i) as f64, 0.0, 0.0]).collect(), vec![[255, 0, 128]; count])
    }

    #[test]
    fn centres_start_at_the_point_farthest_from_the_centroid_and_spread_out() {
        let (points, colors) = line(10);
        let config = GraphConfig { centres: 3, point_neighbors: 4, centre_neighbors: 2, color_m: 0.0 };
        let graph = CloudGraph::build(&points, &colors, &config).unwrap();
        assert_eq!(graph.centres[0], 9);
        assert_eq!(graph.centres[1], 0);
        assert_eq!(
            graph.centres[2], 6,
            "the point whose nearest chosen one is farthest: {:?}",
            graph.centres
        );
    }

    #[test]
    fn points_of_another_colour_become_centres_where_colours_count() {
        let (points, mut colors) = line(10);
        // The third point is 4 cm from the origin, and green.
        colors[2] = [0, 255, 0];
        let chosen = |color_m| {
            let config = GraphConfig { centres: 4, point_neighbors: 4, centre_neighbors: 2, color_m };
            CloudGraph::build(&points, &colors, &config).unwrap().centres
        };
        assert!(!chosen(0.0).contains(&2), "{:?}", chosen(0.0));
        assert!(chosen(0.2).contains(&2), "{:?}", chosen(0.2));
    }

    #[test]
    fn the_envelope_vanishes_at_the_first_point_left_out_and_weights_sum_to_one() {
        let (points, colors) = line(10);
        let config = GraphConfig { centres: 10, point_neighbors: 4, centre_neighbors: 3, color_m: 0.0 };
        let graph = CloudGraph::build(&points, &colors, &config).unwrap();
        for weights in graph.point_edges.weights.chunks(4) {
            assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        }
        assert_eq!(envelope(0.3, 0.3), 0.0);
        assert!(envelope(0.299, 0.3) < 1e-3);
    }

    #[test]
    fn small_clouds_are_padded_and_degenerate_ones_stay_finite() {
        let config = GraphConfig { centres: 4, point_neighbors: 3, centre_neighbors: 2, color_m: 0.0 };
        for points in [vec![[0.1, 0.2, 0.3]], vec![[1.0, 1.0, 1.0]; 6]] {
            let graph = CloudGraph::build(&points, &vec![[0; 3]; points.len()], &config).unwrap();
            assert_eq!(graph.centres.len(), 4);
            assert_eq!(graph.point_edges.sources.len(), 12);
            assert!(graph.point_edges.weights.iter().all(|weight| weight.is_finite()));
        }
    }

    #[test]
    fn bad_clouds_are_refused() {
        let config = GraphConfig::default();
        assert_eq!(CloudGraph::build(&[], &[], &config), Err(NetError::EmptyCloud));
        assert_eq!(
            CloudGraph::build(&[[0.0; 3], [f64::NAN, 0.0, 0.0]], &[[0; 3]; 2], &config),
            Err(NetError::NonFinitePoint { index: 1 })
        );
        assert!(matches!(CloudGraph::build(&[[0.0; 3]], &[], &config), Err(NetError::Mismatch { .. })));
    }
}
