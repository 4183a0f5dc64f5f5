//! Data efficiency: the main method by the number of demonstrations that it learned from.

use super::super::document::{Block, Table, dash, decimals};
use super::super::gather::Run;
use super::super::study::{Study, fewest, task_title};
use crate::learners::Learner;
use crate::metrics::Scores;

/// One row a task and number of demonstrations.
pub(in super::super) fn by_demonstrations(study: &Study) -> Block {
    let mut table = Table::new(
        "D̄_geo on held-out episodes in one step (the fewest that were scored) by the number of demonstrations, with its 95 % bootstrap \
         interval over episodes, beside that of the demonstration whose scene is most alike. Every number is a training of its own, set \
         as its configuration says.",
        [
            "task",
            "demonstrations",
            "run",
            "Flow 1",
            "95 % interval",
            "Flow 2",
            "95 % interval",
            "nearest demonstration",
        ],
    );
    for run in study.by_demonstrations() {
        let [one, interval_one] = cells(scores(run, Learner::Flow(1)));
        let [two, interval_two] = cells(scores(run, Learner::Flow(2)));
        let trivial = run.on_test(Learner::Flow(1)).and_then(|report| report.trivial.as_ref());
        // Of shipped policies it is among other demonstrations than they learned from.
        let trivial = trivial.filter(|trivial| Some(trivial.training_episodes) == run.demonstrations);
        table.row([
            task_title(&run.task),
            run.demonstrations.map_or_else(dash, |count| count.to_string()),
            run.name.clone(),
            one,
            interval_one,
            two,
            interval_two,
            trivial.map_or_else(dash, |trivial| decimals(trivial.nearest_demonstration.d_geo_mean)),
        ]);
    }
    table.or_absent("the number of demonstrations: no run of Flow 1 says how many it learned from.")
}

fn scores(run: &Run, learner: Learner) -> Option<&Scores> {
    Some(&fewest(run.on_test(learner)?)?.scores)
}

fn cells(scores: Option<&Scores>) -> [String; 2] {
    let Some(scores) = scores else { return [dash(), dash()] };
    let interval = scores.d_geo_low.zip(scores.d_geo_high);
    let interval = interval.map(|(low, high)| format!("{low:.4} to {high:.4}"));
    [decimals(scores.d_geo_mean), interval.unwrap_or_else(dash)]
}
