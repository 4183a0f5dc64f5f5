//! What an error costs: D̄_geo against the time of a call, each point a number of steps.

use super::look;
use super::panels::{block, plot};
use crate::evaluation::StepRow;
use crate::learners::Learner;
use crate::plot::{LinePlot, Scale, Series};
use crate::report::document::Block;
use crate::report::study::{Group, Study, learner_title, task_title};

/// One panel a task, one line a policy, through the numbers of steps that were timed.
pub(super) fn chart(study: &Study, group: Group) -> anyhow::Result<Block> {
    let panel = |task: &str| {
        let learners = study.learners(group, task).into_iter();
        let lines = learners
            .filter_map(|learner| Some(line(learner, &study.scores(group, task, learner)?.rows)))
            .filter(|line| !line.points.is_empty());
        LinePlot {
            x_ticks: None,
            series: lines.collect(),
            ..plot(task_title(task), "one call, median (ms)", Scale::Log, Vec::new())
        }
    };
    let panels = study.unimodal(group).iter().map(|run| panel(&run.task)).collect();
    block(
        format!("frontier-{}", group.slug()),
        format!("Error against time, {}", group.title()),
        "D̄_geo on held-out episodes against the median time of one call for one scene, graph and encoder included, both axes logarithmic; \
         the figure at each point is its number of integration steps. Each number of steps was timed by itself, on the machine that the \
         table of origins names. Further left and lower is better: steps that only lead to the right buy nothing."
            .to_owned(),
        panels,
        false,
        format!("error against time with {}: no policy for a single expert was timed on the test split.", group.title()),
    )
}

/// Milliseconds and D̄_geo of the rows that were timed, named by their steps.
fn line(learner: Learner, rows: &[StepRow]) -> Series {
    let timed = rows.iter().filter_map(|row| Some((row, row.latency.as_ref()?.whole_ms.p50)));
    let timed: Vec<_> = timed.filter(|(row, millis)| *millis > 0.0 && row.scores.d_geo_mean > 0.0).collect();
    Series {
        label: learner_title(learner),
        points: timed.iter().map(|(row, millis)| (*millis, row.scores.d_geo_mean)).collect(),
        band: None,
        names: Some(timed.iter().map(|(row, _)| row.steps.to_string()).collect()),
        look: look(learner),
    }
}
