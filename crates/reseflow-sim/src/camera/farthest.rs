//! Farthest-point sampling: Eldar, Lindenbaum, Porat, Zeevi, "The farthest point strategy for progressive image sampling"
//! (1997).
//!
//! The points lie in the cells of a grid. A new point is farther from most cells than those cells' points are from what is
//! chosen already; they are passed over. The comparison is exact in floating point, because rounding is monotonic: the
//! distance to a cell's bounding box, computed as that to a point, is never the greater one.

/// Cells of the grid along its longest edge.
const CELLS: usize = 16;

/// Some of the points, side by side in memory, and how far the chosen ones are from them.
struct Cell {
    /// Where they are in the sorted arrays.
    first: usize,
    end: usize,
    low: [f32; 3],
    high: [f32; 3],
    /// The greatest squared distance of its points from what is chosen, and the first point that has it.
    greatest: f32,
    farthest: usize,
}

/// `count` of the points, or all of them, each the farthest from those before it; the first is the farthest from the mean.
///
/// Of points that are equally far the one with the least index is chosen. Points must be finite.
pub(super) fn farthest(points: &[[f32; 3]], count: usize) -> Vec<usize> {
    let count = count.min(points.len());
    if count == 0 {
        return Vec::new();
    }
    let (mut cells, order) = cells(points);
    let sorted: Vec<[f32; 3]> = order.iter().map(|&index| points[index]).collect();
    let mut distances = vec![f32::INFINITY; points.len()];
    let mut chosen = Vec::with_capacity(count);
    let mut next = farthest_from_mean(points);
    loop {
        chosen.push(next);
        if chosen.len() == count {
            return chosen;
        }
        let newest = points[next];
        let mut best: Option<&Cell> = None;
        for cell in &mut cells {
            let holds_newest = squared_distance_to_box(newest, cell.low, cell.high) == 0.0;
            if holds_newest || squared_distance_to_box(newest, cell.low, cell.high) < cell.greatest {
                cell.update(newest, next, &order, &sorted, &mut distances);
            }
            let is_farther = |best: &Cell| {
                cell.greatest > best.greatest
                    || (cell.greatest == best.greatest && cell.farthest < best.farthest)
            };
            if best.is_none_or(is_farther) {
                best = Some(cell);
            }
        }
        next = best.map_or(0, |cell| cell.farthest);
    }
}

impl Cell {
    /// Takes the newest chosen point, with index `newest_index`, into account.
    fn update(
        &mut self,
        newest: [f32; 3],
        newest_index: usize,
        order: &[usize],
        sorted: &[[f32; 3]],
        distances: &mut [f32],
    ) {
        self.greatest = f32::NEG_INFINITY;
        for position in self.first..self.end {
            let distance = &mut distances[position];
            *distance = distance.min(squared_distance(sorted[position], newest));
            if order[position] == newest_index {
                // A chosen point is never chosen again, even when all others coincide with one.
                *distance = f32::NEG_INFINITY;
            }
            if *distance > self.greatest {
                (self.greatest, self.farthest) = (*distance, order[position]);
            }
        }
    }
}

/// The cells that hold points, and the points' indices sorted by cell, ascending within each.
fn cells(points: &[[f32; 3]]) -> (Vec<Cell>, Vec<usize>) {
    let (low, high) = bounds(points);
    let longest = (0..3).map(|axis| high[axis] - low[axis]).fold(f32::MIN_POSITIVE, f32::max);
    let cell_of = |point: &[f32; 3]| {
        let along = |axis: usize| ((point[axis] - low[axis]) / longest * CELLS as f32) as usize;
        (0..3).fold(0, |cell, axis| cell * CELLS + along(axis).min(CELLS - 1))
    };
    let cell_of_point: Vec<usize> = points.iter().map(cell_of).collect();
    let mut ends = vec![0; CELLS * CELLS * CELLS];
    for &cell in &cell_of_point {
        ends[cell] += 1;
    }
    let mut total = 0;
    for end in &mut ends {
        total += std::mem::replace(end, total);
    }
    // `ends` holds where each cell begins; filling the cells moves it to their ends.
    let mut order = vec![0; points.len()];
    for (index, &cell) in cell_of_point.iter().enumerate() {
        order[ends[cell]] = index;
        ends[cell] += 1;
    }
    let mut cells = Vec::new();
    let mut first = 0;
    for end in ends.into_iter().filter(|&end| end > 0) {
        if end > first {
            let in_cell: Vec<[f32; 3]> = order[first..end].iter().map(|&index| points[index]).collect();
            let (low, high) = bounds(&in_cell);
            cells.push(Cell { first, end, low, high, greatest: f32::INFINITY, farthest: order[first] });
        }
        first = end;
    }
    (cells, order)
}

