//! Where the runner meets the trainer: progress on the terminal, checkpoints into policies.

use std::path::Path;

use reseflow_data::{Dataset, ObservationHistory};
use reseflow_train::{
    DeviceKind, FlowPolicy, PolicySample, Resume, TrainError, TrainObserver, TrainRequest, TrainSummary,
    UpdateMetrics, ValidationMetrics, train,
};

use crate::cli::DeviceArg;
use crate::config::ExperimentConfig;
use crate::error::{bad_input, sentence};
use crate::evaluation::SamplePolicy;
use crate::output::{Progress, Terminal};

impl From<DeviceArg> for DeviceKind {
    fn from(device: DeviceArg) -> Self {
        match device {
            DeviceArg::Cpu => DeviceKind::Cpu,
            DeviceArg::Flex => DeviceKind::Flex,
            DeviceArg::Ndarray => DeviceKind::Ndarray,
        }
    }
}

impl SamplePolicy for FlowPolicy {
    fn observation_horizon(&self) -> usize {
        FlowPolicy::observation_horizon(self)
    }

    fn sample(
        &self,
        histories: &[ObservationHistory],
        seeds: &[u64],
        steps: usize,
    ) -> anyhow::Result<Vec<Vec<PolicySample>>> {
        self.predict(histories, seeds, steps).map_err(|fault| bad_input(sentence(&anyhow::Error::new(fault))))
    }
}

/// The policy in the checkpoint's folder `folder`.
///
/// # Errors
/// Bad input: there is no such folder, or what is in it is no whole checkpoint.
pub fn load_policy(folder: &Path, device: DeviceKind) -> anyhow::Result<FlowPolicy> {
    let place = folder.display().to_string();
    if !folder.is_dir() {
        return Err(bad_input(format!("{place}: there is no such folder, expected a checkpoint's")));
    }
    FlowPolicy::load(folder, device).map_err(|fault| {
        let fault = sentence(&anyhow::Error::new(fault));
        bad_input(if fault.contains(&place) { fault } else { format!("{place}: {fault}") })
    })
}

/// Trains a policy into the folder `out`, with its progress on the terminal.
///
/// # Errors
/// What the trainer reports.
pub fn train_policy(
    config: &ExperimentConfig,
    demonstrations: &Dataset,
    validation: Option<&Dataset>,
    out: &Path,
    resume: Resume,
    terminal: &Terminal,
) -> anyhow::Result<TrainSummary> {
    let request = TrainRequest {
        model: &config.model,
        train: &config.train,
        demonstrations,
        mixture: None,
        validation,
        start: None,
        resume,
        device: config.device,
        out,
    };
    train_with_progress(&request, "training", terminal)
}

/// Trains as requested, with the progress on the terminal under the name `label`.
///
/// # Errors
/// What the trainer reports.
pub fn train_with_progress(
    request: &TrainRequest<'_>,
    label: &str,
    terminal: &Terminal,
) -> anyhow::Result<TrainSummary> {
    let mut display = TrainingDisplay {
        progress: terminal.progress(label, request.train.updates as u64),
        terminal: *terminal,
        score: String::new(),
    };
    let summary = train(request, &mut display)?;
    display.progress.finish();
    Ok(summary)
}

struct TrainingDisplay {
    progress: Progress,
    terminal: Terminal,
    score: String,
}

impl TrainObserver for TrainingDisplay {
    fn on_update(&mut self, metrics: &UpdateMetrics) {
        let UpdateMetrics { loss, samples_per_sec, .. } = metrics;
        self.progress.set(
            metrics.update as u64,
            &format!("loss {loss:.4}, {samples_per_sec:.0} samples/s{}", self.score),
        );
    }

    fn on_validation(&mut self, metrics: &ValidationMetrics) {
        self.score = format!(", validation D_geo {:.4}", metrics.d_geo);
    }

    fn on_resume(&mut self, update: usize, validation: Option<&ValidationMetrics>) {
        self.terminal.note(format!("training goes on after update {update}"));
        self.progress.start_at(update as u64);
        validation.into_iter().for_each(|metrics| self.on_validation(metrics));
    }

    fn on_ignored_state(&mut self, reason: &TrainError) {
        self.terminal.note(format!("warning: training starts anew: {reason}"));
    }
}
