//! Table I of the paper, and its text, beside ours.

use super::super::document::{Block, Table, dash};
use super::super::paper::TASKS;
use super::super::study::{Group, Study, fewest, learner_title, most, steps_title};
use crate::evaluation::{EvalReport, StepRow};
use crate::learners::Learner;

/// One table: the paper's rows, then ours for each number of demonstrations.
pub(in super::super) fn beside_the_paper(study: &Study) -> Block {
    let mut table = Table::new(
        "D̄_geo, mean ± standard deviation over noise seeds, lower is better. Table I of the paper does not say its integration steps; \
         its text does, and marks its values as approximate. Over training seeds: mean ± standard deviation over trainings.",
        ["", TASKS[0].title, TASKS[1].title, TASKS[2].title],
    );
    for learner in [Learner::Baseline, Learner::Flow(1), Learner::Flow(2)] {
        let title = learner_title(learner);
        let known = TASKS
            .each_ref()
            .map(|task| task.in_table(learner).map_or_else(dash, |value| format!("{value:.3}")));
        push(&mut table, format!("{title}, paper, Table I"), known);
        match learner {
            Learner::Baseline => {
                let told = TASKS.each_ref().map(|task| task.baseline_hundred.to_owned());
                push(&mut table, format!("{title}, paper, text, 100 steps"), told);
            }
            Learner::Flow(2) => {
                let told = TASKS.each_ref().map(|task| task.one_step.to_owned());
                push(&mut table, format!("{title}, paper, text, 1 step"), told);
                let told = TASKS.each_ref().map(|task| task.more_steps.to_owned());
                push(&mut table, format!("{title}, paper, text, more steps"), told);
            }
            _ => {}
        }
        for group in study.groups() {
            ours(&mut table, study, group, learner);
        }
    }
    Block::Table(table)
}

/// The rows with the fewest and the most steps, as far as tasks have them.
fn ours(table: &mut Table, study: &Study, group: Group, learner: Learner) {
    let reports = TASKS.each_ref().map(|task| {
        let counts = study.unimodal(group).into_iter().any(|run| run.task == task.task);
        counts.then(|| study.scores(group, task.task, learner)).flatten()
    });
    let picks: [fn(&EvalReport) -> Option<&StepRow>; 2] = [fewest, most];
    for pick in picks {
        let rows = reports.map(|report| report.and_then(pick));
        let Some(steps) = rows.iter().flatten().map(|row: &&StepRow| row.steps).next() else { continue };
        let title = format!("{}, ours, {}, {}", learner_title(learner), steps_title(steps), group.title());
        if table.rows.iter().any(|row| row[0] == title) {
            continue;
        }
        let cell = |row: Option<&StepRow>| match row {
            Some(row) if row.steps == steps => spread(row),
            Some(row) => format!("{} ({})", spread(row), steps_title(row.steps)),
            None => dash(),
        };
        push(table, title, rows.map(cell));
        over_seeds(table, study, group, learner, steps);
    }
}

/// The row over training seeds, where a task has several.
fn over_seeds(table: &mut Table, study: &Study, group: Group, learner: Learner, steps: usize) {
    let (pools, _) = study.pools();
    let cells = TASKS.each_ref().map(|task| {
        let run = study.unimodal(group).into_iter().find(|run| run.task == task.task)?;
        let pool = pools.iter().find(|pool| pool.runs.iter().any(|member| member.name == run.name))?;
        let rows = pool.rows();
        let row = rows
            .iter()
            .find(|row| row.learner == learner && row.split == "test" && row.rows[0].steps == steps)?;
        let over = row.over(|row| row.scores.d_geo_mean)?;
        Some(format!("{} ({} training seeds)", over.text(), over.values.len()))
    });
    if cells.iter().any(Option::is_some) {
        let name = format!("{}, ours, {}", learner_title(learner), steps_title(steps));
        let title = format!("{name}, {}, over training seeds", group.title());
        push(table, title, cells.map(|cell| cell.unwrap_or_else(dash)));
    }
}

fn spread(row: &StepRow) -> String {
    let std = row.scores.d_geo_std.map(|std| format!(" ± {std:.4}")).unwrap_or_default();
    format!("{:.4}{std}", row.scores.d_geo_mean)
}

fn push(table: &mut Table, title: String, [door, painting, triangle]: [String; 3]) {
    table.row([title, door, painting, triangle]);
}
