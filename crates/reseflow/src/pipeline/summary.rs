//! One screen: what a run found, and where everything is.

use std::path::{Path, PathBuf};

use anyhow::Context;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::{Layout, RolloutSeries, StageRun};
use crate::config::{EvalSplit, ExperimentConfig};
use crate::evaluation::{EvalReport, ModeScores, StraightnessRow};
use crate::learners::Learner;
use crate::output::Table;
use crate::provenance::peak_memory_mib;
use crate::rollouts::RolloutReport;

/// What a run amounts to.
#[derive(Debug, Clone, Serialize)]
pub struct RunSummary {
    /// The run's name.
    pub name: String,
    /// The task.
    pub task: String,
    /// The fewest integration steps that were scored.
    pub steps: usize,
    /// D̄_geo with so many steps on the held-out episodes.
    pub d_geo_mean: f64,
    /// Its standard deviation over noise seeds.
    pub d_geo_std: Option<f64>,
    /// D̄_geo for each number of steps.
    pub d_geo_by_steps: Vec<(usize, f64)>,
    /// Its rotation part, radian.
    pub rotation_rad: f64,
    /// Its translation part, metre.
    pub translation_m: f64,
    /// Held-out episodes scored.
    pub eval_episodes: usize,
    /// Noise seeds.
    pub eval_seeds: usize,
    /// D̄_geo of the mean trajectory.
    pub mean_trajectory: Option<f64>,
    /// D̄_geo of the nearest demonstration.
    pub nearest_demonstration: Option<f64>,
    /// D̄_geo as a share of the better trivial predictor's.
    pub share_of_better_trivial: Option<f64>,
    /// Every flow, where there is more than Flow 1; the figures above are those of the last.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub flows: Vec<FlowSummary>,
    /// The baseline's D̄_geo for each number of steps, where it was trained.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub baseline: Option<Vec<(usize, f64)>>,
    /// The deterministic regressor's D̄_geo, where it was trained.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub regressor: Option<f64>,
    /// Closed-loop episodes.
    pub rollouts: usize,
    /// How many succeeded.
    pub successes: usize,
    /// The lower end of Wilson's 95 % interval.
    pub success_low: f64,
    /// The upper end.
    pub success_high: f64,
    /// Every series of rollouts; the figures above are those of the first.
    pub series: Vec<SeriesSummary>,
    /// Median and 99th percentile of the policy's latency, milliseconds.
    pub latency_ms: Option<(f64, f64)>,
    /// The stages and their times.
    pub stages: Vec<StageRun>,
    /// Seconds of this run of the pipeline.
    pub secs: f64,
    /// The largest memory of this run, MiB.
    pub peak_memory_mib: Option<f64>,
    /// The run's folder.
    pub folder: PathBuf,
    /// The whole resolved configuration.
    pub config: ExperimentConfig,
}

/// What a series of rollouts amounts to.
#[derive(Debug, Clone, Serialize)]
pub struct SeriesSummary {
    /// The name of its result, without the ending.
    pub name: String,
    /// Who acted, or in which way.
    pub title: String,
    /// Closed-loop episodes.
    pub episodes: usize,
    /// How many succeeded.
    pub successes: usize,
    /// The lower end of Wilson's 95 % interval.
    pub success_low: f64,
    /// The upper end.
    pub success_high: f64,
}

impl SeriesSummary {
    fn new(series: RolloutSeries, report: &RolloutReport) -> Self {
        let RolloutReport { episodes, successes, success_low, success_high, .. } = *report;
        let RolloutSeries { name, title, .. } = series;
        Self { name, title, episodes, successes, success_low, success_high }
    }

    fn text(&self) -> String {
        let percent = |share: f64| format!("{:.1} %", 100.0 * share);
        let rate = percent(self.successes as f64 / self.episodes.max(1) as f64);
        let (low, high) = (percent(self.success_low), percent(self.success_high));
        format!("{} of {}: {rate} (95 %, Wilson: {low} to {high})", self.successes, self.episodes)
    }
}

/// What one of a run's flows amounts to.
#[derive(Debug, Clone, Serialize)]
pub struct FlowSummary {
    /// Its number, from 1.
    pub flow: usize,
    /// D̄_geo for each number of steps.
    pub d_geo_by_steps: Vec<(usize, f64)>,
    /// How straight it is.
    pub straightness: Option<StraightnessRow>,
    /// How its samples with the fewest steps lie about both experts, where there are two.
    pub modes: Option<ModeScores>,
}

