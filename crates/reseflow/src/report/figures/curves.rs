//! Curves: over integration steps, along the trajectory, over nodes, over training.

use serde_json::Value;

use super::look;
use super::panels::{block, plot, series};
use crate::evaluation::StepRow;
use crate::learners::Learner;
use crate::plot::{Dash, LinePlot, Look, Scale};
use crate::report::document::Block;
use crate::report::gather::text;
use crate::report::study::{Group, Study, fewest, learner_title, most, row_at, steps_title, task_title};

/// The steps that the paper shows trajectories at.
const SHOWN_STEPS: [usize; 4] = [1, 2, 50, 100];

/// D̄_geo over integration steps, a panel a task (the paper's figure 4).
pub(super) fn over_steps(study: &Study, group: Group) -> anyhow::Result<Block> {
    let panel = |task: &str| {
        let learners = study.learners(group, task);
        let reports: Vec<_> = learners
            .iter()
            .filter_map(|&learner| Some((learner, study.scores(group, task, learner)?)))
            .collect();
        let mut steps: Vec<usize> =
            reports.iter().flat_map(|(_, report)| report.rows.iter().map(|row| row.steps)).collect();
        steps.sort_unstable();
        steps.dedup();
        let ends = [steps.first().copied().unwrap_or(1) as f64, steps.last().copied().unwrap_or(1) as f64];
        let mut plot = plot(
            task_title(task),
            "integration steps",
            Scale::Log,
            steps.iter().map(|&steps| steps as f64).collect(),
        );
        plot.series.extend(reports.iter().map(|(learner, report)| {
            let rows =
                report.rows.iter().map(|row| (row.steps as f64, row.scores.d_geo_mean, row.scores.d_geo_std));
            series(learner_title(*learner), look(*learner), rows)
        }));
        if let Some(trivial) = reports.iter().find_map(|(_, report)| report.trivial.as_ref()) {
            let known = [
                ("mean trajectory", &trivial.mean_trajectory),
                ("nearest demonstration", &trivial.nearest_demonstration),
            ];
            for (index, (label, scores)) in known.into_iter().enumerate() {
                let level = ends.map(|end| (end, scores.d_geo_mean, None));
                plot.series.push(series(label.to_owned(), Look::reference(index), level.into_iter()));
            }
        }
        plot
    };
    let panels = study.unimodal(group).iter().map(|run| panel(&run.task)).collect();
    block(
        format!("steps-{}", group.slug()),
        format!("D_geo over integration steps, {}", group.title()),
        "D̄_geo on held-out episodes over the number of integration steps, both axes logarithmic; bands: ± 1 standard deviation over \
         noise seeds. (The paper's figure of the same content is its fourth.)"
            .to_owned(),
        panels,
        false,
        format!("D̄_geo over steps with {}: no task with a single expert was scored on the test split.", group.title()),
    )
}

/// D_geo of each action at a few numbers of steps, a figure a task (the paper's figures 5 to 7).
pub(super) fn along_the_trajectory(study: &Study, group: Group) -> anyhow::Result<Vec<Block>> {
    let mut blocks = Vec::new();
    for run in study.unimodal(group) {
        let learners = study.learners(group, &run.task);
        let flows: Vec<Learner> =
            learners.iter().copied().filter(|learner| matches!(learner, Learner::Flow(_))).collect();
        let baseline = study.scores(group, &run.task, Learner::Baseline).and_then(most);
        let line = |label: String, learner, row: &StepRow| {
            let scores = &row.scores;
            let actions = scores.per_action_mean.iter().zip(&scores.per_action_std).zip(1..);
            series(
                label,
                look(learner),
                actions.map(|((mean, std), action)| (f64::from(action), *mean, *std)),
            )
        };
        let panel = |steps: usize| {
            let actions = (1..=10).map(f64::from).collect();
            let mut plot = plot(steps_title(steps), "action", Scale::Linear, actions);
            for &flow in &flows {
                let row = study.scores(group, &run.task, flow).and_then(|report| row_at(report, steps));
                plot.series.extend(row.map(|row| line(learner_title(flow), flow, row)));
            }
            if !plot.series.is_empty() {
                let label = |row: &StepRow| {
                    format!("{}, {}", learner_title(Learner::Baseline), steps_title(row.steps))
                };
                plot.series.extend(baseline.map(|row| line(label(row), Learner::Baseline, row)));
            }
            plot
        };
        blocks.push(block(
            format!("actions-{}-{}", run.task, group.slug()),
            format!("{}: D_geo along the trajectory, {}", task_title(&run.task), group.title()),
            "D_geo of each action of the trajectory, mean over held-out episodes; bands: ± 1 standard deviation over noise seeds. The \
             baseline is shown with its most steps in every panel, as in the paper."
                .to_owned(),
            SHOWN_STEPS.into_iter().map(panel).collect(),
            true,
            format!("D_geo along the trajectory of {}: no flow was scored at 1, 2, 50 or 100 steps.", run.name),
        )?);
    }
    Ok(blocks)
}

