//! Runs side by side: grouped by how many demonstrations they learned from, so that each figure compares like with like.

use super::gather::Run;
use super::paper;
use crate::evaluation::{EvalReport, StepRow};
use crate::learners::Learner;

/// All runs of a report.
#[derive(Debug)]
pub(super) struct Study {
    pub(super) runs: Vec<Run>,
}

/// How many demonstrations runs learned from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Group {
    /// As many as the paper, task by task.
    Paper,
    /// As many as served the policies that ship, task by task.
    Shipped,
    /// So many.
    Count(usize),
    /// Nothing says.
    Unknown,
}

impl Group {
    fn of(run: &Run) -> Self {
        if run.shipped {
            return Self::Shipped;
        }
        match run.demonstrations {
            Some(count) if paper::of_task(&run.task).is_some_and(|task| task.demonstrations == count) => {
                Self::Paper
            }
            Some(count) => Self::Count(count),
            None => Self::Unknown,
        }
    }

    /// What titles call it.
    pub(super) fn title(self) -> String {
        match self {
            Self::Paper => "the paper's numbers of demonstrations".to_owned(),
            Self::Shipped => "the shipped policies".to_owned(),
            Self::Count(count) => format!("{count} demonstrations a task"),
            Self::Unknown => "an unknown number of demonstrations".to_owned(),
        }
    }

    /// What files are called.
    pub(super) fn slug(self) -> String {
        match self {
            Self::Paper => "paper".to_owned(),
            Self::Shipped => "shipped".to_owned(),
            Self::Count(count) => format!("{count}"),
            Self::Unknown => "unknown".to_owned(),
        }
    }
}

/// What figures call a policy.
pub(super) fn learner_title(learner: Learner) -> String {
    match learner {
        Learner::Flow(flow) => format!("Flow {flow}"),
        Learner::Baseline => "ET-SEED".to_owned(),
        Learner::Regressor => "regressor".to_owned(),
    }
}

/// What figures call a task.
pub(super) fn task_title(task: &str) -> String {
    paper::of_task(task).map_or_else(|| task.replace('_', " "), |known| known.title.to_owned())
}

/// `1 step`, `10 steps`.
pub(super) fn steps_title(steps: usize) -> String {
    format!("{steps} step{}", if steps == 1 { "" } else { "s" })
}

impl Study {
    /// Sorted by the paper's order of tasks.
    pub(super) fn new(mut runs: Vec<Run>) -> Self {
        let place =
            |run: &Run| paper::TASKS.iter().position(|known| known.task == run.task).unwrap_or(usize::MAX);
        runs.sort_by_key(place);
        Self { runs }
    }

    /// The groups that occur, the paper's first, then from more demonstrations to fewer.
    pub(super) fn groups(&self) -> Vec<Group> {
        let mut groups: Vec<Group> = Vec::new();
        for group in self.runs.iter().map(Group::of) {
            if !groups.contains(&group) {
                groups.push(group);
            }
        }
        groups.sort_by_key(|group| match group {
            Group::Paper => 0,
            Group::Shipped => 1,
            Group::Count(count) => usize::MAX - 1 - count,
            Group::Unknown => usize::MAX,
        });
        groups
    }

    /// The first run of each task in a group, those whose episodes have two experts left out: what figures over tasks show.
    pub(super) fn unimodal(&self, group: Group) -> Vec<&Run> {
        let mut chosen: Vec<&Run> = Vec::new();
        for run in self.runs.iter().filter(|run| Group::of(run) == group && !run.has_modes()) {
            if !chosen.iter().any(|other| other.task == run.task) {
                chosen.push(run);
            }
        }
        chosen
    }

    /// The scores of `learner` on a task in a group: those of the first run that has them, so that a baseline may lie in its own folder.
    pub(super) fn scores(&self, group: Group, task: &str, learner: Learner) -> Option<&EvalReport> {
        let runs = self.runs.iter().filter(|run| Group::of(run) == group && run.task == task);
        runs.filter_map(|run| run.on_test(learner)).next()
    }

    /// The policies that a task has in a group: flows in order, the baseline, the regressor.
    pub(super) fn learners(&self, group: Group, task: &str) -> Vec<Learner> {
        let flows = (1..=9).map(Learner::Flow);
        let all = flows.chain([Learner::Baseline, Learner::Regressor]);
        all.filter(|learner| self.scores(group, task, *learner).is_some()).collect()
    }
}

/// The row with so many steps.
pub(super) fn row_at(report: &EvalReport, steps: usize) -> Option<&StepRow> {
    report.rows.iter().find(|row| row.steps == steps)
}

/// The row with the fewest steps.
pub(super) fn fewest(report: &EvalReport) -> Option<&StepRow> {
    report.rows.iter().min_by_key(|row| row.steps)
}

/// The row with the most steps.
pub(super) fn most(report: &EvalReport) -> Option<&StepRow> {
    report.rows.iter().max_by_key(|row| row.steps)
}