impl FlowSummary {
    fn new(flow: usize, eval: &EvalReport) -> Self {
        let fewest = eval.rows.iter().min_by_key(|row| row.steps);
        Self {
            flow,
            d_geo_by_steps: by_steps(eval),
            straightness: eval.straightness,
            modes: fewest.and_then(|row| row.modes.clone()),
        }
    }

    fn add_to(&self, table: &mut Table) {
        let mut text = format!("D_geo by steps {}", listed(&self.d_geo_by_steps));
        if let Some(StraightnessRow { absolute, relative, .. }) = self.straightness {
            text += &format!("; straightness {absolute:.2e} (relative {relative:.2e})");
        }
        table.fact(&format!("Flow {}", self.flow), text);
        if let Some(modes) = &self.modes {
            let [first, second] = modes.share_per_mode.map(|share| 100.0 * share);
            let text = format!(
                "{first:.0} % and {second:.0} %; between them {:.1} %; D_geo to the nearer {:.4}",
                100.0 * modes.share_between,
                modes.d_geo_nearer
            );
            table.fact(&format!("modes of Flow {}", self.flow), text);
        }
    }
}

/// D̄_geo for each number of steps.
fn by_steps(eval: &EvalReport) -> Vec<(usize, f64)> {
    eval.rows.iter().map(|row| (row.steps, row.scores.d_geo_mean)).collect()
}

/// D̄_geo for each number of steps, in a line.
fn listed(rows: &[(usize, f64)]) -> String {
    rows.iter().map(|(steps, d_geo)| format!("{steps}: {d_geo:.4}")).collect::<Vec<_>>().join("   ")
}

impl RunSummary {
    /// Reads the stages' results.
    ///
    /// # Errors
    /// When a result is missing or broken.
    pub(super) fn gather(
        config: &ExperimentConfig,
        layout: &Layout,
        stages: Vec<StageRun>,
        secs: f64,
    ) -> anyhow::Result<Self> {
        let evals: Vec<EvalReport> = (1..=config.flows())
            .map(|flow| read(&layout.eval(Learner::Flow(flow), EvalSplit::Test)))
            .collect::<anyhow::Result<_>>()?;
        let eval = evals.last().context("nothing was evaluated")?;
        let reference = |learner: Learner| -> anyhow::Result<Option<Vec<(usize, f64)>>> {
            let trained = Learner::references(config).any(|other| other == learner);
            Ok(trained
                .then(|| read(&layout.eval(learner, EvalSplit::Test)))
                .transpose()?
                .as_ref()
                .map(by_steps))
        };
        let mut rollouts: Vec<(RolloutSeries, RolloutReport)> = Vec::new();
        for series in RolloutSeries::all(config) {
            let report = read(&layout.rollout(&series))?;
            rollouts.push((series, report));
        }
        let (_, rollout) = rollouts.first().context("nobody acted")?;
        let fewest = eval.rows.iter().min_by_key(|row| row.steps).context("the evaluation holds no row")?;
        let scores = &fewest.scores;
        let trivial = eval.trivial.as_ref();
        Ok(Self {
            name: config.name.clone(),
            task: config.task.clone(),
            steps: fewest.steps,
            d_geo_mean: scores.d_geo_mean,
            d_geo_std: scores.d_geo_std,
            d_geo_by_steps: by_steps(eval),
            rotation_rad: scores.rotation_rad,
            translation_m: scores.translation_m,
            eval_episodes: eval.episodes,
            eval_seeds: eval.seeds.len(),
            mean_trajectory: trivial.map(|trivial| trivial.mean_trajectory.d_geo_mean),
            nearest_demonstration: trivial.map(|trivial| trivial.nearest_demonstration.d_geo_mean),
            share_of_better_trivial: trivial.map(|trivial| scores.d_geo_mean / trivial.better().1),
            flows: match evals.len() {
                1 => Vec::new(),
                _ => (1..).zip(&evals).map(|(flow, eval)| FlowSummary::new(flow, eval)).collect(),
            },
            baseline: reference(Learner::Baseline)?,
            regressor: reference(Learner::Regressor)?.and_then(|rows| rows.first().map(|(_, d_geo)| *d_geo)),
            rollouts: rollout.episodes,
            successes: rollout.successes,
            success_low: rollout.success_low,
            success_high: rollout.success_high,
            series: rollouts
                .iter()
                .map(|(series, report)| SeriesSummary::new(series.clone(), report))
                .collect(),
            latency_ms: rollout.plan_latency_ms.as_ref().map(|latency| (latency.p50, latency.p99)),
            stages,
            secs,
            peak_memory_mib: peak_memory_mib(),
            folder: layout.root().to_owned(),
            config: config.clone(),
        })
    }

