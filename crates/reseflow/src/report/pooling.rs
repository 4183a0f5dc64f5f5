//! Runs that differ in their training seed only are one experiment: `door-200`, `door-200-seed2`, `door-200-seed3`.

use super::document::percent;
use super::gather::{Acting, Eval, Run};
use super::study::Study;
use crate::evaluation::StepRow;
use crate::learners::Learner;
use crate::metrics::{mean, std_ddof1};

/// One experiment with several training seeds.
#[derive(Debug)]
pub(super) struct Pool<'a> {
    /// The name of the run without a seed in its name.
    pub(super) name: &'a str,
    /// In the report's order.
    pub(super) runs: Vec<&'a Run>,
}

/// A number over training seeds.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct OverSeeds {
    pub(super) mean: f64,
    /// With n − 1 in the denominator.
    pub(super) std: f64,
    /// That of each run.
    pub(super) values: Vec<f64>,
}

/// A policy's scores of one split and number of steps, run by run.
#[derive(Debug)]
pub(super) struct PooledRow<'a> {
    pub(super) learner: Learner,
    pub(super) split: &'a str,
    pub(super) rows: Vec<&'a StepRow>,
}

impl OverSeeds {
    /// Of the numbers of two runs or more.
    pub(super) fn of(values: Vec<f64>) -> Option<Self> {
        Some(Self { mean: mean(&values)?, std: std_ddof1(&values)?, values })
    }

    /// `0.0146 ± 0.0003`.
    pub(super) fn text(&self) -> String {
        format!("{:.4} ± {:.4}", self.mean, self.std)
    }

    /// `12.5 % ± 0.3 %`, of shares.
    pub(super) fn shares(&self) -> String {
        format!("{} ± {}", percent(self.mean), percent(self.std))
    }
}

/// The name without `-seed2`.
fn experiment(name: &str) -> &str {
    let seeded = name.rsplit_once("-seed");
    let seeded =
        seeded.filter(|(_, seed)| !seed.is_empty() && seed.bytes().all(|byte| byte.is_ascii_digit()));
    seeded.map_or(name, |(experiment, _)| experiment)
}

impl Study {
    /// The experiments with several training seeds, and a sentence on each set of names that is none.
    pub(super) fn pools(&self) -> (Vec<Pool<'_>>, Vec<String>) {
        let mut named: Vec<Pool<'_>> = Vec::new();
        for run in &self.runs {
            let name = experiment(&run.name);
            match named.iter_mut().find(|pool| pool.name == name) {
                Some(pool) => pool.runs.push(run),
                None => named.push(Pool { name, runs: vec![run] }),
            }
        }
        let (mut pools, mut faults) = (Vec::new(), Vec::new());
        for pool in named.into_iter().filter(|pool| pool.runs.len() > 1) {
            match pool.fault() {
                Some(fault) => faults.push(fault),
                None => pools.push(pool),
            }
        }
        (pools, faults)
    }
}

impl<'a> Pool<'a> {
    /// Why these runs are not one experiment.
    fn fault(&self) -> Option<String> {
        let names: Vec<&str> = self.runs.iter().map(|run| run.name.as_str()).collect();
        let names = names.join(", ");
        let differ = |same: &dyn Fn(&Run, &Run) -> bool| {
            self.runs.iter().any(|a| self.runs.iter().any(|b| !same(a, b)))
        };
        if differ(&|a, b| a.task == b.task && a.demonstrations == b.demonstrations) {
            return Some(format!("means over {names}: their tasks or numbers of demonstrations differ."));
        }
        if differ(&|a, b| same_settings(a, b)) {
            return Some(format!(
                "means over {names}: their configurations differ in more than the training seed."
            ));
        }
        if differ(&scored_alike) {
            return Some(format!(
                "means over {names}: they were scored on different episodes or noise seeds."
            ));
        }
        let seeds: Option<Vec<u64>> = self.runs.iter().map(|run| run.training_seed).collect();
        let Some(mut seeds) = seeds else {
            return Some(format!("means over {names}: not every configuration tells its training seed."));
        };
        seeds.sort_unstable();
        let twice = seeds.windows(2).any(|pair| pair[0] == pair[1]);
        twice.then(|| format!("means over {names}: two of them were trained with the same seed."))
    }

