//! The choice of N points from all that a camera measured, by their visible colour.

use reseflow_data::PointCloud;
use serde::{Deserialize, Serialize};

use super::farthest::farthest;
use super::is_salient;

/// At least this many points are salient when anything salient is in view (half of the cloud, where that is fewer).
const SALIENT_MINIMUM: usize = 24;

/// How N points are chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Selection {
    /// Half by farthest-point sampling over salient colours, half by the same over the rest.
    Salient,
    /// Farthest-point sampling over everything.
    Farthest,
}

/// How many salient points a cloud of `points` must hold where any is visible.
pub(super) fn salient_minimum(points: usize) -> usize {
    SALIENT_MINIMUM.min(points / 2)
}

/// Chooses `points` of the candidates, or all of them where there are fewer.
pub(super) fn select(candidates: &PointCloud, points: usize, selection: Selection) -> PointCloud {
    let chosen = match selection {
        Selection::Farthest => farthest(&candidates.points, points),
        Selection::Salient => {
            let (salient, rest): (Vec<usize>, Vec<usize>) =
                (0..candidates.len()).partition(|&i| is_salient(candidates.colors[i]));
            let salient_count = salient.len().min((points / 2).max(points.saturating_sub(rest.len())));
            let mut chosen = farthest_of(candidates, &salient, salient_count);
            chosen.extend(farthest_of(candidates, &rest, points.saturating_sub(salient_count)));
            chosen
        }
    };
    PointCloud {
        points: chosen.iter().map(|&i| candidates.points[i]).collect(),
        colors: chosen.iter().map(|&i| candidates.colors[i]).collect(),
    }
}

/// `count` of the candidates `pool` by farthest-point sampling.
fn farthest_of(cloud: &PointCloud, pool: &[usize], count: usize) -> Vec<usize> {
    let points: Vec<[f32; 3]> = pool.iter().map(|&index| cloud.points[index]).collect();
    farthest(&points, count).into_iter().map(|position| pool[position]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A 10 × 10 grid of grey points and `salient` red ones beside it.
    fn cloud(salient: usize) -> PointCloud {
        let grey = (0..100).map(|i| ([(i % 10) as f32, (i / 10) as f32, 0.0], [120; 3]));
        let red = (0..salient).map(|i| ([20.0 + i as f32, 0.0, 0.0], [230, 20, 20]));
        let (points, colors) = grey.chain(red).unzip();
        PointCloud { points, colors }
    }

    fn salient_count(cloud: &PointCloud) -> usize {
        cloud.colors.iter().filter(|&&rgb| is_salient(rgb)).count()
    }

    #[test]
    fn half_of_the_points_are_salient_where_there_are_enough() {
        let chosen = select(&cloud(60), 50, Selection::Salient);
        assert_eq!((chosen.len(), salient_count(&chosen)), (50, 25));
    }

    #[test]
    fn the_rest_fills_up_and_so_do_salient_points() {
        let chosen = select(&cloud(7), 50, Selection::Salient);
        assert_eq!((chosen.len(), salient_count(&chosen)), (50, 7));
        let chosen = select(&cloud(60), 140, Selection::Salient);
        assert_eq!((chosen.len(), salient_count(&chosen)), (140, 60));
    }

    #[test]
    fn farthest_points_spread() {
        let grid = cloud(0);
        let chosen = select(&grid, 4, Selection::Farthest);
        let mut corners: Vec<_> = chosen.points.iter().map(|p| (p[0] as i32, p[1] as i32)).collect();
        corners.sort_unstable();
        assert_eq!(corners, [(0, 0), (0, 9), (9, 0), (9, 9)]);
    }
}