fn bounds(points: &[[f32; 3]]) -> ([f32; 3], [f32; 3]) {
    let start = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    points.iter().fold(start, |(low, high), point| {
        ([0, 1, 2].map(|axis| low[axis].min(point[axis])), [0, 1, 2].map(|axis| high[axis].max(point[axis])))
    })
}

fn farthest_from_mean(points: &[[f32; 3]]) -> usize {
    let mut mean = [0.0_f32; 3];
    for point in points {
        for (sum, x) in mean.iter_mut().zip(point) {
            *sum += x / points.len() as f32;
        }
    }
    let mut best = (0, f32::NEG_INFINITY);
    for (index, point) in points.iter().enumerate() {
        let distance = squared_distance(*point, mean);
        if distance > best.1 {
            best = (index, distance);
        }
    }
    best.0
}

fn squared_distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    squared_norm([a[0] - b[0], a[1] - b[1], a[2] - b[2]])
}

/// From a point to the nearest point of a box, rounded as [`squared_distance`] rounds.
fn squared_distance_to_box(point: [f32; 3], low: [f32; 3], high: [f32; 3]) -> f32 {
    squared_norm([0, 1, 2].map(|axis| (low[axis] - point[axis]).max(point[axis] - high[axis]).max(0.0)))
}

fn squared_norm([x, y, z]: [f32; 3]) -> f32 {
    x * x + y * y + z * z
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngExt;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;

    /// The definition, point by point.
    fn plain(points: &[[f32; 3]], count: usize) -> Vec<usize> {
        let mut chosen = vec![farthest_from_mean(points)];
        while chosen.len() < count {
            let to_chosen = |point: [f32; 3]| {
                chosen
                    .iter()
                    .map(|&other| squared_distance(point, points[other]))
                    .fold(f32::INFINITY, f32::min)
            };
            let mut best: Option<(usize, f32)> = None;
            for index in (0..points.len()).filter(|index| !chosen.contains(index)) {
                let distance = to_chosen(points[index]);
                if best.is_none_or(|(_, greatest)| distance > greatest) {
                    best = Some((index, distance));
                }
            }
            chosen.push(best.unwrap().0);
        }
        chosen
    }

    #[test]
    fn the_grid_chooses_what_the_definition_chooses() {
        let mut rng = ChaCha8Rng::seed_from_u64(8);
        for round in 0..30 {
            let size = if round < 3 { 1500 } else { rng.random_range(1..200) };
            // Flat, curved and lumpy clouds; coarse ones, in which many distances are equal and points coincide.
            let points: Vec<[f32; 3]> = (0..size)
                .map(|_| {
                    let [x, y]: [f32; 2] = [rng.random_range(-0.3..0.3), rng.random_range(-0.2..0.2)];
                    let point = [x, y, [0.0, x * y, x.abs()][round % 3]];
                    if round % 2 == 0 { point } else { point.map(|x| (20.0 * x).round() / 20.0) }
                })
                .collect();
            let count = size.min(60);
            assert_eq!(farthest(&points, count), plain(&points, count), "round {round}");
        }
    }

    #[test]
    fn all_points_are_chosen_once_where_all_are_wanted() {
        for points in [vec![[0.1, 0.2, 0.3]; 5], (0..40).map(|i| [i as f32, 0.0, -1.0]).collect::<Vec<_>>()] {
            let mut chosen = farthest(&points, points.len() + 3);
            chosen.sort_unstable();
            assert_eq!(chosen, (0..points.len()).collect::<Vec<_>>());
        }
        assert!(farthest(&[], 4).is_empty());
    }
}