    /// The training seeds, as titles list them.
    pub(super) fn seeds(&self) -> String {
        let seeds: Vec<String> =
            self.runs.iter().filter_map(|run| run.training_seed).map(|seed| seed.to_string()).collect();
        seeds.join(", ")
    }

    /// What at least two runs scored, in the order of the first of them.
    pub(super) fn rows(&self) -> Vec<PooledRow<'a>> {
        let mut pooled: Vec<PooledRow<'a>> = Vec::new();
        for eval in self.runs.iter().flat_map(|run| &run.evals) {
            for row in &eval.report.rows {
                let known = pooled.iter_mut().find(|known| {
                    let first = known.rows[0];
                    known.learner == eval.learner
                        && known.split == eval.split
                        && (first.steps, &first.solver) == (row.steps, &row.solver)
                });
                match known {
                    Some(known) => known.rows.push(row),
                    None => {
                        pooled.push(PooledRow { learner: eval.learner, split: &eval.split, rows: vec![row] });
                    }
                }
            }
        }
        pooled.retain(|row| row.rows.len() > 1);
        pooled
    }

    /// Rollouts of the same kind that at least two runs have.
    pub(super) fn acting(&self) -> Vec<Vec<&'a Acting>> {
        let kind = |acting: &'a Acting| {
            let report = &acting.report;
            let scenes = (report.split.as_str(), report.seed, report.episodes);
            (
                acting.learner,
                report.steps,
                report.n_action_steps,
                report.plan_choice,
                report.disturbed,
                scenes,
            )
        };
        let mut pooled: Vec<Vec<&'a Acting>> = Vec::new();
        for acting in self.runs.iter().flat_map(|run| &run.acting) {
            match pooled.iter_mut().find(|known| kind(known[0]) == kind(acting)) {
                Some(known) => known.push(acting),
                None => pooled.push(vec![acting]),
            }
        }
        pooled.retain(|known| known.len() > 1);
        pooled
    }
}

/// Whether what both trained was trained alike, but for the seed.
fn same_settings(a: &Run, b: &Run) -> bool {
    let settings = |run: &Run| run.config.as_ref()?.parse::<toml::Table>().ok();
    let (Some(mut a), Some(mut b)) = (settings(a), settings(b)) else { return true };
    for settings in [&mut a, &mut b] {
        settings.get_mut("train").and_then(|train| train.as_table_mut()?.remove("seed"));
    }
    let same = |key: &str| a.get(key) == b.get(key);
    // Not every run has these policies.
    let of_both = |key: &str| !a.contains_key(key) || !b.contains_key(key) || same(key);
    ["variant", "data", "model", "train"].into_iter().all(same)
        && ["reflow", "baseline"].into_iter().all(of_both)
}

/// Whether the same policies of both were scored on the same episodes with the same noise.
fn scored_alike(a: &Run, b: &Run) -> bool {
    let of = |eval: &Eval| {
        let report = &eval.report;
        (report.data_hash.clone(), report.episodes, report.seeds.clone())
    };
    a.evals.iter().all(|eval| {
        let mut others =
            b.evals.iter().filter(|other| other.learner == eval.learner && other.split == eval.split);
        others.all(|other| of(other) == of(eval))
    })
}

impl PooledRow<'_> {
    /// A number of the rows over training seeds.
    pub(super) fn over(&self, value: impl Fn(&StepRow) -> f64) -> Option<OverSeeds> {
        OverSeeds::of(self.rows.iter().map(|row| value(row)).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_seed_at_the_end_of_a_name_is_left_out() {
        let names = ["door-200", "door-200-seed2", "door-200-seed31", "door-seed2-200", "x-seed", "x-seeds2"];
        let stems = names.map(experiment);
        assert_eq!(stems, ["door-200", "door-200", "door-200", "door-seed2-200", "x-seed", "x-seeds2"]);
    }

    #[test]
    fn a_spread_needs_two_seeds_and_counts_one_fewer() {
        assert_eq!(OverSeeds::of(vec![0.1]), None);
        let three = OverSeeds::of(vec![0.01, 0.02, 0.06]).unwrap();
        // numpy.std([0.01, 0.02, 0.06], ddof=1)
        assert!((three.std - 0.026_457_513_110_645_908).abs() < 1e-15 && (three.mean - 0.03).abs() < 1e-15);
        assert_eq!(three.text(), "0.0300 ± 0.0265");
    }
}
