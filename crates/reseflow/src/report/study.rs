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
    pub(super) fn of(run: &Run) -> Self {
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

/// The task, the demonstrations, and what sets the run apart where it is an ablation.
pub(super) fn run_title(run: &Run) -> String {
    let count = run.demonstrations.map(|count| format!(", {count} demonstrations")).unwrap_or_default();
    let variant = run.variant.as_ref().map(|variant| format!(", {variant}")).unwrap_or_default();
    format!("{}{count}{variant}", task_title(&run.task))
}

/// The task's place in the paper's order; the others come last.
fn place(run: &Run) -> usize {
    paper::TASKS.iter().position(|known| known.task == run.task).unwrap_or(usize::MAX)
}

/// `1 step`, `10 steps`.
pub(super) fn steps_title(steps: usize) -> String {
    format!("{steps} step{}", if steps == 1 { "" } else { "s" })
}

impl Study {
    /// Sorted by the paper's order of tasks.
    pub(super) fn new(mut runs: Vec<Run>) -> Self {
        runs.sort_by_key(place);
        Self { runs }
    }

    /// The runs of the main method: all that are no ablation.
    pub(super) fn main_runs(&self) -> impl Iterator<Item = &Run> {
        self.runs.iter().filter(|run| run.variant.is_none())
    }

    /// Those of a group.
    fn in_group(&self, group: Group) -> impl Iterator<Item = &Run> {
        self.main_runs().filter(move |run| Group::of(run) == group)
    }

    /// The groups that occur among runs of the main method, the paper's first, then from more demonstrations to fewer. Runs with two
    /// experts count where there are no others.
    pub(super) fn groups(&self) -> Vec<Group> {
        let mut groups: Vec<Group> = Vec::new();
        let has_others = self.main_runs().any(|run| !run.has_modes());
        for group in self.main_runs().filter(|run| !(has_others && run.has_modes())).map(Group::of) {
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

    /// What figures over tasks show: of each task in a group the main method's run with the lowest training seed. Runs whose episodes
    /// have two experts are left out.
    pub(super) fn unimodal(&self, group: Group) -> Vec<&Run> {
        first_seeds(self.in_group(group).filter(|run| !run.has_modes()), |a, b| a.task == b.task)
    }

    /// The scores of `learner` on a task in a group: those of the run that figures show, or of one beside it with the same training
    /// seed, so that a baseline may lie in its own folder.
    pub(super) fn scores(&self, group: Group, task: &str, learner: Learner) -> Option<&EvalReport> {
        let shown = self.unimodal(group).into_iter().find(|run| run.task == task)?;
        let beside = |run: &&Run| run.task == task && run.training_seed == shown.training_seed;
        self.in_group(group).filter(beside).find_map(|run| run.on_test(learner))
    }

    /// Of each task and number of demonstrations the run of Flow 1 with the lowest training seed, from few demonstrations to many.
    pub(super) fn by_demonstrations(&self) -> Vec<&Run> {
        let counts = |run: &&Run| {
            run.demonstrations.is_some() && !run.has_modes() && run.on_test(Learner::Flow(1)).is_some()
        };
        let alike = |a: &Run, b: &Run| a.task == b.task && a.demonstrations == b.demonstrations;
        let mut runs = first_seeds(self.main_runs().filter(counts), alike);
        runs.sort_by_key(|run| (place(run), run.demonstrations));
        runs
    }

    /// The runs that stand for the main method: ablations are left out, and all training seeds but the lowest of each experiment.
    pub(super) fn headline(&self) -> impl Iterator<Item = &Run> {
        let alike = |a: &Run, b: &Run| a.task == b.task && Group::of(a) == Group::of(b);
        let first = first_seeds(self.main_runs(), alike);
        self.main_runs().filter(move |run| {
            first.iter().any(|shown| alike(shown, run) && shown.training_seed == run.training_seed)
        })
    }

    /// The policies that a task has in a group: flows in order, the baseline, the regressor.
    pub(super) fn learners(&self, group: Group, task: &str) -> Vec<Learner> {
        let flows = (1..=9).map(Learner::Flow);
        let all = flows.chain([Learner::Baseline, Learner::Regressor]);
        all.filter(|learner| self.scores(group, task, *learner).is_some()).collect()
    }
}

/// Of each experiment, which are the runs that are `alike`, the first one with the lowest training seed; one without scores, which may
/// still be at work, only where none has any.
pub(super) fn first_seeds<'a>(
    runs: impl Iterator<Item = &'a Run>,
    alike: impl Fn(&Run, &Run) -> bool,
) -> Vec<&'a Run> {
    let rank = |run: &Run| (run.evals.is_empty(), run.training_seed);
    let mut chosen: Vec<&Run> = Vec::new();
    for run in runs {
        match chosen.iter_mut().find(|other| alike(other, run)) {
            Some(other) if rank(run) < rank(other) => *other = run,
            Some(_) => {}
            None => chosen.push(run),
        }
    }
    chosen
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

#[cfg(test)]
mod tests {
    use super::super::samples::{coin_toss, run, scored};
    use super::*;

    const FLOW: Learner = Learner::Flow(1);

    /// Runs of 200 doors: an ablation, the second seed with a baseline, and the first.
    fn doors() -> [Run; 3] {
        let twist = Run { variant: Some("twist".to_owned()), ..run("door-200-twist", "door", 200, 1) };
        let second = scored(run("door-200-seed2", "door", 200, 2), FLOW, &[(1, &[0.2])]);
        let first = scored(run("door-200", "door", 200, 1), FLOW, &[(1, &[0.1])]);
        [
            scored(twist, FLOW, &[(1, &[0.9])]),
            scored(second, Learner::Baseline, &[(1, &[0.7])]),
            scored(first, Learner::Regressor, &[(1, &[0.3])]),
        ]
    }

    fn shown(study: &Study, learner: Learner) -> Option<f64> {
        study.scores(Group::Count(200), "door", learner).map(|report| report.rows[0].scores.d_geo_mean)
    }

    #[test]
    fn no_ablation_and_no_other_seed_stands_in_for_the_main_run() {
        let study = Study::new(doors().into());
        assert_eq!(shown(&study, FLOW), Some(0.1), "not the first run in order, but the first seed");
        assert_eq!(shown(&study, Learner::Baseline), None, "the second seed's is not the first one's");
        assert_eq!(shown(&study, Learner::Regressor), Some(0.3));
        assert_eq!(study.headline().map(|run| run.name.as_str()).collect::<Vec<_>>(), ["door-200"]);
        let [twist, ..] = doors();
        let alone = Study::new(vec![twist]);
        assert_eq!((shown(&alone, FLOW), alone.groups(), alone.headline().count()), (None, Vec::new(), 0));
    }

    #[test]
    fn scenes_with_two_experts_make_no_group_beside_others() {
        let [_, _, first] = doors();
        assert_eq!(Study::new(vec![coin_toss("coin", 1, 0.1, 0.5)]).groups(), [Group::Count(2000)]);
        let study = Study::new(vec![coin_toss("coin", 1, 0.1, 0.5), first]);
        assert_eq!((study.groups(), study.headline().count()), (vec![Group::Count(200)], 2));
    }

    #[test]
    fn a_run_without_scores_hides_none_that_has_some() {
        let [_, second, _] = doors();
        let study = Study::new(vec![run("door-200", "door", 200, 1), second]);
        assert_eq!(shown(&study, FLOW), Some(0.2));
        assert_eq!(study.headline().map(|run| run.name.as_str()).collect::<Vec<_>>(), ["door-200-seed2"]);
    }

    #[test]
    fn a_baseline_of_the_same_seed_may_lie_in_its_own_folder() {
        let [_, _, first] = doors();
        let beside = scored(run("door-200-et", "door", 200, 1), Learner::Baseline, &[(1, &[0.6])]);
        let study = Study::new(vec![first, beside]);
        assert_eq!(shown(&study, Learner::Baseline), Some(0.6));
        assert_eq!(study.unimodal(Group::Count(200)).len(), 1);
    }
}
