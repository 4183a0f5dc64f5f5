//! Every score, and paired comparisons.

use super::super::document::{Block, Table, dash, decimals, optional, signed_percent};
use super::super::study::{Study, fewest, learner_title, most, row_at, run_title, steps_title};
use crate::evaluation::{EvalReport, StepRow};
use crate::learners::Learner;
use crate::metrics::{PairedDifference, Scores};

const HEADER: [&str; 11] = [
    "",
    "split",
    "steps",
    "evaluations",
    "D̄_geo",
    "± seeds",
    "± episodes",
    "95 % interval",
    "half-turn",
    "rad",
    "mm",
];

/// A table for each run: its policies at all their steps, and the trivial predictors.
pub(in super::super) fn scores(study: &Study) -> Vec<Block> {
    let mut blocks = Vec::new();
    for run in &study.runs {
        blocks.push(Block::Part(format!("{} ({})", run_title(run), run.name)));
        let first = run.evals.first().map(|eval| &eval.report);
        let extent = first.map(|report| {
            format!("{} held-out episodes × {} noise seeds", report.episodes, report.seeds.len())
        });
        let mut table = Table::new(
            format!("{}: {}.", run.name, extent.unwrap_or_else(|| "no evaluation".to_owned())),
            HEADER,
        );
        for eval in &run.evals {
            for row in &eval.report.rows {
                let steps = if row.solver == "euler" {
                    row.steps.to_string()
                } else {
                    format!("{} ({})", row.steps, row.solver)
                };
                let cost = [steps, row.evaluations.to_string()];
                table.row(cells(learner_title(eval.learner), &eval.split, cost, &row.scores));
            }
        }
        let mut splits: Vec<&str> = Vec::new();
        for eval in &run.evals {
            let Some(trivial) =
                eval.report.trivial.as_ref().filter(|_| !splits.contains(&eval.split.as_str()))
            else {
                continue;
            };
            splits.push(&eval.split);
            let none = || [dash(), dash()];
            table.row(cells("mean trajectory".to_owned(), &eval.split, none(), &trivial.mean_trajectory));
            table.row(cells(
                "nearest demonstration".to_owned(),
                &eval.split,
                none(),
                &trivial.nearest_demonstration,
            ));
        }
        let fewer =
            run.evals.iter().filter(|eval| Some(eval.report.episodes) != first.map(|report| report.episodes));
        let fewer: Vec<String> = fewer
            .map(|eval| {
                format!("{} ({}): {} episodes", learner_title(eval.learner), eval.split, eval.report.episodes)
            })
            .collect();
        blocks.push(table.or_absent(&format!("{}: no evaluation.", run.name)));
        if run.has_modes() {
            blocks.push(Block::text(
                "These scenes have two experts, and the distance is to the one that was recorded: a perfect policy is as far from it as \
                 half of the experts' distance. The table of modes tells more.",
            ));
        }
        if !fewer.is_empty() {
            blocks.push(Block::text(format!("Scored on other numbers of episodes: {}.", fewer.join(", "))));
        }
    }
    blocks
}

fn cells(name: String, split: &str, [steps, evaluations]: [String; 2], scores: &Scores) -> [String; 11] {
    let interval = match (scores.d_geo_low, scores.d_geo_high) {
        (Some(low), Some(high)) => format!("{low:.4} to {high:.4}"),
        _ => dash(),
    };
    [
        name,
        split.to_owned(),
        steps,
        evaluations,
        decimals(scores.d_geo_mean),
        optional(scores.d_geo_std),
        optional(scores.d_geo_episode_std),
        interval,
        decimals(scores.d_geo_half_turn_mean),
        decimals(scores.rotation_rad),
        format!("{:.2}", 1e3 * scores.translation_m),
    ]
}

/// Differences episode by episode: every number of steps against the most, Flow 2 against Flow 1, the baseline and the regressor.
pub(in super::super) fn paired(study: &Study) -> Block {
    let mut table = Table::new(
        "D̄_geo of the first minus that of the second, paired over the same held-out episodes, with 95 % bootstrap intervals; the last \
         columns as a share of the second.",
        ["run", "first", "second", "difference", "95 % interval", "relative", "95 % interval (relative)"],
    );
    for run in study.runs.iter().filter(|run| !run.has_modes()) {
        let mut compare = |first: (Learner, Option<&StepRow>), second: (Learner, Option<&StepRow>)| {
            let ((one, Some(row)), (other, Some(against))) = (first, second) else { return };
            let Some(paired) =
                PairedDifference::between(&row.scores.per_episode, &against.scores.per_episode)
            else {
                return;
            };
            let name =
                |learner, row: &StepRow| format!("{}, {}", learner_title(learner), steps_title(row.steps));
            table.row([
                run.name.clone(),
                name(one, row),
                name(other, against),
                format!("{:+.4}", paired.difference),
                format!("{:+.4} to {:+.4}", paired.low, paired.high),
                signed_percent(paired.relative),
                format!(
                    "{} to {}",
                    signed_percent(paired.relative_low),
                    signed_percent(paired.relative_high)
                ),
            ]);
        };
        let at = |learner: Learner, pick: fn(&EvalReport) -> Option<&StepRow>| {
            (learner, run.on_test(learner).and_then(pick))
        };
        let flows: Vec<Learner> =
            (1..=9).map(Learner::Flow).filter(|flow| run.on_test(*flow).is_some()).collect();
        for &learner in flows.iter().chain([Learner::Baseline].iter()) {
            let Some(report) = run.on_test(learner) else { continue };
            let many = most(report);
            for few in report.rows.iter().filter(|row| many.is_some_and(|many| row.steps != many.steps)) {
                compare((learner, Some(few)), (learner, many));
            }
        }
        let Some(&last) = flows.last() else { continue };
        if last != Learner::Flow(1) {
            compare(at(last, fewest), at(Learner::Flow(1), fewest));
        }
        compare(at(last, fewest), at(Learner::Baseline, |report| row_at(report, 100).or(most(report))));
        compare(at(last, fewest), at(Learner::Regressor, fewest));
    }
    table.or_absent("paired comparisons: no run has two policies or two numbers of steps to compare.")
}

#[cfg(test)]
mod tests {
    use super::super::super::samples::{run, scored};
    use super::*;

    #[test]
    fn every_number_of_steps_is_compared_with_the_most() {
        let run = run("d", "door", 10, 1);
        let run =
            scored(run, Learner::Flow(1), &[(1, &[0.5, 0.75]), (10, &[0.25, 0.5]), (100, &[0.25, 0.25])]);
        let run = scored(run, Learner::Baseline, &[(1, &[1.0, 1.5]), (100, &[0.5, 0.75])]);
        let Block::Table(table) = paired(&Study::new(vec![run])) else { panic!("no table") };
        let found: Vec<[&str; 4]> =
            table.rows.iter().map(|row| [&*row[1], &*row[2], &*row[3], &*row[5]]).collect();
        let expected = [
            ["Flow 1, 1 step", "Flow 1, 100 steps", "+0.3750", "+150.0 %"],
            ["Flow 1, 10 steps", "Flow 1, 100 steps", "+0.1250", "+50.0 %"],
            ["ET-SEED, 1 step", "ET-SEED, 100 steps", "+0.6250", "+100.0 %"],
            ["Flow 1, 1 step", "ET-SEED, 100 steps", "+0.0000", "+0.0 %"],
        ];
        assert_eq!(found, expected);
    }
}