/// D̄_geo of each node and of the consensus, with the fewest steps.
pub(super) fn over_nodes(study: &Study, group: Group) -> anyhow::Result<Block> {
    let panel = |task: &str| {
        let rows: Vec<(Learner, &StepRow)> = (study.learners(group, task).into_iter())
            .filter_map(|learner| Some((learner, fewest(study.scores(group, task, learner)?)?)))
            .filter(|(_, row)| !row.per_node.is_empty())
            .collect();
        let nodes = rows.iter().map(|(_, row)| row.per_node.len()).max().unwrap_or(0);
        let ticks = (1..=nodes).map(|node| node as f64).collect();
        let mut plot = plot(task_title(task), "node (line: consensus)", Scale::Linear, ticks);
        for (learner, row) in rows {
            let look = look(learner);
            let points = row.per_node.iter().zip(1..).map(|(node, place)| (f64::from(place), *node, None));
            let dots = series(learner_title(learner), Look { dash: Dash::Absent, ..look }, points);
            let level = [1.0, nodes as f64].map(|x| (x, row.scores.d_geo_mean, None));
            let label = format!("{}, consensus", learner_title(learner));
            plot.series.push(dots);
            plot.series.push(series(label, Look { marker: None, ..look }, level.into_iter()));
        }
        plot
    };
    let panels = study.unimodal(group).iter().map(|run| panel(&run.task)).collect();
    block(
        format!("nodes-{}", group.slug()),
        format!("D_geo of each node, {}", group.title()),
        "D̄_geo of the trajectory that each node predicts by itself (markers) and of the consensus of all (line), with the fewest steps. A \
         consensus below its nodes says that their errors are partly independent."
            .to_owned(),
        panels,
        false,
        format!("nodes with {}: no policy answers node by node.", group.title()),
    )
}

/// D̄_geo on validation episodes over the updates of the training, a panel a run.
pub(super) fn training(study: &Study) -> anyhow::Result<Block> {
    let mut panels = Vec::new();
    for run in &study.runs {
        let mut plot =
            LinePlot { x_ticks: None, ..plot(run.name.clone(), "update", Scale::Linear, Vec::new()) };
        for learner in (1..=9).map(Learner::Flow).chain([Learner::Baseline, Learner::Regressor]) {
            let Some(path) = run.find(&format!("{}/metrics.jsonl", learner.name("checkpoint"))) else {
                continue;
            };
            let points = validation(&text(&path)?.unwrap_or_default());
            let look = look(learner);
            plot.series.push(series(learner_title(learner), look, points.into_iter()));
        }
        panels.push(plot);
    }
    block(
        "training".to_owned(),
        "D_geo on validation episodes while training".to_owned(),
        "D̄_geo of the averaged weights on the validation split, as the trainer noted it. Flow 2 starts from Flow 1's weights.".to_owned(),
        panels,
        false,
        "training curves: no checkpoint holds validation scores.".to_owned(),
    )
}

/// The updates and scores of the lines that hold both.
fn validation(lines: &str) -> Vec<(f64, f64, Option<f64>)> {
    let point = |line: &str| {
        let line: Value = serde_json::from_str(line).ok()?;
        Some((line["update"].as_f64()?, line["d_geo"].as_f64()?, None))
    };
    lines.lines().filter_map(point).collect()
}
