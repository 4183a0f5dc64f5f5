//! Ablations: each variant beside the main run of the same task and number of demonstrations.

use super::super::document::{Block, Table, dash, decimals, signed_percent};
use super::super::gather::Run;
use super::super::study::{Group, Study, fewest, first_seeds, row_at, task_title};
use crate::evaluation::EvalReport;
use crate::learners::Learner;
use crate::metrics::PairedDifference;

/// The main method's runs, then one row a variant and task.
pub(in super::super) fn ablations(study: &Study) -> Block {
    let mut table = Table::new(
        "D̄_geo on held-out episodes in one step (the fewest that were scored), and its difference to the main run of the same task and \
         number of demonstrations; positive is worse. In brackets the 95 % bootstrap interval, paired over episodes, where both were \
         scored on the same ones. Turned scenes are the test episodes moved by rigid motions, on which an equivariant policy scores the \
         same.",
        [
            "ablation",
            "task",
            "demonstrations",
            "Flow 1",
            "difference",
            "relative",
            "Flow 2",
            "difference",
            "relative",
            "Flow 1, turned scenes",
        ],
    );
    let same_data = |a: &Run, b: &Run| a.task == b.task && a.demonstrations == b.demonstrations;
    let counts = |run: &&Run| {
        run.variant.is_some() && run.demonstrations.is_some() && !run.shipped && !run.has_modes()
    };
    let ablated =
        first_seeds(study.runs.iter().filter(counts), |a, b| a.variant == b.variant && same_data(a, b));
    let main = |run: &Run| study.unimodal(Group::of(run)).into_iter().find(|main| main.task == run.task);
    for run in first_seeds(ablated.iter().filter_map(|run| main(run)), same_data) {
        push(&mut table, study, run);
    }
    let mut variants: Vec<&Option<String>> = Vec::new();
    for run in &ablated {
        if !variants.contains(&&run.variant) {
            variants.push(&run.variant);
        }
    }
    for variant in variants {
        for run in ablated.iter().filter(|run| run.variant == *variant) {
            push(&mut table, study, run);
        }
    }
    table.or_absent(
        "ablations: no run with a single expert has a configuration that says that it is a `variant`.",
    )
}

fn push(table: &mut Table, study: &Study, run: &Run) {
    let [one, difference_one, relative_one] = cells(study, run, Learner::Flow(1));
    let [two, difference_two, relative_two] = cells(study, run, Learner::Flow(2));
    let turned = run.evals.iter().find(|eval| eval.learner == Learner::Flow(1) && eval.split == "turned");
    table.row([
        run.variant.clone().unwrap_or_else(|| "none: the main method".to_owned()),
        task_title(&run.task),
        run.demonstrations.map_or_else(dash, |count| count.to_string()),
        one,
        difference_one,
        relative_one,
        two,
        difference_two,
        relative_two,
        turned.and_then(|eval| fewest(&eval.report)).map_or_else(dash, |row| decimals(row.scores.d_geo_mean)),
    ]);
}

/// The error of `learner`, and its difference to the main run's.
fn cells(study: &Study, run: &Run, learner: Learner) -> [String; 3] {
    let main = study.scores(Group::of(run), &run.task, learner);
    let (own, main) = if run.variant.is_some() { (run.on_test(learner), main) } else { (main, None) };
    let error = own.and_then(fewest).map_or_else(dash, |row| decimals(row.scores.d_geo_mean));
    let compared = own.zip(main).and_then(|(own, main)| difference(own, main));
    let [difference, relative] = compared.unwrap_or_else(|| [dash(), dash()]);
    [error, difference, relative]
}

/// The difference, and what share of the main run's error it is.
fn difference(own: &EvalReport, main: &EvalReport) -> Option<[String; 2]> {
    let row = fewest(own)?;
    let (own_scores, main_scores) = (&row.scores, &row_at(main, row.steps)?.scores);
    let same_episodes = own.data_hash == main.data_hash && own.episodes == main.episodes;
    let paired = || PairedDifference::between(&own_scores.per_episode, &main_scores.per_episode);
    Some(match same_episodes.then(paired).flatten() {
        Some(PairedDifference { difference, low, high, relative, relative_low, relative_high, .. }) => [
            format!("{difference:+.4} ({low:+.4} to {high:+.4})"),
            format!(
                "{} ({} to {})",
                signed_percent(relative),
                signed_percent(relative_low),
                signed_percent(relative_high)
            ),
        ],
        None => {
            let difference = own_scores.d_geo_mean - main_scores.d_geo_mean;
            [format!("{difference:+.4}"), signed_percent(difference / main_scores.d_geo_mean)]
        }
    })
}

#[cfg(test)]
mod tests {
    use super::super::super::samples::{run, scored};
    use super::*;

    const ERRORS: [f64; 3] = [0.1, 0.2, 0.3];

    fn variant(name: &str, task: &str, words: &str, errors: &[f64]) -> Run {
        let run = Run { variant: Some(words.to_owned()), ..run(name, task, 200, 1) };
        scored(run, Learner::Flow(1), &[(1, errors), (10, &[5.0])])
    }

    fn rows(runs: Vec<Run>) -> Vec<Vec<String>> {
        match ablations(&Study::new(runs)) {
            Block::Table(table) => table.rows,
            _ => Vec::new(),
        }
    }

    #[test]
    fn an_ablation_is_compared_with_the_main_run_episode_by_episode() {
        let main = scored(run("d", "door", 200, 1), Learner::Flow(1), &[(1, &ERRORS)]);
        let main = scored(main, Learner::Flow(2), &[(1, &[0.4])]);
        let other_count = scored(run("d-10", "door", 10, 1), Learner::Flow(1), &[(1, &[9.0])]);
        let twist = variant("d-twist", "door", "twist", &ERRORS.map(|error| error + 0.1));
        let found = rows(vec![other_count, twist, main]);
        let dash = "–";
        assert_eq!(found.len(), 2, "ten doors have no ablation: {found:?}");
        let [title, door] = ["none: the main method", "Door opening"];
        assert_eq!(found[0], [title, door, "200", "0.2000", dash, dash, "0.4000", dash, dash, dash]);
        assert_eq!(found[1][..5], ["twist", door, "200", "0.3000", "+0.1000 (+0.1000 to +0.1000)"]);
        assert!(found[1][5].starts_with("+50.0 % ("), "{found:?}");
        assert_eq!(found[1][6..], [dash; 4], "Flow 2 was not trained");
    }

    #[test]
    fn rows_go_by_ablation_and_what_was_scored_elsewhere_has_no_interval() {
        let main = scored(run("d", "door", 200, 1), Learner::Flow(1), &[(1, &ERRORS)]);
        let mut haar = variant("d-haar", "door", "haar", &ERRORS.map(|error| 0.5 * error));
        haar.evals[0].report.data_hash = "another".to_owned();
        let runs = vec![variant("d-twist", "door", "twist", &ERRORS), haar, main];
        let alone = variant("t-twist", "triangle", "twist", &ERRORS);
        let found = rows(runs.into_iter().chain([alone]).collect());
        let order: Vec<[&str; 2]> = found.iter().map(|row| [&*row[0], &*row[1]]).collect();
        let (door, triangle) = ("Door opening", "Rotating triangle");
        let expected =
            [["none: the main method", door], ["twist", door], ["twist", triangle], ["haar", door]];
        assert_eq!(order, expected);
        assert_eq!(found[2][3..6], ["0.2000", "–", "–"], "there is no main run of triangles");
        assert_eq!(found[3][3..6], ["0.1000", "-0.1000", "-50.0 %"]);
    }
}
