//! The stroke library: text files that are part of the program, checked when they are first needed.
//!
//! A stroke is refused where the expert could not paint it: where it is kinked, too long, leaves the board, or is left
//! by the executed interpolation, all of that at the greatest scale that is ever drawn.

use std::sync::OnceLock;

use reseflow_data::Action;
use serde::Deserialize;

use super::expert;
use super::stroke::{Place, Stroke, bezier, distance, wrapped};
use crate::error::SimError;

const FILES: [(&str, &str); 3] = [
    ("pentagram.toml", include_str!("../../../../../assets/strokes/pentagram.toml")),
    ("heart.toml", include_str!("../../../../../assets/strokes/heart.toml")),
    ("calligraphy.toml", include_str!("../../../../../assets/strokes/calligraphy.toml")),
];

/// Strokes are enlarged by at most this.
pub(super) const MAX_SCALE: f64 = 1.25;
/// The longest stroke at that scale, metres.
pub(super) const MAX_LENGTH_M: f64 = 0.35;
/// The shortest stroke at nominal size, metres.
const MIN_LENGTH_M: f64 = 0.05;
/// Strokes stay within this of the board's middle at nominal size, metres.
const MAX_RADIUS_M: f64 = 0.145;
/// Both ends of an open stroke are this far apart, metres.
const MIN_OPENING_M: f64 = 0.03;
/// Where curves join, the heading may jump by this.
const MAX_KINK_RAD: f64 = 0.05;
/// The executed interpolation stays within this of the stroke, and the stroke of it, metres.
const MAX_DEVIATION_M: f64 = 0.003;
const MILLIMETRE: f64 = 1e-3;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    figure: String,
    stroke: Vec<Entry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    name: String,
    curves_mm: Vec<Vec<[f64; 2]>>,
}

/// All strokes, at nominal size.
///
/// # Errors
/// The first file or stroke that is not as it must be.
pub(super) fn strokes() -> Result<&'static [Stroke], &'static SimError> {
    static LIBRARY: OnceLock<Result<Vec<Stroke>, SimError>> = OnceLock::new();
    LIBRARY.get_or_init(|| load(&FILES)).as_ref().map(Vec::as_slice)
}

fn load(files: &[(&str, &str)]) -> Result<Vec<Stroke>, SimError> {
    let mut strokes: Vec<Stroke> = Vec::new();
    for &(file, text) in files {
        let fault = |reason: String| SimError::StrokeFile { file: file.to_owned(), reason };
        let parsed: File = toml::from_str(text).map_err(|error| fault(error.to_string()))?;
        if parsed.stroke.is_empty() {
            return Err(fault(format!("the figure {} has no stroke", parsed.figure)));
        }
        for entry in &parsed.stroke {
            let stroke =
                checked(entry).map_err(|reason| fault(format!("stroke {}: {reason}", entry.name)))?;
            if strokes.iter().any(|other| other.name() == stroke.name()) {
                return Err(fault(format!("stroke {}: expected a new name, got one twice", entry.name)));
            }
            strokes.push(stroke);
        }
    }
    Ok(strokes)
}

/// The stroke of an entry, or what is wrong with it.
fn checked(entry: &Entry) -> Result<Stroke, String> {
    let curves: Vec<Vec<[f64; 2]>> = entry
        .curves_mm
        .iter()
        .map(|curve| curve.iter().map(|point| point.map(|x| x * MILLIMETRE)).collect())
        .collect();
    if curves.is_empty() {
        return Err("expected at least one curve, got none".to_owned());
    }
    for (index, curve) in curves.iter().enumerate() {
        if !(2..=4).contains(&curve.len()) {
            return Err(format!("curve {index}: expected two to four control points, got {}", curve.len()));
        }
        if !curve.iter().flatten().all(|x| x.is_finite()) {
            return Err(format!("curve {index}: expected finite control points"));
        }
    }
    for (index, pair) in curves.windows(2).enumerate() {
        let (end, before) = bezier(&pair[0], 1.0);
        let (start, after) = bezier(&pair[1], 0.0);
        let gap = distance(end, start);
        if gap > 1e-9 {
            let gap_mm = gap / MILLIMETRE;
            return Err(format!(
                "expected curve {} to begin where curve {index} ends, got {gap_mm:.1} mm between them",
                index + 1
            ));
        }
        let kink = wrapped(after[1].atan2(after[0]) - before[1].atan2(before[0])).abs();
        if kink > MAX_KINK_RAD {
            return Err(format!(
                "expected no kink where curve {index} ends, got {kink:.2} rad: cut the stroke there"
            ));
        }
    }
    let stroke = Stroke::from_curves(&entry.name, &curves)
        .ok_or("expected a direction everywhere, got control points that coincide")?;
    checked_size(&stroke)?;
    let deviation = deviation_m(&stroke.scaled_and_turned(MAX_SCALE, 0.0));
    if deviation > MAX_DEVIATION_M {
        return Err(format!(
            "expected the executed path within {} mm of the stroke, got {:.1} mm: cut it in two",
            MAX_DEVIATION_M / MILLIMETRE,
            deviation / MILLIMETRE
        ));
    }
    Ok(stroke)
}

