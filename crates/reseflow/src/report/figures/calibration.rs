//! Whether the nodes know how wrong they are: their spread against the true error.

use super::look;
use super::panels::{block, plot, series};
use crate::learners::Learner;
use crate::metrics::CalibrationBin;
use crate::plot::{LinePlot, Look, Scale, Series};
use crate::report::document::Block;
use crate::report::study::{Group, Study, fewest, learner_title, task_title};

/// One panel a task, one line a policy, through bins of as many actions each.
pub(super) fn chart(study: &Study, group: Group) -> anyhow::Result<Block> {
    let panel = |task: &str| {
        let learners = study.learners(group, task).into_iter();
        let mut lines: Vec<Series> = learners
            .filter_map(|learner| {
                let row = fewest(study.scores(group, task, learner)?)?;
                Some(line(learner, &row.calibration.as_ref()?.bins))
            })
            .filter(|line| !line.points.is_empty())
            .collect();
        lines.extend(diagonal(&lines));
        LinePlot {
            y_label: "true mean D_geo (rad, m)".to_owned(),
            x_ticks: None,
            series: lines,
            ..plot(task_title(task), "spread of the nodes (rad, m)", Scale::Log, Vec::new())
        }
    };
    let panels = study.unimodal(group).iter().map(|run| panel(&run.task)).collect();
    block(
        format!("calibration-{}", group.slug()),
        format!("What the nodes' spread says of the error, {}", group.title()),
        "Predicted actions of all held-out episodes and noise seeds with the fewest steps, sorted by the nodes' distance from their \
         consensus and cut into ten groups of as many: the mean spread of each group against the mean of its D_geo to the truth. A line \
         that rises says that disagreement warns of errors; one above the dotted diagonal, that the error is larger than the \
         disagreement."
            .to_owned(),
        panels,
        false,
        format!("calibration with {}: no policy for a single expert has nodes whose spread was measured.", group.title()),
    )
}

/// A policy's bins; those without any spread have no place on a logarithmic axis.
fn line(learner: Learner, bins: &[CalibrationBin]) -> Series {
    let bins = bins.iter().filter(|bin| bin.spread > 0.0);
    series(learner_title(learner), look(learner), bins.map(|bin| (bin.spread, bin.d_geo, None)))
}

/// Where spread and error would be equal, as far as `lines` go.
fn diagonal(lines: &[Series]) -> Option<Series> {
    let spreads = || lines.iter().flat_map(|line| line.points.iter().map(|(spread, _)| *spread));
    let ends = [spreads().fold(f64::INFINITY, f64::min), spreads().fold(0.0, f64::max)];
    let look = Look::reference(0);
    (!lines.is_empty())
        .then(|| series("error = spread".to_owned(), look, ends.map(|end| (end, end, None)).into_iter()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_diagonal_spans_every_spread_and_bins_without_any_are_left_out() {
        let bin = |spread, d_geo| CalibrationBin { actions: 5, spread, d_geo };
        let bins = [bin(0.0, 0.1), bin(0.01, 0.2), bin(0.03, 0.5)];
        let lines = [line(Learner::Flow(1), &bins), line(Learner::Flow(2), &[bin(0.02, 0.9), bin(0.2, 0.1)])];
        assert_eq!(lines[0].points, [(0.01, 0.2), (0.03, 0.5)]);
        assert_eq!(diagonal(&lines).unwrap().points, [(0.01, 0.01), (0.2, 0.2)]);
        assert!(diagonal(&[]).is_none());
    }
}
