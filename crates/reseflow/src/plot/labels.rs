//! Where the names of points stand: beside them, clear of each other and of every marker as far as there is room.

/// Half the height of a name.
const HALF_HEIGHT: f64 = 7.5;
/// Half the side of the square that a marker needs.
const MARKER: f64 = 5.5;

/// Left, top, right and bottom.
type Bounds = [f64; 4];

/// The centres of names of the given widths beside their points; `markers` are the points of the whole frame, given by its corner and
/// size.
///
/// The names are placed in order. Each takes the first of eight places about its point where it covers least.
pub(super) fn beside(
    named: &[((f64, f64), f64)],
    markers: &[(f64, f64)],
    ((left, top), (width, height)): ((f64, f64), (f64, f64)),
) -> Vec<(f64, f64)> {
    let frame = [left, top, left + width, top + height];
    let mut taken: Vec<Bounds> = markers.iter().map(|&at| about(at, MARKER, MARKER)).collect();
    let mut places = Vec::new();
    for &((x, y), wide) in named {
        let (side, rise) = (0.5 * wide + MARKER + 2.0, HALF_HEIGHT + MARKER);
        let around = [
            (0.0, -rise),
            (0.0, rise),
            (side, 0.0),
            (-side, 0.0),
            (side, -rise),
            (side, rise),
            (-side, -rise),
            (-side, rise),
        ];
        let candidates = around.map(|(across, down)| (x + across, y + down));
        let cost = |&place: &(f64, f64)| {
            let bounds = about(place, 0.5 * wide, HALF_HEIGHT);
            let outside = overlap(&bounds, &bounds) - overlap(&bounds, &frame);
            outside + taken.iter().map(|other| overlap(&bounds, other)).sum::<f64>()
        };
        let best = candidates.into_iter().min_by(|a, b| cost(a).total_cmp(&cost(b))).unwrap_or((x, y));
        taken.push(about(best, 0.5 * wide, HALF_HEIGHT));
        places.push(best);
    }
    places
}

fn about((x, y): (f64, f64), half_width: f64, half_height: f64) -> Bounds {
    [x - half_width, y - half_height, x + half_width, y + half_height]
}

/// The area that both cover.
fn overlap(a: &Bounds, b: &Bounds) -> f64 {
    let along = |low: usize, high: usize| (a[high].min(b[high]) - a[low].max(b[low])).max(0.0);
    along(0, 2) * along(1, 3)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: ((f64, f64), (f64, f64)) = ((0.0, 0.0), (200.0, 100.0));

    #[test]
    fn names_cover_neither_each_other_nor_a_marker() {
        let markers = [(100.0, 50.0), (103.0, 58.0), (112.0, 49.0), (100.0, 70.0)];
        let named = markers.map(|at| (at, 20.0));
        let places = beside(&named, &markers, FRAME);
        let bounds: Vec<Bounds> = places.iter().map(|&at| about(at, 10.0, HALF_HEIGHT)).collect();
        for (index, name) in bounds.iter().enumerate() {
            assert!(markers.iter().all(|&at| overlap(name, &about(at, MARKER, MARKER)) == 0.0), "{places:?}");
            assert!(bounds[..index].iter().all(|other| overlap(name, other) == 0.0), "{places:?}");
        }
    }

    #[test]
    fn a_name_stands_above_its_point_and_stays_in_the_frame() {
        let at = [(100.0, 50.0), (100.0, 3.0), (199.0, 50.0)];
        let places = at.map(|at| beside(&[(at, 20.0)], &[at], FRAME)[0]);
        assert_eq!(places[0], (100.0, 37.0));
        assert_eq!(places[1], (100.0, 16.0), "there is no room above");
        assert!(places[2].0 + 10.0 <= 200.0, "{places:?}");
    }
}
