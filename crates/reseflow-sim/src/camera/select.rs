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
    // Side by side in memory: the loop below is the camera's hottest.
    let points: Vec<[f32; 3]> = pool.iter().map(|&i| cloud.points[i]).collect();
    let mut mean = [0.0_f32; 3];
    for point in &points {
        for (sum, x) in mean.iter_mut().zip(point) {
            *sum += x / points.len() as f32;
        }
    }
    let mut next = 0;
    let mut greatest = f32::NEG_INFINITY;
    for (position, point) in points.iter().enumerate() {
        let distance = squared_distance(*point, mean);
        if distance > greatest {
            (next, greatest) = (position, distance);
        }
    }
    let mut distances = vec![f32::INFINITY; points.len()];
    let mut chosen = Vec::with_capacity(count);
    while chosen.len() < count {
        chosen.push(pool[next]);
        let newest = points[next];
        // A chosen point is never chosen again, even when all others coincide with one.
        distances[next] = f32::NEG_INFINITY;
        (next, greatest) = (0, f32::NEG_INFINITY);
        for (position, (distance, point)) in distances.iter_mut().zip(&points).enumerate() {
            *distance = distance.min(squared_distance(*point, newest));
            if *distance > greatest {
                (next, greatest) = (position, *distance);
            }
        }
    }
    chosen
}

fn squared_distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    let [x, y, z] = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    x * x + y * y + z * z
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
