//! What figures of several panels share: an empty plot of errors, a line of one, and the block that they make.

use crate::plot::{LinePlot, Look, Panels, Scale, Series};
use crate::report::document::Block;

/// An empty plot of D_geo on a logarithmic axis.
pub(super) fn plot(title: String, x_label: &str, x_scale: Scale, x_ticks: Vec<f64>) -> LinePlot {
    LinePlot {
        title,
        x_label: x_label.to_owned(),
        y_label: "mean D_geo (rad, m)".to_owned(),
        x_scale,
        y_scale: Scale::Log,
        x_ticks: Some(x_ticks),
        series: Vec::new(),
    }
}

/// A line through rows that each have an x; values that no logarithmic axis can show are left out.
pub(super) fn series(
    label: String,
    look: Look,
    points: impl Iterator<Item = (f64, f64, Option<f64>)>,
) -> Series {
    let points: Vec<_> = points.filter(|(_, y, _)| *y > 0.0).collect();
    Series {
        label,
        points: points.iter().map(|(x, y, _)| (*x, *y)).collect(),
        band: Some(points.iter().map(|(_, y, half)| about(*y, *half)).collect()),
        names: None,
        look,
    }
}

/// A band that is as wide below as above.
fn about(y: f64, half: Option<f64>) -> (f64, f64) {
    let half = half.unwrap_or(0.0);
    (y - half, y + half)
}

/// Panels of one size beside each other, or the sentence that says why there are none.
pub(super) fn block(
    name: String,
    title: String,
    caption: String,
    panels: Vec<LinePlot>,
    wide: bool,
    absent: String,
) -> anyhow::Result<Block> {
    let panels: Vec<LinePlot> =
        panels.into_iter().filter(|panel| panel.series.iter().any(|s| !s.points.is_empty())).collect();
    if panels.is_empty() {
        return Ok(Block::Absent(absent));
    }
    let (columns, panel_size) = match (panels.len(), wide) {
        (1, _) => (1, (640.0, 380.0)),
        (2, _) => (2, (460.0, 330.0)),
        (_, true) => (4, (272.0, 280.0)),
        _ => (3, (345.0, 300.0)),
    };
    let panels = Panels { title, columns, panel_size, shared_y: wide, panels };
    Ok(Block::figure(name, caption, panels.picture()?))
}
