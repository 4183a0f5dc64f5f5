//! The file `results.md`, made from `results.json`: README.md's table, then every error by integration steps and split, then the
//! ablations beside the main method, then the scenes with two experts.

use super::document::{Table, dash, decimals, optional, percent};
use super::markdown;
use super::results::{PolicyResult, Results, RunResult};
use super::study::{learner_title, steps_title};
use super::summary::{self, PLAN, acting, fewest_steps, most_steps, rows_of};
use crate::learners::Learner;

/// The tables, each under its title: of the runs of `headline` that stand for the main method, and, of `all`, the ablations and the
/// scenes with two experts.
pub(super) fn markdown(headline: &Results, all: &Results) -> String {
    let mut text = summary::markdown(headline);
    for (title, table) in [
        ("Steps and splits", steps_and_splits(headline)),
        ("Variants", variants(headline, all)),
        ("Two experts", experts(all)),
    ] {
        if !table.rows.is_empty() {
            text.push_str(&format!("\n## {title}\n\n{}", markdown::rows(&table)));
        }
    }
    text
}

/// D̄_geo of every policy of the main method by the number of integration steps, on every split.
fn steps_and_splits(results: &Results) -> Table {
    let policies: Vec<(&RunResult, &PolicyResult)> =
        rows_of(results).flat_map(|run| run.policies.iter().map(move |policy| (run, policy))).collect();
    let mut counts: Vec<usize> =
        policies.iter().flat_map(|(_, policy)| policy.steps.iter().map(|row| row.steps)).collect();
    counts.sort_unstable();
    counts.dedup();
    let fixed = ["task", "policy", "split", "scenes × seeds"].map(str::to_owned).into_iter();
    let mut table = Table {
        caption: "D̄_geo by the number of integration steps (of ET-SEED: of noise levels); a regressor has one. `wide`: objects where no \
                  demonstration has them; `turned`: the test scenes, each turned at random."
            .to_owned(),
        header: fixed.chain(counts.iter().map(|count| steps_title(*count))).collect(),
        rows: Vec::new(),
    };
    for (run, policy) in policies {
        let step = |count: &usize| policy.steps.iter().find(|row| row.steps == *count);
        let errors =
            counts.iter().map(|count| step(count).map_or_else(dash, |row| decimals(row.error.d_geo_mean)));
        let PolicyResult { policy: name, split, episodes, noise_seeds, .. } = policy;
        let fixed = [summary::title(run), name.clone(), split.clone(), format!("{episodes} × {noise_seeds}")];
        table.rows.push(fixed.into_iter().chain(errors).collect());
    }
    table
}

/// Each task's main method, then its variants, a row each.
fn variants(headline: &Results, all: &Results) -> Table {
    let (few, many) = (fewest_steps(headline), most_steps(headline));
    let [few_title, many_title] = [few, many].map(steps_title);
    let mut table = Table::new(
        format!(
            "D̄_geo of the method with what the row names changed, and what has to change with it; `turned` and `wide` as above, in \
             {few_title}. Success: of Flow 2, planning again."
        ),
        [
            "task",
            "variant",
            &format!("Flow 1, {few_title}"),
            &many_title,
            "turned",
            "wide",
            &format!("Flow 2, {few_title}"),
            &many_title,
            "turned",
            "wide",
            "success",
        ],
    );
    let same_data = |a: &RunResult, b: &RunResult| a.task == b.task && a.demonstrations == b.demonstrations;
    let changed: Vec<&RunResult> =
        all.runs.iter().filter(|run| !run.two_experts && run.variant.is_some()).collect();
    let mut seen: Vec<&RunResult> = Vec::new();
    for run in &changed {
        if seen.iter().any(|other| same_data(run, other)) {
            continue;
        }
        seen.push(run);
        let main = rows_of(headline).find(|main| same_data(run, main));
        for run in main.into_iter().chain(changed.iter().copied().filter(|other| same_data(run, other))) {
            let [one, two] =
                [Learner::Flow(1), Learner::Flow(2)].map(|learner| errors(run, learner, few, many));
            let title = [summary::title(run), run.variant.clone().unwrap_or_else(dash)];
            let success = acting(run, Learner::Flow(2), few, |it| !it.disturbed && it.actions_a_plan < PLAN);
            table.rows.push(title.into_iter().chain(one).chain(two).chain([success]).collect());
        }
    }
    table
}