fn checked_size(stroke: &Stroke) -> Result<(), String> {
    let (low, high) = (MIN_LENGTH_M, MAX_LENGTH_M / MAX_SCALE);
    if !(low..=high).contains(&stroke.length_m()) {
        let [low, high, got] = [low, high, stroke.length_m()].map(|length| length / MILLIMETRE);
        return Err(format!("expected a length of {low:.0} to {high:.0} mm, got {got:.0} mm"));
    }
    let points = stroke.points_m(200);
    let radius = points.iter().map(|point| point[0].hypot(point[1])).fold(0.0, f64::max);
    if radius > MAX_RADIUS_M {
        let [limit, got] = [MAX_RADIUS_M, radius].map(|length| length / MILLIMETRE);
        return Err(format!("expected it within {limit:.0} mm of the board's middle, got {got:.0} mm"));
    }
    let opening = distance(points[0], points[points.len() - 1]);
    if opening < MIN_OPENING_M {
        let [limit, got] = [MIN_OPENING_M, opening].map(|length| length / MILLIMETRE);
        return Err(format!(
            "expected an open stroke, its ends {limit:.0} mm apart, got {got:.0} mm: cut it in two"
        ));
    }
    Ok(())
}

/// The greatest distance between the stroke and the tip's path when the expert's poses are followed, metres.
fn deviation_m(stroke: &Stroke) -> f64 {
    let poses = expert::stroke_poses(stroke, 1.0);
    let path = poses.windows(2).flat_map(|pair| {
        let [from, to] = [pair[0], pair[1]].map(|pose| Action { world_from_gripper: pose, opening: 0.0 });
        (0..=20).map(move |step| {
            let at = from.interpolate(&to, f64::from(step) / 20.0).world_from_gripper.translation;
            Place { point_m: [at.x, at.y], heading_rad: 0.0 }
        })
    });
    let path = Stroke::from_samples("path", path.collect());
    let farthest = |of: &Stroke, from: &Stroke| {
        of.points_m(200).iter().map(|&point| from.distance_m(point)).fold(0.0, f64::max)
    };
    farthest(stroke, &path).max(farthest(&path, stroke))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fault(curves: &str) -> String {
        let text = format!("figure = \"test\"\n[[stroke]]\nname = \"bad\"\ncurves_mm = {curves}\n");
        load(&[("test.toml", &text)]).err().map(|fault| fault.to_string()).unwrap_or_default()
    }

    #[test]
    fn the_library_holds_the_figures_of_the_task() {
        let strokes = strokes().unwrap();
        let count = |prefix: &str| strokes.iter().filter(|stroke| stroke.name().starts_with(prefix)).count();
        assert_eq!((count("pentagram"), count("heart")), (5, 2));
        assert!(strokes.len() - 7 >= 4, "calligraphic strokes");
        for stroke in strokes {
            let deviation = deviation_m(&stroke.scaled_and_turned(MAX_SCALE, 0.0));
            println!(
                "{}: {:.0} mm, left by {:.2} mm",
                stroke.name(),
                1e3 * stroke.length_m(),
                1e3 * deviation
            );
        }
    }

    #[test]
    fn the_lines_of_the_pentagram_follow_one_another() {
        let strokes = strokes().unwrap();
        for pair in strokes[..5].windows(2) {
            assert!(distance(pair[0].points_m(2)[1], pair[1].points_m(2)[0]) < 1e-12);
        }
    }

    #[test]
    fn what_cannot_be_painted_is_refused_by_name() {
        let cases = [
            ("[]", "at least one curve"),
            ("[[[0, 0]]]", "two to four control points, got 1"),
            ("[[[0, 0], [nan, 50]]]", "finite"),
            ("[[[0, 0], [60, 0]], [[61, 0], [120, 0]]]", "begin where curve 0 ends, got 1.0 mm"),
            ("[[[0, 0], [60, 0]], [[60, 0], [100, 40]]]", "no kink where curve 0 ends, got 0.79 rad"),
            ("[[[0, 0], [0, 0], [60, 0]]]", "coincide"),
            ("[[[0, 0], [40, 0]]]", "a length of 50 to 280 mm, got 40 mm"),
            ("[[[-142, -142], [140, 140]]]", "got 399 mm"),
            ("[[[60, 0], [160, 0]]]", "within 145 mm of the board's middle, got 160 mm"),
            ("[[[0, 0], [120, 120], [-120, 120], [5, 0]]]", "an open stroke"),
            // Five half-waves on less than 280 mm: seven poses cannot follow.
            (
                "[[[-75, 0], [-65, 28], [-55, 28], [-45, 0]], [[-45, 0], [-35, -28], [-25, -28], [-15, 0]], \
                 [[-15, 0], [-5, 28], [5, 28], [15, 0]], [[15, 0], [25, -28], [35, -28], [45, 0]], \
                 [[45, 0], [55, 28], [65, 28], [75, 0]]]",
                "executed path within 3 mm",
            ),
        ];
        for (curves, expected) in cases {
            let fault = fault(curves);
            assert!(fault.contains(expected) && fault.contains("test.toml"), "{curves}: {fault}");
        }
    }

    #[test]
    fn files_that_are_not_libraries_are_refused() {
        let load = |text: &str| load(&[("test.toml", text)]).unwrap_err().to_string();
        assert!(load("figure = \"x\"\nstroke = []\n").contains("no stroke"));
        assert!(load("figure = \"x\"\ncolour = 1\nstroke = []\n").contains("colour"));
        assert!(load("figure = ").contains("test.toml"));
        let twice = "[[stroke]]\nname = \"a\"\ncurves_mm = [[[0, 0], [90, 0]]]\n".repeat(2);
        assert!(load(&format!("figure = \"x\"\n{twice}")).contains("twice"));
    }
}
