//! Policies acting in the simulator, and how long a plan takes.

use super::super::document::{Block, Table, dash, percent};
use super::super::pooling::OverSeeds;
use super::super::study::{Study, learner_title, task_title};
use crate::config::PlanChoice;
use crate::rollouts::{LatencyMillis, RolloutReport};

/// Success in closed loop, with Wilson's intervals.
pub(in super::super) fn closed_loop(study: &Study) -> Block {
    let mut table = Table::new(
        "Episodes in which the task's criterion holds, with Wilson's 95 % interval. A plan has 10 actions; after the given number of them \
         the policy looks and plans again. Over training seeds: the mean rate ± its standard deviation; their episodes are the same.",
        [
            "run",
            "task",
            "policy",
            "steps",
            "actions a plan",
            "disturbed",
            "split",
            "successes",
            "rate",
            "95 % interval",
        ],
    );
    for run in &study.runs {
        for acting in &run.acting {
            let report = &acting.report;
            table.row([
                run.name.clone(),
                task_title(&report.task),
                learner_title(acting.learner),
                report.steps.map_or_else(dash, |steps| steps.to_string()),
                actions(report),
                if report.disturbed { "yes" } else { "no" }.to_owned(),
                report.split.clone(),
                format!("{} of {}", report.successes, report.episodes),
                percent(report.success_rate),
                format!("{} to {}", percent(report.success_low), percent(report.success_high)),
            ]);
        }
    }
    for pool in &study.pools().0 {
        for acting in pool.acting() {
            let report = &acting[0].report;
            let rates = acting.iter().map(|acting| acting.report.success_rate).collect();
            let Some(rate) = OverSeeds::of(rates) else { continue };
            let sum = |count: fn(&RolloutReport) -> usize| -> usize {
                acting.iter().map(|acting| count(&acting.report)).sum()
            };
            table.row([
                format!("{} × {} training seeds", pool.name, acting.len()),
                task_title(&report.task),
                learner_title(acting[0].learner),
                report.steps.map_or_else(dash, |steps| steps.to_string()),
                actions(report),
                if report.disturbed { "yes" } else { "no" }.to_owned(),
                report.split.clone(),
                format!("{} of {}", sum(|report| report.successes), sum(|report| report.episodes)),
                rate.shares(),
                dash(),
            ]);
        }
    }
    table.or_absent("closed-loop success: no run holds a rollout's result.")
}

/// Actions carried out of each plan, and which plan, where that is not the newest.
fn actions(report: &RolloutReport) -> String {
    match report.plan_choice {
        PlanChoice::Newest => report.n_action_steps.to_string(),
        PlanChoice::Medoid => format!("{}, medoid", report.n_action_steps),
    }
}

/// What a plan takes: timed by itself, and in rollouts.
pub(in super::super) fn latency(study: &Study) -> Block {
    let mut table = Table::new(
        "Wall-clock milliseconds of one plan for one scene, graph building included; encoder and decoder apart where they were timed. The \
         machine is in the table of origins; `acting` is what calls took during rollouts, beside whatever else ran.",
        ["run", "policy", "part", "steps", "calls", "median", "95th percentile", "99th percentile"],
    );
    for run in &study.runs {
        let mut push = |policy: &str, part: &str, steps: String, latency: &LatencyMillis| {
            let LatencyMillis { calls, p50, p95, p99, .. } = latency;
            table.row([
                run.name.clone(),
                policy.to_owned(),
                part.to_owned(),
                steps,
                calls.to_string(),
                format!("{p50:.2}"),
                format!("{p95:.2}"),
                format!("{p99:.2}"),
            ]);
        };
        for eval in run.evals.iter().filter(|eval| eval.split == "test") {
            for row in &eval.report.rows {
                let Some(latency) = &row.latency else { continue };
                let parts = [
                    ("encoder", latency.encoder_ms.as_ref()),
                    ("decoder", latency.decoder_ms.as_ref()),
                    ("whole", Some(&latency.whole_ms)),
                ];
                for (part, latency) in parts {
                    if let Some(latency) = latency {
                        push(&learner_title(eval.learner), part, row.steps.to_string(), latency);
                    }
                }
            }
        }
        for acting in &run.acting {
            if let Some(latency) = &acting.report.plan_latency_ms {
                let steps = acting.report.steps.map_or_else(dash, |steps| steps.to_string());
                push(&learner_title(acting.learner), "whole, acting", steps, latency);
            }
        }
    }
    table.or_absent("latency: nothing was timed.")
}
