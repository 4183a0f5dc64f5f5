//! A stroke: a plane curve that is known by its length, with a heading everywhere.

use std::f64::consts::{PI, TAU};

/// Samples of each Bézier curve.
const SAMPLES_PER_CURVE: usize = 64;

/// A place on a stroke.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Place {
    /// On the board, metres.
    pub(super) point_m: [f64; 2],
    /// The direction of travel, rad from the board's x axis, continuous along the stroke.
    pub(super) heading_rad: f64,
}

/// An open stroke on a board, in the board's frame, from where it begins to where it ends.
#[derive(Debug, Clone, PartialEq)]
pub struct Stroke {
    name: String,
    samples: Vec<Place>,
    /// The length up to each sample, metres.
    lengths_m: Vec<f64>,
}

impl Stroke {
    /// Samples a chain of Bézier curves, whose control points are in metres.
    ///
    /// `None` where a curve has no direction somewhere, because control points coincide.
    pub(super) fn from_curves(name: &str, curves: &[Vec<[f64; 2]>]) -> Option<Stroke> {
        let mut samples: Vec<Place> = Vec::new();
        for curve in curves {
            for step in usize::from(!samples.is_empty())..=SAMPLES_PER_CURVE {
                let (point_m, velocity) = bezier(curve, step as f64 / SAMPLES_PER_CURVE as f64);
                let speed = velocity[0].hypot(velocity[1]);
                if speed.is_nan() || speed < 1e-6 {
                    return None;
                }
                let angle = velocity[1].atan2(velocity[0]);
                let heading_rad =
                    samples.last().map_or(angle, |last| last.heading_rad + wrapped(angle - last.heading_rad));
                samples.push(Place { point_m, heading_rad });
            }
        }
        Some(Stroke::from_samples(name, samples))
    }

    /// The polyline through `samples`, at least two.
    pub(super) fn from_samples(name: &str, samples: Vec<Place>) -> Stroke {
        let mut lengths_m = Vec::with_capacity(samples.len());
        let mut length = 0.0;
        for (index, sample) in samples.iter().enumerate() {
            if index > 0 {
                length += distance(samples[index - 1].point_m, sample.point_m);
            }
            lengths_m.push(length);
        }
        Stroke { name: name.to_owned(), samples, lengths_m }
    }

    /// Its name in the library.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its length, metres.
    pub fn length_m(&self) -> f64 {
        self.lengths_m.last().copied().unwrap_or(0.0)
    }

    /// The place `length_m` metres after the beginning, within the stroke.
    pub(super) fn place(&self, length_m: f64) -> Place {
        let next =
            self.lengths_m.partition_point(|&length| length < length_m).clamp(1, self.samples.len() - 1);
        let (before, after) = (self.samples[next - 1], self.samples[next]);
        let span = self.lengths_m[next] - self.lengths_m[next - 1];
        let share =
            if span > 0.0 { ((length_m - self.lengths_m[next - 1]) / span).clamp(0.0, 1.0) } else { 0.0 };
        let mix = |a: f64, b: f64| a + share * (b - a);
        Place {
            point_m: [0, 1].map(|axis| mix(before.point_m[axis], after.point_m[axis])),
            heading_rad: mix(before.heading_rad, after.heading_rad),
        }
    }

    /// `count` ≥ 2 places, equally far apart along the stroke, both ends among them.
    pub(super) fn places(&self, count: usize) -> Vec<Place> {
        let step = self.length_m() / (count.max(2) - 1) as f64;
        (0..count).map(|index| self.place(index as f64 * step)).collect()
    }

    /// The points of `Stroke::places`, metres.
    pub fn points_m(&self, count: usize) -> Vec<[f64; 2]> {
        self.places(count).iter().map(|place| place.point_m).collect()
    }

    /// The distance of a point of the board from the stroke, metres.
    pub fn distance_m(&self, point_m: [f64; 2]) -> f64 {
        let to_segment = |pair: &[Place]| distance_to_segment(point_m, pair[0].point_m, pair[1].point_m);
        self.samples.windows(2).map(to_segment).fold(f64::INFINITY, f64::min)
    }

    /// The stroke enlarged and turned about the board's middle.
    pub(super) fn scaled_and_turned(&self, scale: f64, turn_rad: f64) -> Stroke {
        let (sin, cos) = turn_rad.sin_cos();
        let moved = |place: &Place| {
            let [x, y] = place.point_m.map(|coordinate| scale * coordinate);
            Place {
                point_m: [cos * x - sin * y, sin * x + cos * y],
                heading_rad: place.heading_rad + turn_rad,
            }
        };
        Stroke::from_samples(&self.name, self.samples.iter().map(moved).collect())
    }

