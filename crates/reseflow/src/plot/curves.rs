//! The three curves of a run: error against integration steps, error along the trajectory, training.

use super::{Dash, LinePlot, Look, Scale, Series};
use crate::evaluation::TrivialScores;
use crate::metrics::Scores;

/// A predictor and what it scores.
#[derive(Debug, Clone, Copy)]
pub struct PredictorCurve<'a> {
    /// Its name in the legend.
    pub label: &'a str,
    /// Its scores.
    pub scores: &'a Scores,
}

impl<'a> PredictorCurve<'a> {
    /// The two trivial predictors.
    pub fn trivial(scores: &'a TrivialScores) -> [Self; 2] {
        [
            Self { label: "mean trajectory", scores: &scores.mean_trajectory },
            Self { label: "nearest demonstration", scores: &scores.nearest_demonstration },
        ]
    }
}

/// D̄_geo against the number of integration steps, with the standard deviation over noise seeds as a band, beside predictors that
/// take no steps.
pub fn d_geo_against_steps(
    title: &str,
    rows: &[(usize, &Scores)],
    trivial: &[PredictorCurve<'_>],
) -> LinePlot {
    let policy = Series {
        label: "policy (band: ± 1 std over seeds)".to_owned(),
        points: rows.iter().map(|(steps, scores)| (*steps as f64, scores.d_geo_mean)).collect(),
        band: Some(rows.iter().map(|(_, scores)| one_std(scores)).collect()),
        names: None,
        look: Look { dash: Dash::Solid, ..Look::policy(0) },
    };
    let steps = || rows.iter().map(|(steps, _)| *steps as f64);
    let (first, last) = (steps().fold(f64::INFINITY, f64::min), steps().fold(0.0, f64::max));
    let level = |(index, predictor): (usize, &PredictorCurve<'_>)| Series {
        label: predictor.label.to_owned(),
        points: [first, last].map(|steps| (steps, predictor.scores.d_geo_mean)).to_vec(),
        band: None,
        names: None,
        look: Look::reference(index),
    };
    LinePlot {
        title: title.to_owned(),
        x_label: "integration steps (drift evaluations)".to_owned(),
        y_label: "mean D_geo (rad, m)".to_owned(),
        x_scale: Scale::Log,
        y_scale: Scale::Linear,
        x_ticks: Some(steps().collect()),
        series: std::iter::once(policy).chain(trivial.iter().enumerate().map(level)).collect(),
    }
}

/// One standard deviation over noise seeds below the mean and above it.
fn one_std(scores: &Scores) -> (f64, f64) {
    let std = scores.d_geo_std.unwrap_or(0.0);
    (scores.d_geo_mean - std, scores.d_geo_mean + std)
}

/// D_geo of each action of the trajectory, of policies and of what they are compared with.
pub fn per_action_error(
    title: &str,
    policies: &[PredictorCurve<'_>],
    references: &[PredictorCurve<'_>],
) -> LinePlot {
    let series = |predictor: &PredictorCurve<'_>, look| Series {
        label: predictor.label.to_owned(),
        points: (1..).map(f64::from).zip(predictor.scores.per_action_mean.iter().copied()).collect(),
        band: None,
        names: None,
        look,
    };
    LinePlot {
        title: title.to_owned(),
        x_label: "action step".to_owned(),
        y_label: "mean D_geo (rad, m)".to_owned(),
        x_scale: Scale::Linear,
        y_scale: Scale::Linear,
        x_ticks: None,
        series: (policies.iter().zip((0..).map(Look::policy)))
            .chain(references.iter().zip((0..).map(Look::reference)))
            .map(|(predictor, look)| series(predictor, look))
            .collect(),
    }
}

/// Named quantities against the update. A long noisy curve is drawn as the means of `BINS` neighbourhoods; values that are not
/// positive are left out.
pub fn training_curve(title: &str, curves: &[(&str, Vec<(f64, f64)>)]) -> LinePlot {
    let series = |index: usize, label: &str, points: &[(f64, f64)]| {
        let positive = |&(_, value): &(f64, f64)| value > 0.0 && value.is_finite();
        let points: Vec<(f64, f64)> = points.iter().copied().filter(positive).collect();
        Series {
            label: label.to_owned(),
            points: binned(&points),
            band: None,
            names: None,
            look: Look::curve(index),
        }
    };
    LinePlot {
        title: title.to_owned(),
        x_label: "update".to_owned(),
        y_label: "loss; D_geo (rad, m)".to_owned(),
        x_scale: Scale::Linear,
        y_scale: Scale::Log,
        x_ticks: None,
        series: (curves.iter().enumerate())
            .map(|(index, (label, points))| series(index, label, points))
            .filter(|series| !series.points.is_empty())
            .collect(),
    }
}

/// Points that a training curve is reduced to.
const BINS: usize = 150;

fn binned(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let centre = |bin: &[(f64, f64)]| {
        let sum = bin.iter().fold((0.0, 0.0), |sum, point| (sum.0 + point.0, sum.1 + point.1));
        (sum.0 / bin.len() as f64, sum.1 / bin.len() as f64)
    };
    points.chunks(points.len().div_ceil(BINS).max(1)).map(centre).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_curve_is_thinned_and_keeps_its_mean() {
        let noisy: Vec<(f64, f64)> =
            (0..1500).map(|i| (f64::from(i), if i % 2 == 0 { 1.0 } else { 3.0 })).collect();
        let plot = training_curve("t", &[("loss", noisy), ("empty", vec![(1.0, f64::NAN), (2.0, 0.0)])]);
        assert_eq!(plot.series.len(), 1);
        assert_eq!(plot.series[0].points.len(), BINS);
        assert!(plot.series[0].points.iter().all(|&(_, value)| (value - 2.0).abs() < 1e-12));
    }
}
