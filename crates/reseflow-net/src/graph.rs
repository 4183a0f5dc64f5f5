//! The neighbour graph of one cloud: farthest-point centres, and the nearest points and centres of every centre.
//!
//! Which points are chosen must not depend on how the scene is turned: all distances that decide are compared in f64, and the first
//! centre is the point farthest from the centroid.

use serde::{Deserialize, Serialize};

use crate::error::check_numbers;
use crate::neighbors::{squared_norm, sub};
use crate::{EdgeList, NeighborConfig, NetError};

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

impl GraphConfig {
    /// Refuses sizes that make no graph; `key` is what the configuration calls it.
    pub(crate) fn validate(&self, key: &str) -> Result<(), NetError> {
        for (size, value) in [
            ("centres", self.centres),
            ("point_neighbors", self.point_neighbors),
            ("centre_neighbors", self.centre_neighbors),
        ] {
            if value == 0 {
                return Err(NetError::Config(format!("{key}.{size} must be at least 1, got 0")));
            }
        }
        let color_m = self.color_m;
        if !(color_m.is_finite() && color_m >= 0.0) {
            return Err(NetError::Config(format!("{key}.color_m must be at least 0, got {color_m}")));
        }
        Ok(())
    }
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
    /// [`NetError::EmptyCloud`], [`NetError::NonFinitePoint`], [`NetError::OutOfRange`] where a coordinate is beyond 1e6 m,
    /// [`NetError::Mismatch`] where colours are missing, and [`NetError::Config`] where a size makes no sense.
    pub fn build(points: &[[f64; 3]], colors: &[[u8; 3]], config: &GraphConfig) -> Result<Self, NetError> {
        config.validate("graph")?;
        if points.is_empty() {
            return Err(NetError::EmptyCloud);
        }
        if points.len() != colors.len() {
            return Err(NetError::Mismatch { what: "colours", expected: points.len(), got: colors.len() });
        }
        if let Some(index) = points.iter().position(|point| point.iter().any(|value| !value.is_finite())) {
            return Err(NetError::NonFinitePoint { index });
        }
        for (index, point) in points.iter().enumerate() {
            check_numbers("point", index, *point)?;
        }
        let count = points.len() as f64;
        let centroid_m = [0, 1, 2].map(|axis| points.iter().map(|point| point[axis]).sum::<f64>() / count);
        let positions_m: Vec<_> = points.iter().map(|point| sub(point, &centroid_m)).collect();
        let colors: Vec<[f64; 3]> =
            colors.iter().map(|color| color.map(|value| f64::from(value) / 127.5 - 1.0)).collect();
        let centres = farthest_points(&positions_m, &colors, config);
        let centre_positions: Vec<_> = centres.iter().map(|&index| positions_m[index]).collect();
        let nearest = |per_receiver| NeighborConfig { per_receiver, radius_m: None };
        let point_edges =
            EdgeList::between(&centre_positions, &positions_m, &nearest(config.point_neighbors))?;
        let centre_edges = EdgeList::among(&centre_positions, &nearest(config.centre_neighbors))?;
        Ok(Self { centroid_m, positions_m, colors, centres, point_edges, centre_edges })
    }
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
        for far_m in [2e6, -1e30, f64::MAX] {
            assert_eq!(
                CloudGraph::build(&[[0.0; 3], [0.0, 0.0, far_m]], &[[0; 3]; 2], &config),
                Err(NetError::OutOfRange { what: "point", index: 1 })
            );
        }
        let edge = CloudGraph::build(&[[0.0; 3], [0.0, 0.0, 1e6]], &[[0; 3]; 2], &config);
        assert!(edge.is_ok(), "the farthest that is allowed: {edge:?}");
    }

    #[test]
    fn sizes_that_make_no_graph_are_refused() {
        let build = |config| CloudGraph::build(&[[0.0; 3]], &[[0; 3]], &config);
        let sound = GraphConfig::default();
        for (key, config) in [
            ("graph.centres", GraphConfig { centres: 0, ..sound }),
            ("graph.point_neighbors", GraphConfig { point_neighbors: 0, ..sound }),
            ("graph.centre_neighbors", GraphConfig { centre_neighbors: 0, ..sound }),
            ("graph.color_m", GraphConfig { color_m: f64::NAN, ..sound }),
        ] {
            let fault = build(config).unwrap_err().to_string();
            assert!(fault.contains(key), "{key}: {fault}");
        }
        assert!(build(sound).is_ok());
    }
}
