//! Wet paint: where the brush left it, how much of the stroke it covers, and how well the brush was pressed.

use super::stroke::{Stroke, distance};
use crate::world::Object;
use crate::world::brush::Brush;

/// The bristles leave paint at these compressions, metres.
pub(super) const PAINTING_M: [f64; 2] = [0.001, 0.010];
/// A dab of paint is left whenever the tip is this far from the dab before, metres.
const DAB_STEP_M: f64 = 0.003;
/// The stroke is sampled about this densely to say how much of it is covered, metres.
const SAMPLE_STEP_M: f64 = 0.002;
/// Only the face takes paint: touches this far from it are at the board's sides, metres.
const FACE_M: f64 = 1e-3;

/// A point of the stroke is covered when paint is this near, metres.
const COVERED_M: f64 = 0.010;
/// This share of the stroke must be covered.
const COVERED_SHARE: f64 = 0.90;
/// The 95th percentile of the paint's distances from the stroke may be this, metres.
const DEVIATION_M: f64 = 0.015;
/// The brush must be pressed as it paints in this share of the stroke's control ticks.
const PRESSED_SHARE: f64 = 0.95;

/// What is painted so far.
#[derive(Debug)]
pub(super) struct WetPaint {
    stroke: Stroke,
    /// Points of the stroke, and whether each is covered.
    samples: Vec<([f64; 2], bool)>,
    dabs_m: Vec<[f64; 2]>,
    touches_seen: usize,
}

impl WetPaint {
    pub(super) fn new(stroke: Stroke) -> WetPaint {
        let count = (stroke.length_m() / SAMPLE_STEP_M).ceil() as usize + 1;
        let samples = stroke.points_m(count).into_iter().map(|point| (point, false)).collect();
        WetPaint { stroke, samples, dabs_m: Vec::new(), touches_seen: 0 }
    }

    /// Adds what the brush has painted on `board` since the last time; says whether that was anything.
    pub(super) fn add(&mut self, brush: &Brush, board: Object) -> bool {
        let before = self.dabs_m.len();
        let touches = brush.touches();
        for touch in &touches[self.touches_seen.min(touches.len())..] {
            let on_face = touch.object == Some(board) && touch.point_m.z.abs() < FACE_M;
            if !on_face || !paints(touch.compression_m) {
                continue;
            }
            let dab = [touch.point_m.x, touch.point_m.y];
            if self.dabs_m.last().is_some_and(|&last| distance(last, dab) < DAB_STEP_M) {
                continue;
            }
            self.dabs_m.push(dab);
            for (point, covered) in &mut self.samples {
                *covered |= distance(*point, dab) <= COVERED_M;
            }
        }
        self.touches_seen = touches.len();
        self.dabs_m.len() > before
    }

    /// The middles of the dabs, in the order in which they were painted, metres.
    pub(super) fn dabs_m(&self) -> &[[f64; 2]] {
        &self.dabs_m
    }

    /// The share of the stroke that paint is near.
    pub(super) fn covered_share(&self) -> f64 {
        let covered = self.samples.iter().filter(|(_, covered)| *covered).count();
        covered as f64 / self.samples.len() as f64
    }

    /// The 95th percentile of the dabs' distances from the stroke, metres; infinite without paint.
    fn deviation_m(&self) -> f64 {
        let mut distances: Vec<f64> = self.dabs_m.iter().map(|&dab| self.stroke.distance_m(dab)).collect();
        distances.sort_by(f64::total_cmp);
        let index = (distances.len() * 95).div_ceil(100).saturating_sub(1);
        distances.get(index).copied().unwrap_or(f64::INFINITY)
    }

    /// Whether the stroke is painted well.
    pub(super) fn is_done(&self, brush: &Brush) -> bool {
        self.covered_share() >= COVERED_SHARE
            && self.deviation_m() <= DEVIATION_M
            && pressed_share(brush.compressions_m()) >= PRESSED_SHARE
    }
}

fn paints(compression_m: f64) -> bool {
    (PAINTING_M[0]..=PAINTING_M[1]).contains(&compression_m)
}

/// The share of the ticks from the first to the last at which the brush paints, in which it does; 0 without any.
fn pressed_share(compressions_m: &[f64]) -> f64 {
    let painting: Vec<bool> = compressions_m.iter().map(|&compression| paints(compression)).collect();
    let (Some(first), Some(last)) =
        (painting.iter().position(|&paints| paints), painting.iter().rposition(|&paints| paints))
    else {
        return 0.0;
    };
    let stroke = &painting[first..=last];
    stroke.iter().filter(|&&paints| paints).count() as f64 / stroke.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line() -> Stroke {
        Stroke::from_curves("line", &[vec![[-0.1, 0.0], [0.1, 0.0]]]).unwrap()
    }

    fn painted(dabs_m: Vec<[f64; 2]>) -> WetPaint {
        let mut paint = WetPaint::new(line());
        for (point, covered) in &mut paint.samples {
            *covered = dabs_m.iter().any(|&dab| distance(*point, dab) <= COVERED_M);
        }
        WetPaint { dabs_m, ..paint }
    }

    #[test]
    fn coverage_is_the_share_of_the_length_within_a_centimetre() {
        // From −0.1 to 0 m, and 1 cm beyond: 0.11 of 0.2 m.
        let half = painted((0..=50).map(|i| [-0.1 + 0.002 * f64::from(i), 0.0]).collect());
        assert!((half.covered_share() - 0.55).abs() < 0.01, "{}", half.covered_share());
        assert_eq!(painted(Vec::new()).covered_share(), 0.0);
        assert_eq!(
            painted((0..=100).map(|i| [-0.1 + 0.002 * f64::from(i), 0.011]).collect()).covered_share(),
            0.0
        );
    }

    #[test]
    fn the_deviation_forgives_one_dab_in_twenty() {
        let line = |off: usize| -> Vec<[f64; 2]> {
            (0..100).map(|i| [-0.1 + 0.002 * i as f64, if i < off { 0.05 } else { 0.001 }]).collect()
        };
        assert!((painted(line(5)).deviation_m() - 0.001).abs() < 1e-9);
        assert!((painted(line(6)).deviation_m() - 0.05).abs() < 1e-9);
        assert!(painted(Vec::new()).deviation_m().is_infinite());
    }

    #[test]
    fn pressing_counts_between_the_first_and_the_last_painting_tick() {
        let share = |compressions_mm: &[f64]| {
            pressed_share(&compressions_mm.iter().map(|c| 1e-3 * c).collect::<Vec<_>>())
        };
        assert_eq!(share(&[0.0, 0.5, 5.0, 5.0, 0.2, 0.0]), 1.0);
        assert_eq!(share(&[5.0, 0.0, 5.0, 12.0]), 2.0 / 3.0);
        assert_eq!(share(&[5.0, 12.0, 0.9, 10.0]), 0.5);
        assert_eq!(share(&[12.0, 12.0, 0.5]), 0.0);
        assert_eq!(share(&[]), 0.0);
    }
}
