//! What the paper reports, each number with the place where it stands.

use crate::learners::Learner;
use crate::metrics::mean;

/// A task of the paper.
#[derive(Debug)]
pub(super) struct PaperTask {
    /// Its name here.
    pub(super) task: &'static str,
    /// Its name there.
    pub(super) title: &'static str,
    /// Demonstrations that the paper trains with (section "Experiment Setup").
    pub(super) demonstrations: usize,
    /// Table I, "Comparison of the average D̄_geo", which does not say its integration steps: ET-SEED, Flow 1, Flow 2.
    pub(super) table: [f64; 3],
    /// Section "Results": ET-SEED in 100 steps.
    pub(super) baseline_hundred: &'static str,
    /// Section "Results": ReSeFlow in one step; for the door it is said of Flow 2.
    pub(super) one_step: &'static str,
    /// Section "Results": ReSeFlow in more steps.
    pub(super) more_steps: &'static str,
}

/// The tasks in the order of Table I.
pub(super) const TASKS: [PaperTask; 3] = [
    PaperTask {
        task: "door",
        title: "Door opening",
        demonstrations: 10,
        table: [2.360, 0.487, 0.450],
        baseline_hundred: "≈ 2.33",
        one_step: "≈ 0.67",
        more_steps: "≈ 0.36",
    },
    PaperTask {
        task: "painting",
        title: "Painting",
        demonstrations: 31,
        table: [1.756, 0.767, 0.766],
        baseline_hundred: "≈ 1.74",
        one_step: "≈ 0.89",
        more_steps: "≈ 0.75",
    },
    PaperTask {
        task: "triangle",
        title: "Rotating triangle",
        demonstrations: 500,
        table: [2.087, 0.959, 0.876],
        baseline_hundred: "≈ 2.03",
        one_step: "1.59–1.61",
        more_steps: "–",
    },
];

/// The paper's entry on a task.
pub(super) fn of_task(task: &str) -> Option<&'static PaperTask> {
    TASKS.iter().find(|known| known.task == task)
}

impl PaperTask {
    /// The number that one of its texts tells; of a range, the middle.
    pub(super) fn number(text: &str) -> Option<f64> {
        let ends = text.trim_start_matches("≈ ").split('–').map(|end| end.parse().ok());
        mean(&ends.collect::<Option<Vec<f64>>>()?)
    }

    /// What Table I says of a policy.
    pub(super) fn in_table(&self, learner: Learner) -> Option<f64> {
        match learner {
            Learner::Baseline => Some(self.table[0]),
            Learner::Flow(flow @ 1..=2) => Some(self.table[flow]),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_read_as_numbers() {
        assert_eq!(["≈ 2.33", "0.67", "–"].map(PaperTask::number), [Some(2.33), Some(0.67), None]);
        let middle = PaperTask::number("1.59–1.61").unwrap();
        assert!((middle - 1.6).abs() < 1e-12, "{middle}");
    }

    /// The abstract's claims follow from the numbers that the text gives: 48.5 % on painting, 21.9 % on the triangle.
    #[test]
    fn the_reductions_of_the_abstract_follow_from_these_numbers() {
        let number = |text: &str| -> f64 {
            let digits = text.trim_start_matches("≈ ").split('–').next().unwrap_or_default();
            digits.parse().unwrap()
        };
        for (task, reduction) in [("painting", 0.485), ("triangle", 0.219)] {
            let PaperTask { one_step, baseline_hundred, .. } = of_task(task).unwrap();
            let share = 1.0 - number(one_step) / number(baseline_hundred);
            assert!((share - reduction).abs() < 0.006, "{task}: {share}");
        }
    }
}