    /// The stroke drawn from its end to its beginning.
    pub(super) fn reversed(&self) -> Stroke {
        let turned = |place: &Place| Place { heading_rad: place.heading_rad + PI, ..*place };
        Stroke::from_samples(&self.name, self.samples.iter().rev().map(turned).collect())
    }
}

/// A Bézier curve's point and velocity at `t`, after de Casteljau.
pub(super) fn bezier(control: &[[f64; 2]], t: f64) -> ([f64; 2], [f64; 2]) {
    let mut points = control.to_vec();
    let mut velocity = [0.0; 2];
    while points.len() > 1 {
        if let [a, b] = points[..] {
            velocity = [0, 1].map(|axis| (control.len() - 1) as f64 * (b[axis] - a[axis]));
        }
        points = points
            .windows(2)
            .map(|pair| [0, 1].map(|axis| pair[0][axis] + t * (pair[1][axis] - pair[0][axis])))
            .collect();
    }
    (points.first().copied().unwrap_or_default(), velocity)
}

/// An angle in \[−π, π).
pub(super) fn wrapped(angle_rad: f64) -> f64 {
    (angle_rad + PI).rem_euclid(TAU) - PI
}

pub(super) fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (b[0] - a[0]).hypot(b[1] - a[1])
}

fn distance_to_segment(point: [f64; 2], from: [f64; 2], to: [f64; 2]) -> f64 {
    let along = [to[0] - from[0], to[1] - from[1]];
    let squared = along[0] * along[0] + along[1] * along[1];
    let share = if squared > 0.0 {
        (((point[0] - from[0]) * along[0] + (point[1] - from[1]) * along[1]) / squared).clamp(0.0, 1.0)
    } else {
        0.0
    };
    distance(point, [from[0] + share * along[0], from[1] + share * along[1]])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A quarter of a circle of radius 0.1 m about the origin, to 0.03 %, counter-clockwise from the x axis.
    fn quarter() -> Stroke {
        let k = 0.1 * 0.552_284_75;
        let control = vec![[0.1, 0.0], [0.1, k], [k, 0.1], [0.0, 0.1]];
        Stroke::from_curves("quarter", &[control]).unwrap()
    }

    #[test]
    fn a_quarter_circle_has_its_length_headings_and_distances() {
        let quarter = quarter();
        assert!((quarter.length_m() - 0.1 * PI / 2.0).abs() < 1e-4);
        for (index, place) in quarter.places(11).iter().enumerate() {
            let angle = PI / 2.0 * index as f64 / 10.0;
            assert!((place.heading_rad - (angle + PI / 2.0)).abs() < 2e-3);
            assert!(distance(place.point_m, [0.1 * angle.cos(), 0.1 * angle.sin()]) < 1e-4);
        }
        assert!((quarter.distance_m([0.06, 0.06]) - (0.1 - 0.06 * 2.0_f64.sqrt())).abs() < 1e-4);
        assert!((quarter.distance_m([0.1, -0.03]) - 0.03).abs() < 1e-9);
    }

    #[test]
    fn headings_go_on_where_the_angle_would_jump() {
        // Two half-turns, counter-clockwise, cross the cut of the arc tangent.
        let chain = [
            vec![[0.1, 0.0], [0.1, 0.133], [-0.1, 0.133], [-0.1, 0.0]],
            vec![[-0.1, 0.0], [-0.1, -0.133], [0.1, -0.133], [0.1, 0.0]],
        ];
        let stroke = Stroke::from_curves("ring", &chain).unwrap();
        let places = stroke.places(100);
        assert!(places.windows(2).all(|pair| (pair[1].heading_rad - pair[0].heading_rad).abs() < 0.2));
        assert!((places[99].heading_rad - places[0].heading_rad - TAU).abs() < 1e-6);
    }

    #[test]
    fn moving_and_reversing_a_stroke_move_and_reverse_its_places() {
        let quarter = quarter();
        let moved = quarter.scaled_and_turned(1.2, 0.5).reversed();
        assert!((moved.length_m() - 1.2 * quarter.length_m()).abs() < 1e-12);
        for (a, b) in quarter.places(9).iter().zip(moved.places(9).iter().rev()) {
            let [x, y] = a.point_m.map(|coordinate| 1.2 * coordinate);
            let (sin, cos) = 0.5_f64.sin_cos();
            assert!(distance(b.point_m, [cos * x - sin * y, sin * x + cos * y]) < 1e-12);
            assert!((wrapped(b.heading_rad - a.heading_rad - 0.5).abs() - PI).abs() < 1e-9);
        }
    }

    #[test]
    fn coinciding_control_points_give_no_stroke() {
        assert!(Stroke::from_curves("dot", &[vec![[0.1, 0.1], [0.1, 0.1]]]).is_none());
        assert!(Stroke::from_curves("cusp", &[vec![[0.0, 0.0], [0.0, 0.0], [0.1, 0.1]]]).is_none());
    }
}