/// On the test split in few steps and in many, then in few on turned scenes and where no demonstration has objects.
fn errors(run: &RunResult, learner: Learner, few: usize, many: usize) -> [String; 4] {
    [("test", few), ("test", many), ("turned", few), ("wide", few)].map(|(split, count)| {
        let title = learner_title(learner);
        let policy = run.policies.iter().find(|policy| policy.policy == title && policy.split == split);
        let row = policy.and_then(|policy| policy.steps.iter().find(|row| row.steps == count));
        optional(row.map(|row| row.error.d_geo_mean))
    })
}

/// Where samples lie about two experts, on the test split.
fn experts(results: &Results) -> Table {
    let mut table = Table::new(
        "Scenes with two experts as good as each other. Between: the share of samples that are far from both; sides: how the samples \
         share themselves out between the experts; energy distance: between the samples and the experts' two answers, 0 where they are \
         distributed alike.",
        ["task", "variant", "policy", "steps", "between", "sides", "D̄_geo to the nearer", "energy distance"],
    );
    for run in results.runs.iter().filter(|run| run.two_experts) {
        for policy in run.policies.iter().filter(|policy| policy.split == "test") {
            for row in &policy.steps {
                let Some(between) = row.share_between else { continue };
                let sides = row.share_per_mode.map(|shares| shares.map(percent).join(" / "));
                table.row([
                    summary::title(run),
                    run.variant.clone().unwrap_or_else(dash),
                    policy.policy.clone(),
                    row.steps.to_string(),
                    percent(between),
                    sides.unwrap_or_else(dash),
                    optional(row.d_geo_nearer),
                    optional(row.energy_distance),
                ]);
            }
        }
    }
    table
}

#[cfg(test)]
mod tests {
    use super::super::samples::{coin_toss, run, scored};
    use super::*;
    use crate::learners::Learner;

    #[test]
    fn every_split_and_number_of_steps_has_its_cell_and_variants_have_a_table_of_their_own() {
        let main = scored(run("door-200", "door", 200, 1), Learner::Flow(1), &[(1, &[0.2]), (10, &[0.1])]);
        let main = scored(main, Learner::Regressor, &[(1, &[0.3])]);
        let mut twist = scored(run("door-200-twist", "door", 200, 1), Learner::Flow(1), &[(1, &[0.9])]);
        twist.variant = Some("twist".to_owned());
        let few = scored(run("door-10", "door", 10, 1), Learner::Flow(1), &[(1, &[0.7])]);
        let mut results = Results::of([main, twist, few].iter());
        let mut turned = results.runs[1].policies[0].clone();
        turned.split = "turned".to_owned();
        turned.steps[0].error.d_geo_mean = 0.8;
        results.runs[1].policies.push(turned);
        let table = steps_and_splits(&results);
        assert_eq!(table.header[3..], ["scenes × seeds", "1 step", "10 steps"]);
        let cells: Vec<String> = table.rows.iter().map(|row| row[1..].join(" ")).collect();
        assert_eq!(
            cells,
            [
                "Flow 1 test 1 × 1 0.2000 0.1000",
                "regressor test 1 × 1 0.3000 –",
                "Flow 1 test 1 × 1 0.7000 –",
            ]
        );
        let text = markdown(&results, &results);
        let (main, variants) = text.split_once("## Variants").unwrap();
        assert!(!main.contains("0.9000") && !text.contains("Two experts"), "{text}");
        let rows: Vec<&str> = variants.lines().filter(|line| line.contains("Door")).collect();
        let expected = [
            "| Door opening (200) | – | 0.2000 | 0.1000 | – | – | – | – | – | – | – |",
            "| Door opening (200) | twist | 0.9000 | – | 0.8000 | – | – | – | – | – | – |",
        ];
        assert_eq!(rows, expected, "ten demonstrations have no variant");
    }

    #[test]
    fn two_experts_have_a_table_with_all_variants() {
        let main = coin_toss("coin_toss", 1, 0.05, 0.4);
        let mut other = coin_toss("coin_toss-independent", 1, 0.1, 0.5);
        other.variant = Some("independent coupling".to_owned());
        let single = scored(run("door-200", "door", 200, 1), Learner::Flow(1), &[(1, &[0.2])]);
        let results = Results::of([main, other, single].iter());
        assert!(
            !markdown(&results, &results).contains("## Variants"),
            "their variants are in their own table"
        );
        let rows = experts(&results).rows;
        let cells: Vec<String> = rows.iter().map(|row| row[1..].join(", ")).collect();
        let expected = [
            "–, Flow 2, 1, 5.0 %, 40.0 % / 60.0 %, 0.0200, 0.0500",
            "independent coupling, Flow 2, 1, 10.0 %, 50.0 % / 50.0 %, 0.0200, 0.0500",
        ];
        assert_eq!(cells, expected);
    }
}
