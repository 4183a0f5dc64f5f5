//! README.md's table, made from `results.json`.

use super::document::{Table, dash};
use super::markdown;
use super::paper::{TASKS, of_task};
use super::results::{ErrorResult, PolicyResult, Results, RolloutResult, RunResult, StepResult};
use super::study::{learner_title, steps_title, task_title};
use crate::config::PlanChoice;
use crate::learners::Learner;

/// Actions in a plan.
pub(super) const PLAN: usize = 10;

/// The policies that have a row, in this order.
const POLICIES: [Learner; 3] = [Learner::Flow(1), Learner::Flow(2), Learner::Baseline];

/// What the columns mean, as a list, and the table, as Markdown.
pub(super) fn markdown(results: &Results) -> String {
    let items: Vec<String> =
        legend(results).iter().map(|(column, meaning)| format!("- {column}: {meaning}")).collect();
    markdown::rows(&Table { caption: items.join("\n"), ..table(results) })
}

/// Every policy on the test split, few steps and many, and what it does in the simulator; scenes with two experts have no row.
pub(super) fn table(results: &Results) -> Table {
    let runs = || rows_of(results);
    let (few, many) = (fewest_steps(results), most_steps(results));
    let (one_title, many_title) =
        (format!("D̄_geo, {}", steps_title(few)), format!("D̄_geo, {}", steps_title(many)));
    let sentences: Vec<String> =
        legend(results).iter().map(|(column, meaning)| format!("{column}: {meaning}")).collect();
    let mut table = Table::new(
        sentences.join(" "),
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

/// The runs that have rows: those of the main method on scenes with one expert.
pub(super) fn rows_of(results: &Results) -> impl Iterator<Item = &RunResult> {
    results.runs.iter().filter(|run| !run.two_experts && run.variant.is_none())
}

/// The fewest integration steps of the first policy: those of the first column of errors.
pub(super) fn fewest_steps(results: &Results) -> usize {
    policies(results).find_map(PolicyResult::fewest).map_or(1, |row| row.steps)
}

/// The most integration steps of any policy: those of the second column of errors.
pub(super) fn most_steps(results: &Results) -> usize {
    policies(results).filter_map(PolicyResult::most).map(|row| row.steps).max().unwrap_or(1)
}

fn policies(results: &Results) -> impl Iterator<Item = &PolicyResult> {
    rows_of(results).flat_map(|run| POLICIES.iter().filter_map(|learner| run.on_test(*learner)))
}

/// What the columns mean, and where the numbers come from: sentences about one column each.
fn legend(results: &Results) -> Vec<(&'static str, String)> {
    let extent = rows_of(results)
        .flat_map(|run| run.policies.iter().filter(|policy| policy.split == "test"))
        .next()
        .map(|policy| format!("{} held-out scenes × {} noise seeds", policy.episodes, policy.noise_seeds));
    let timing = rows_of(results).filter_map(|run| run.timed_with.as_ref().or(run.made_with.as_ref()));
    let machines = unique(timing.map(|made| {
        format!("{}, {} threads", made.processor.as_deref().unwrap_or(&made.device), made.threads)
    }));
    let acting = rows_of(results).flat_map(|run| &run.rollouts);
    let replanning = acting.map(|rollout| rollout.actions_a_plan).filter(|actions| *actions < PLAN);
    let replanning = unique(replanning.map(|actions| actions.to_string()));
    let [one, two, three] = TASKS.map(|known| format!("{} ({})", known.demonstrations, known.task));
    vec![
        ("Task", "in brackets the number of demonstrations that were learned from.".to_owned()),
        (
            "Policy",
            "the flows, the baseline ET-SEED, and for comparison, without any learning, the actions of the demonstration whose scene is \
             most alike."
                .to_owned(),
        ),
        (
            "D̄_geo",
            format!(
                "the mean distance between predicted and demonstrated poses, the root of the squared rotation angle (radians) plus the \
                 squared distance (metres), as in the paper; 0 is perfect, a random rotation scores about 2.2. In brackets its 95 % \
                 interval over scenes. Scored on {}, unless the row says otherwise.",
                extent.unwrap_or_else(|| "nothing".to_owned()),
            ),
        ),
        ("Rad / mm", "the mean rotation angle and the mean distance by themselves.".to_owned()),
        (
            "One call",
            format!("from the point cloud to the trajectory, median / 99th percentile ({}).", machines.join("; ")),
        ),
        (
            "Success",
            format!(
                "episodes in the simulator that reach the goal, with Wilson's 95 % interval, in {} unless the cell says otherwise. \
                 Replanning: the policy plans again after {} actions; whole plans: it carries out all {PLAN}. Medoid: of the plans that it \
                 has made so far it carries out the one that is nearest to the others, which passes over a single bad one.",
                steps_title(fewest_steps(results)),
                if replanning.is_empty() { "fewer".to_owned() } else { replanning.join(" or ") },
            ),
        ),
        (
            "Shoved",
            "once in the episode the board or the triangle is pushed aside, or the gripper knocked off the door's handle, and the policy \
             plans again."
                .to_owned(),
        ),
        (
            "The paper",
            format!(
                "its Table I, which does not say its integration steps, from another simulator and from {one}, {two} and {three} \
                 demonstrations. The crosses in the picture are the numbers of the paper's text, which names the steps: ReSeFlow in one \
                 step, ET-SEED in 100.",
            ),
        ),
        ("Commit", format!("{}.", commits(results))),
    ]
}

/// The commit that made the rows, or, where there are several, each with its rows.
fn commits(results: &Results) -> String {
    let made: Vec<(String, String)> = rows_of(results)
        .filter_map(|run| Some((run.made_with.as_ref()?.commit.clone()?, title(run))))
        .collect();
    let commits = unique(made.iter().map(|(commit, _)| commit.clone()));
    if let [_] = commits.as_slice() {
        return commits.concat();
    }
    let with_rows = commits.iter().map(|commit| {
        let rows = unique(made.iter().filter(|(other, _)| other == commit).map(|(_, row)| row.clone()));
        format!("{commit} for {}", rows.join(", "))
    });
    with_rows.collect::<Vec<_>>().join("; ")
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
pub(super) fn title(run: &RunResult) -> String {
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
pub(super) fn acting(
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
    let mut text = format!("{} of {} ({low:.0}–{high:.0} %)", rollout.successes, rollout.episodes);
    if let Some(other) = rollout.steps.filter(|other| *other != steps) {
        text = format!("{text}, {}", steps_title(other));
    }
    let has_a_choice = rollout.actions_a_plan < PLAN && rollout.plan_choice == PlanChoice::Medoid;
    if has_a_choice { format!("{text}, medoid") } else { text }
}
