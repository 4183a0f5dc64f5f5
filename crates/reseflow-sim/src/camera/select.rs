//! The choice of N points from all that a camera measured, by their visible colour.
//!
//! Farthest-point sampling: Eldar, Lindenbaum, Porat, Zeevi, "The farthest point strategy for progressive image
//! sampling" (1997).

use reseflow_data::PointCloud;

use super::is_salient;

/// At least this many points are salient when anything salient is in view (half of the cloud, where that is fewer).
const SALIENT_MINIMUM: usize = 24;

/// How N points are chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
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
        Selection::Farthest => farthest(candidates, &(0..candidates.len()).collect::<Vec<_>>(), points),
        Selection::Salient => {
            let (salient, rest): (Vec<usize>, Vec<usize>) =
                (0..candidates.len()).partition(|&i| is_salient(candidates.colors[i]));
            let salient_count = salient.len().min((points / 2).max(points.saturating_sub(rest.len())));
            let mut chosen = farthest(candidates, &salient, salient_count);
            chosen.extend(farthest(candidates, &rest, points.saturating_sub(salient_count)));
            chosen
        }
    };
    PointCloud {
        points: chosen.iter().map(|&i| candidates.points[i]).collect(),
        colors: chosen.iter().map(|&i| candidates.colors[i]).collect(),
    }
}

/// `count` of the candidates `pool`, each the farthest from those before it; the first is the farthest from the mean.
fn farthest(cloud: &PointCloud, pool: &[usize], count: usize) -> Vec<usize> {
    let count = count.min(pool.len());
    if count == 0 {
        return Vec::new();
    }
    let mut mean = [0.0_f32; 3];
    for &i in pool {
        for (sum, x) in mean.iter_mut().zip(cloud.points[i]) {
            *sum += x / pool.len() as f32;
        }
    }
    let mut distances: Vec<f32> = pool.iter().map(|&i| squared_distance(cloud.points[i], mean)).collect();
    let mut chosen = Vec::with_capacity(count);
    let mut next = position_of_greatest(&distances);
    distances.fill(f32::INFINITY);
    while chosen.len() < count {
        chosen.push(pool[next]);
        let newest = cloud.points[pool[next]];
        for (distance, &i) in distances.iter_mut().zip(pool) {
            *distance = distance.min(squared_distance(cloud.points[i], newest));
        }
        // A chosen point is never chosen again, even when all others coincide with one.
        distances[next] = f32::NEG_INFINITY;
        next = position_of_greatest(&distances);
    }
    chosen
}

/// The first position of the greatest value.
fn position_of_greatest(values: &[f32]) -> usize {
    let mut best = 0;
    for (position, value) in values.iter().enumerate() {
        if *value > values[best] {
            best = position;
        }
    }
    best
}

fn squared_distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    (0..3).map(|axis| (a[axis] - b[axis]) * (a[axis] - b[axis])).sum()
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
    fn farthest_points_spread_and_never_repeat() {
        let grid = cloud(0);
        let chosen = select(&grid, 4, Selection::Farthest);
        let mut corners: Vec<_> = chosen.points.iter().map(|p| (p[0] as i32, p[1] as i32)).collect();
        corners.sort_unstable();
        assert_eq!(corners, [(0, 0), (0, 9), (9, 0), (9, 9)]);
        let mut all: Vec<_> = farthest(&grid, &(0..100).collect::<Vec<_>>(), 100);
        all.sort_unstable();
        assert_eq!(all, (0..100).collect::<Vec<_>>());
    }
}
