//! The pixels that a convex body can cover: row by row, the columns between the two sides of its outline.
//!
//! The outline of a convex body in the image is the convex hull of its corners' images. A row meets it between the least and
//! the greatest crossing over all pairs of corners, because every such segment lies in the hull.

use std::ops::Range;

/// The outline is widened by so much, pixels: rays are cast in single precision, this is decided in double.
const MARGIN_PX: f64 = 0.01;

/// Calls `visit` with each row and the columns whose pixels' middles lie in the outline of `corners_px`.
///
/// Coordinates are those of the image: the middle of pixel (column, row) is at (column + ½, row + ½).
pub(super) fn rows_within(
    corners_px: &[[f64; 2]],
    [columns, rows]: [usize; 2],
    mut visit: impl FnMut(usize, Range<usize>),
) {
    let low = corners_px.iter().map(|corner| corner[1]).fold(f64::INFINITY, f64::min);
    let high = corners_px.iter().map(|corner| corner[1]).fold(f64::NEG_INFINITY, f64::max);
    for row in pixels_between(low, high, rows) {
        let middle = row as f64 + 0.5;
        let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut widen = |x: f64| (left, right) = (left.min(x), right.max(x));
        for (index, &[x, y]) in corners_px.iter().enumerate() {
            if (y - middle).abs() <= MARGIN_PX {
                widen(x);
            }
            for &[other_x, other_y] in &corners_px[..index] {
                for edge in [middle - MARGIN_PX, middle + MARGIN_PX] {
                    if (y < edge) != (other_y < edge) {
                        widen(x + (edge - y) / (other_y - y) * (other_x - x));
                    }
                }
            }
        }
        let covered = pixels_between(left, right, columns);
        if !covered.is_empty() {
            visit(row, covered);
        }
    }
}

/// The pixels of `count` whose middles lie between two coordinates.
fn pixels_between(low: f64, high: f64, count: usize) -> Range<usize> {
    let bound = |x: f64| x.clamp(0.0, count as f64) as usize;
    let first = bound((low - MARGIN_PX - 0.5).ceil());
    first..bound((high + MARGIN_PX - 0.5).floor() + 1.0).max(first)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, RngExt};
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;

    const SIZE: [usize; 2] = [20, 16];

    fn covered(corners: &[[f64; 2]]) -> Vec<[usize; 2]> {
        let mut pixels = Vec::new();
        rows_within(corners, SIZE, |row, columns| pixels.extend(columns.map(|column| [column, row])));
        pixels
    }

    /// Whether a point is in a triangle, by the signs of three areas.
    fn in_triangle([a, b, c]: [[f64; 2]; 3], point: [f64; 2]) -> bool {
        let area = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| {
            (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
        };
        let signs = [area(a, b, point), area(b, c, point), area(c, a, point)];
        signs.iter().all(|&sign| sign >= 0.0) || signs.iter().all(|&sign| sign <= 0.0)
    }

    /// Whether a point is in the hull of some corners: it is in one of their triangles.
    fn in_hull(corners: &[[f64; 2]], point: [f64; 2]) -> bool {
        let n = corners.len();
        (0..n)
            .any(|i| (0..i).any(|j| (0..j).any(|k| in_triangle([corners[i], corners[j], corners[k]], point))))
    }

    fn corners(count: usize, rng: &mut impl Rng) -> Vec<[f64; 2]> {
        (0..count).map(|_| [rng.random_range(-6.0..26.0), rng.random_range(-5.0..21.0)]).collect()
    }

    #[test]
    fn the_rows_hold_every_pixel_of_the_hull_and_hardly_another() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let (mut inside, mut extra) = (0, 0);
        for round in 0..300 {
            let corners = corners(if round % 2 == 0 { 3 } else { 8 }, &mut rng);
            let covered = covered(&corners);
            for pixel in (0..SIZE[0]).flat_map(|column| (0..SIZE[1]).map(move |row| [column, row])) {
                let in_hull = in_hull(&corners, pixel.map(|index| index as f64 + 0.5));
                assert!(!in_hull || covered.contains(&pixel), "{corners:?} without {pixel:?}");
                inside += usize::from(in_hull);
                extra += usize::from(!in_hull && covered.contains(&pixel));
            }
        }
        assert!(inside > 10_000 && extra * 100 < inside, "{extra} extra pixels beside {inside}");
    }

    #[test]
    fn level_edges_and_bodies_out_of_the_image_are_no_trouble() {
        assert_eq!(covered(&[[2.2, 3.5], [5.8, 3.5], [4.0, 3.5]]), [[2, 3], [3, 3], [4, 3], [5, 3]]);
        assert!(covered(&[[30.0, 2.0], [35.0, 9.0], [32.0, 12.0]]).is_empty());
        assert!(covered(&[[3.0, -9.0], [9.0, -2.0], [5.0, -1.0]]).is_empty());
        assert!(covered(&[[3.1, 4.1], [3.2, 4.2], [3.3, 4.1]]).is_empty(), "between the pixels' middles");
    }
}