    /// The screen.
    pub fn table(&self) -> Table {
        let mut table = Table::facts(&self.name, &format!("{}, done in {}", self.task, duration(self.secs)));
        let spread = self.d_geo_std.map(|std| format!(" ± {std:.4}")).unwrap_or_default();
        let plural = if self.steps == 1 { "" } else { "s" };
        table.fact(
            &format!("D_geo, {} step{plural}", self.steps),
            format!(
                "{:.4}{spread} ({:.3} rad, {:.1} mm) on {} held-out episodes × {} noise seeds",
                self.d_geo_mean,
                self.rotation_rad,
                1e3 * self.translation_m,
                self.eval_episodes,
                self.eval_seeds
            ),
        );
        table.fact("D_geo by steps", listed(&self.d_geo_by_steps));
        self.flows.iter().for_each(|flow| flow.add_to(&mut table));
        if let Some(rows) = &self.baseline {
            table.fact("baseline", format!("D_geo by steps {}", listed(rows)));
        }
        if let Some(d_geo) = self.regressor {
            table.fact("regressor", format!("D_geo {d_geo:.4}"));
        }
        if let (Some(mean), Some(nearest), Some(share)) =
            (self.mean_trajectory, self.nearest_demonstration, self.share_of_better_trivial)
        {
            let text = format!(
                "mean trajectory {mean:.4}, nearest demonstration {nearest:.4}; policy / better = {share:.2}"
            );
            table.fact("trivial predictors", text);
        }
        for series in &self.series {
            table.fact(&format!("success, {}", series.title), series.text());
        }
        if let Some((p50, p99)) = self.latency_ms {
            table.fact("policy latency", format!("{p50:.2} ms median, {p99:.2} ms 99th percentile"));
        }
        let stage = |run: &StageRun| {
            let before = if run.skipped { " (before)" } else { "" };
            format!("{} {}{before}", run.name, duration(run.secs))
        };
        table.fact("stages", self.stages.iter().map(stage).collect::<Vec<_>>().join(", "));
        if let Some(memory) = self.peak_memory_mib {
            table.fact("peak memory", format!("{memory:.0} MiB"));
        }
        let at = |name: &str| self.folder.join(name).display().to_string();
        table.fact("results", format!("{}, {}", at("eval.json"), at("rollout.json")));
        let last = self.flows.len().max(1);
        table.fact("policy", at(&Learner::Flow(last).name("checkpoint")));
        table.fact("log", format!("{} (opens in Foxglove and in Rerun)", at("rollout.mcap")));
        if self.config.pretrained.is_none() {
            table.fact("training curves", at("training.mcap"));
        }
        let training = if self.config.pretrained.is_none() { ", training" } else { "" };
        table.fact("pictures", format!("{} (episodes, d_geo_steps, per_action{training})", at("pictures")));
        table
    }
}

/// Reads a result of a stage.
pub(super) fn read<T: DeserializeOwned>(path: &Path) -> anyhow::Result<T> {
    let bytes = std::fs::read(path).with_context(|| path.display().to_string())?;
    serde_json::from_slice(&bytes).with_context(|| path.display().to_string())
}

fn duration(secs: f64) -> String {
    if secs < 60.0 {
        return format!("{secs:.1} s");
    }
    let whole = secs.round() as u64;
    format!("{} min {:02} s", whole / 60, whole % 60)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_are_readable() {
        assert_eq!(duration(3.25), "3.2 s");
        assert_eq!(duration(59.96), "60.0 s");
        assert_eq!(duration(125.4), "2 min 05 s");
    }
}
