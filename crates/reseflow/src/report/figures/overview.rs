//! README's picture, made from `results.json`: D̄_geo over integration steps for each task of the paper, beside the paper's numbers.

use super::look;
use super::panels::{plot, series};
use crate::learners::Learner;
use crate::plot::{Dash, LinePlot, Look, Marker, Panels, Picture, PlotError, Scale, Series};
use crate::report::document::Block;
use crate::report::paper::{PaperTask, TASKS};
use crate::report::results::{Results, RunResult};
use crate::report::study::learner_title;

const TITLE: &str =
    "D_geo over integration steps on held-out scenes, beside the paper's numbers (lower is better)";
const PANEL_SIZE: (f64, f64) = (345.0, 330.0);

/// The figure, or the sentence that says why there is none.
pub(in crate::report) fn chart(results: &Results) -> anyhow::Result<Block> {
    Ok(match picture(results)? {
        Some(picture) => Block::figure(
            "overview",
            "D̄_geo on held-out episodes over the number of integration steps, the first run of each task, both axes logarithmic; bands: ± 1 \
             standard deviation over noise seeds. Crosses: what the paper's text reports of its own simulator, of ReSeFlow in one step and \
             of ET-SEED in 100. Further down is better; a flat line needs one step only.",
            picture,
        ),
        None => Block::absent("the overview: no task of the paper was scored on the test split."),
    })
}

/// One panel a task; `None` where no task has one.
pub(in crate::report) fn picture(results: &Results) -> Result<Option<Picture>, PlotError> {
    let panels: Vec<LinePlot> =
        TASKS.iter().filter_map(|task| panel(task, first_run(results, task)?)).collect();
    if panels.is_empty() {
        return Ok(None);
    }
    let columns = panels.len();
    // One range of y for all, so that panels can be compared.
    let panels = Panels { title: TITLE.to_owned(), columns, panel_size: PANEL_SIZE, shared_y: true, panels };
    Ok(Some(panels.picture()?))
}

/// The first run of a task that was scored.
fn first_run<'a>(results: &'a Results, task: &PaperTask) -> Option<&'a RunResult> {
    let scored = |run: &&RunResult| run.policies.iter().any(|policy| policy.split == "test");
    let of_task = |run: &&RunResult| run.task == task.task && run.variant.is_none() && !run.two_experts;
    results.runs.iter().filter(of_task).find(scored)
}

fn panel(task: &PaperTask, run: &RunResult) -> Option<LinePlot> {
    let mut lines: Vec<Series> = Vec::new();
    for learner in [Learner::Flow(1), Learner::Flow(2), Learner::Baseline] {
        let Some(policy) = run.on_test(learner) else { continue };
        let points =
            policy.steps.iter().map(|row| (row.steps as f64, row.error.d_geo_mean, row.error.d_geo_std));
        lines.push(series(format!("{}, ours", learner_title(learner)), look(learner), points));
    }
    let mut steps: Vec<f64> = lines.iter().flat_map(|line| line.points.iter().map(|(x, _)| *x)).collect();
    steps.sort_by(f64::total_cmp);
    steps.dedup();
    let ends = [*steps.first()?, *steps.last()?];
    if let Some(nearest) = &run.nearest_demonstration {
        let level = ends.map(|end| (end, nearest.d_geo_mean, None));
        let among = run.nearest_among.map(|count| format!(" of {count}")).unwrap_or_default();
        lines.push(series(format!("nearest demonstration{among}"), Look::reference(0), level.into_iter()));
    }
    let told = [
        ("ReSeFlow, the paper, 1 step", Learner::Flow(2), 1.0, task.one_step),
        ("ET-SEED, the paper, 100 steps", Learner::Baseline, 100.0, task.baseline_hundred),
    ];
    for (name, learner, steps, text) in told {
        let cross = Look { dash: Dash::Absent, marker: Some(Marker::Cross), ..look(learner) };
        let point = PaperTask::number(text).map(|value| (steps, value, None));
        lines.push(series(name.to_owned(), cross, point.into_iter()));
    }
    let count = run.demonstrations.map(|count| format!(", {count} demonstrations")).unwrap_or_default();
    Some(LinePlot {
        series: lines,
        ..plot(format!("{}{count}", task.title), "integration steps", Scale::Log, steps)
    })
}
