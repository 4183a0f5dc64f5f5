//! The three curves of a run: error against integration steps, error along the trajectory, training.

use super::{LinePlot, Scale, Series};
use crate::metrics::Scores;

/// A predictor and what it scores.
#[derive(Debug, Clone, Copy)]
pub struct PredictorCurve<'a> {
    /// Its name in the legend.
    pub label: &'a str,
    /// Its scores.
    pub scores: &'a Scores,
}

/// D̄_geo against the number of integration steps, with the standard deviation over noise seeds as a band, beside predictors that
/// take no steps.
pub fn d_geo_against_steps(title: &str, rows: &[(usize, &Scores)], trivial: &[PredictorCurve<'_>]) -> LinePlot {
    let policy = Series {
        label: "policy (band: ± 1 std over seeds)".to_owned(),
        points: rows.iter().map(|(steps, scores)| (*steps as f64, scores.d_geo_mean)).collect(),
        half_band: Some(rows.iter().map(|(_, scores)| scores.d_geo_std.unwrap_or(0.0)).collect()),
        dashed: false,
    };
    let steps = || rows.iter().map(|(steps, _)| *steps as f64);
    let (first, last) = (steps().fold(f64::INFINITY, f64::min), steps().fold(0.0, f64::max));
    let level = |predictor: &PredictorCurve<'_>| Series {
        label: predictor.label.to_owned(),
        points: [first, last].map(|steps| (steps, predictor.scores.d_geo_mean)).to_vec(),
        half_band: None,
        dashed: true,
    };
    LinePlot {
        title: title.to_owned(),
        x_label: "integration steps (drift evaluations)".to_owned(),
        y_label: "mean D_geo (rad ⊕ m)".to_owned(),
        x_scale: Scale::Log,
        y_scale: Scale::Linear,
        series: std::iter::once(policy).chain(trivial.iter().map(level)).collect(),
    }
}

/// D_geo of each action of the trajectory; predictors whose label is among `dashed` are drawn dashed.
pub fn per_action_error(title: &str, solid: &[PredictorCurve<'_>], dashed: &[PredictorCurve<'_>]) -> LinePlot {
    let series = |predictor: &PredictorCurve<'_>, dashed| Series {
        label: predictor.label.to_owned(),
        points: (1..).map(f64::from).zip(predictor.scores.per_action_mean.iter().copied()).collect(),
        half_band: None,
        dashed,
    };
    LinePlot {
        title: title.to_owned(),
        x_label: "action step".to_owned(),
        y_label: "mean D_geo (rad ⊕ m)".to_owned(),
        x_scale: Scale::Linear,
        y_scale: Scale::Linear,
        series: solid.iter().map(|p| series(p, false)).chain(dashed.iter().map(|p| series(p, true))).collect(),
    }
}

/// Named quantities against the update; values that are not positive are left out.
pub fn training_curve(title: &str, curves: &[(&str, Vec<(f64, f64)>)]) -> LinePlot {
    let series = |(label, points): &(&str, Vec<(f64, f64)>)| Series {
        label: (*label).to_owned(),
        points: points.iter().copied().filter(|(_, value)| *value > 0.0 && value.is_finite()).collect(),
        half_band: None,
        dashed: false,
    };
    LinePlot {
        title: title.to_owned(),
        x_label: "update".to_owned(),
        y_label: "loss, and D_geo (rad ⊕ m) on validation".to_owned(),
        x_scale: Scale::Linear,
        y_scale: Scale::Log,
        series: curves.iter().map(series).filter(|series| !series.points.is_empty()).collect(),
    }
}
