//! The one table that README.md shows, made from `results.json`.

use super::document::Table;
use super::markdown;
use super::paper::of_task;
use super::results::{ErrorResult, PolicyResult, Results, RolloutResult, RunResult, StepResult};
use super::study::{learner_title, steps_title, task_title};
use crate::learners::Learner;

/// Actions in a plan.
const PLAN: usize = 10;

/// The policies that have a row, in this order.
const POLICIES: [Learner; 3] = [Learner::Flow(1), Learner::Flow(2), Learner::Baseline];

/// The file `results.md`: the table and what its columns mean, as Markdown.
pub(super) fn markdown(results: &Results) -> String {
    markdown::rows(&table(results))
}

/// Every policy on the test split, few steps and many, and what it does in the simulator; scenes with two experts have no row.
pub(super) fn table(results: &Results) -> Table {
    let runs = || results.runs.iter().filter(|run| !run.two_experts);
    let policies = || runs().flat_map(|run| POLICIES.iter().filter_map(|learner| run.on_test(*learner)));
    let few = policies().filter_map(PolicyResult::fewest).map(|row| row.steps).next().unwrap_or(1);
    let many = policies().filter_map(PolicyResult::most).map(|row| row.steps).max().unwrap_or(1);
    let (one_title, many_title) =
        (format!("D̄_geo, {}", steps_title(few)), format!("D̄_geo, {}", steps_title(many)));
    let mut table = Table::new(
        caption(results),
        [
            "task",
            "policy",
            &one_title,
            "rad / mm",
            &many_title,
            "one call, ms",
            "success, replanning",
            "success, whole plans",
            "success, shoved",
            "the paper",
        ],
    );
    for run in runs() {
        let scenes = run.policies.iter().find(|policy| policy.split == "test").map(|policy| policy.episodes);
        for learner in POLICIES {
            let Some(policy) = run.on_test(learner) else { continue };
            let Some(first) = policy.fewest() else { continue };
            let last = policy.most().filter(|row| row.steps > first.steps);
            let fewer = (Some(policy.episodes) != scenes).then(|| format!(" ({} scenes)", policy.episodes));
            let paper = of_task(&run.task).and_then(|task| task.in_table(learner));
            table.row([
                title(run),
                format!("{}{}", policy.policy, fewer.unwrap_or_default()),
                at(first, few, with_interval(&first.error)),
                parts(&first.error),
                last.map_or_else(dash, |row| at(row, many, format!("{:.4}", row.error.d_geo_mean))),
                first.call_ms.as_ref().map_or_else(dash, |call| format!("{:.1} / {:.1}", call.p50, call.p99)),
                acting(run, learner, few, |it| !it.disturbed && it.actions_a_plan < PLAN),
                acting(run, learner, few, |it| !it.disturbed && it.actions_a_plan == PLAN),
                acting(run, learner, few, |it| it.disturbed && it.actions_a_plan < PLAN),
                paper.map_or_else(dash, |value| format!("{value:.3}")),
            ]);
        }
        if let Some(error) = &run.nearest_demonstration {
            let among = run.nearest_among.map(|count| format!(" of {count}")).unwrap_or_default();
            table.row([
                title(run),
                format!("nearest demonstration{among}"),
                with_interval(error),
                parts(error),
                dash(),
                dash(),
                dash(),
                dash(),
                dash(),
                dash(),
            ]);
        }
    }
    table
}

/// What the columns mean, and where the numbers come from.
fn caption(results: &Results) -> String {
    let runs = || results.runs.iter().filter(|run| !run.two_experts);
    let tests = || runs().flat_map(|run| run.policies.iter().filter(|policy| policy.split == "test"));
    let extent = tests()
        .next()
        .map(|policy| format!("{} held-out scenes × {} noise seeds", policy.episodes, policy.noise_seeds));
    let made = || runs().filter_map(|run| run.made_with.as_ref());
    let commits = unique(made().filter_map(|made| made.commit.clone()));
    let machines = unique(made().map(|made| {
        format!("{}, {} threads", made.processor.as_deref().unwrap_or(&made.device), made.threads)
    }));
    format!(
        "In brackets after each task: the demonstrations that were learned from. D̄_geo adds radians and metres as the paper does; 0 is \
         perfect, a random rotation scores about 2.2. Behind it stand its 95 % interval over scenes, and its rotation and translation \
         part. Scored on {}. One call: median / 99th percentile ({}). Success: episodes in the simulator that reach the goal, with \
         Wilson's 95 % interval, planning again every few actions or carrying out whole plans; shoved: what is worked on is knocked \
         away once, and the policy plans again. The paper: its Table I, measured in another simulator. Commit {}.",
        extent.unwrap_or_else(|| "nothing".to_owned()),
        machines.join("; "),
        commits.join(", "),
    )
}

fn unique(texts: impl Iterator<Item = String>) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    texts.for_each(|text| {
        if !found.contains(&text) {
            found.push(text);
        }
    });
    found
}

/// The task and how many demonstrations were learned from.
fn title(run: &RunResult) -> String {
    let count = run.demonstrations.map(|count| format!(" ({count})")).unwrap_or_default();
    format!("{}{count}", task_title(&run.task))
}

/// The text, with the number of steps where it is another one than the column's.
fn at(row: &StepResult, steps: usize, text: String) -> String {
    if row.steps == steps { text } else { format!("{text}, {}", steps_title(row.steps)) }
}

fn with_interval(error: &ErrorResult) -> String {
    let mean = format!("{:.4}", error.d_geo_mean);
    match (error.d_geo_low, error.d_geo_high) {
        (Some(low), Some(high)) => format!("{mean} ({low:.4}–{high:.4})"),
        _ => mean,
    }
}

/// The rotation and the translation part.
fn parts(error: &ErrorResult) -> String {
    format!("{:.4} / {:.1}", error.rotation_rad, error.translation_mm)
}

/// The first rollouts on the test split of those that `counts`.
fn acting(
    run: &RunResult,
    learner: Learner,
    steps: usize,
    counts: impl Fn(&RolloutResult) -> bool,
) -> String {
    let policy = learner_title(learner);
    let is_it =
        |rollout: &&RolloutResult| rollout.policy == policy && rollout.split == "test" && counts(rollout);
    let Some(rollout) = run.rollouts.iter().find(is_it) else { return dash() };
    let [low, high] = [rollout.success_low, rollout.success_high].map(|share| 100.0 * share);
    let text = format!("{} of {} ({low:.0}–{high:.0} %)", rollout.successes, rollout.episodes);
    match rollout.steps {
        Some(other) if other != steps => format!("{text}, {}", steps_title(other)),
        _ => text,
    }
}

fn dash() -> String {
    "–".to_owned()
}
