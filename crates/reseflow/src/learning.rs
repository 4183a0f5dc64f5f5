//! Where the runner meets the trainer: progress on the terminal, checkpoints into policies.

mod shipped;

pub use shipped::{find_policies, find_policy};

use std::path::Path;
use std::time::Instant;

use reseflow_data::{ObservationHistory, Policy};
use reseflow_train::{
    DeviceKind, Drawn, EtSeedPolicy, FlowPolicy, PlanTimes, PolicyKind, Solver, TrainError, TrainObserver,
    TrainRequest, TrainSummary, Trainable, TrainedPolicy, UpdateMetrics, ValidationMetrics, read_kind, train,
};

use crate::cli::DeviceArg;
use crate::config::EVAL_STEPS;
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

impl<M: Trainable> SamplePolicy for TrainedPolicy<M> {
    fn observation_horizon(&self) -> usize {
        TrainedPolicy::observation_horizon(self)
    }

    fn sample(
        &self,
        histories: &[ObservationHistory],
        seeds: &[u64],
        solver: &Solver,
    ) -> anyhow::Result<Drawn> {
        Ok(self.draw(histories, seeds, solver)?)
    }
}

/// A trained policy of whatever kind its checkpoint says.
#[derive(Debug)]
pub enum LearnedPolicy {
    /// A flow, or a regressor.
    Flow(Box<FlowPolicy>),
    /// The baseline.
    EtSeed(Box<EtSeedPolicy>),
}

impl LearnedPolicy {
    /// The policy in the checkpoint's folder `folder`.
    ///
    /// # Errors
    /// Bad input: there is no such folder, or what is in it is no whole checkpoint.
    pub fn load(folder: &Path, device: DeviceKind) -> anyhow::Result<Self> {
        let kind = in_folder(folder, read_kind)?.0;
        tracing::info!(checkpoint = %folder.display(), kind = kind.name(), "loading a policy");
        Ok(match kind {
            PolicyKind::Flow => Self::Flow(Box::new(load_flow(folder, device)?)),
            PolicyKind::EtSeed => {
                let policy = in_folder(folder, |folder| EtSeedPolicy::load(folder, device))?;
                Self::EtSeed(Box::new(policy))
            }
        })
    }

    /// What is drawn from.
    pub fn sampler(&self) -> &dyn SamplePolicy {
        match self {
            Self::Flow(policy) => policy.as_ref(),
            Self::EtSeed(policy) => policy.as_ref(),
        }
    }

    /// Who acts, planning with `solver`.
    pub fn acting(&mut self, solver: Solver) -> &mut dyn Policy {
        match self {
            Self::Flow(policy) => {
                policy.set_solver(solver);
                policy.as_mut()
            }
            Self::EtSeed(policy) => {
                policy.set_solver(solver);
                policy.as_mut()
            }
        }
    }

    /// The flow whose straightness can be measured, if this is one.
    pub fn flow(&self) -> Option<&FlowPolicy> {
        match self {
            Self::Flow(policy) if !policy.model().regression => Some(policy),
            _ => None,
        }
    }

    /// Plans once for the seed: the seconds of the encoder and of the solver's steps, where it has both apart, and of the whole.
    ///
    /// # Errors
    /// When the observation or the solver is not one that this policy can use.
    pub fn time_plan(
        &self,
        history: &ObservationHistory,
        seed: u64,
        solver: &Solver,
    ) -> anyhow::Result<(Option<PlanTimes>, f64)> {
        let started = Instant::now();
        let parts = match self {
            Self::Flow(policy) => Some(policy.time_plan(history, seed, solver)?),
            Self::EtSeed(policy) => {
                policy.draw(std::slice::from_ref(history), &[seed], solver)?;
                None
            }
        };
        Ok((parts, started.elapsed().as_secs_f64()))
    }

    /// The numbers of steps that it is scored with where nothing is said.
    pub fn usual_steps(&self) -> Vec<usize> {
        match self {
            Self::Flow(policy) if policy.model().regression => vec![1],
            Self::Flow(_) => EVAL_STEPS.to_vec(),
            Self::EtSeed(policy) => {
                let levels = policy.model().diffusion.steps;
                EVAL_STEPS.into_iter().filter(|steps| *steps <= levels).collect()
            }
        }
    }
}

/// The flow in the checkpoint's folder `folder`.
///
/// # Errors
/// Bad input: there is no such folder, or what is in it is no whole checkpoint of a flow.
pub fn load_flow(folder: &Path, device: DeviceKind) -> anyhow::Result<FlowPolicy> {
    in_folder(folder, |folder| FlowPolicy::load(folder, device))
}

/// The task that the checkpoint in `folder` has learned, where it says so.
///
/// # Errors
/// As [`LearnedPolicy::load`].
pub fn learned_task(folder: &Path) -> anyhow::Result<Option<String>> {
    Ok(in_folder(folder, read_kind)?.1)
}

/// Reads something of a checkpoint; whatever is wrong with it names the folder.
fn in_folder<T>(folder: &Path, read: impl FnOnce(&Path) -> Result<T, TrainError>) -> anyhow::Result<T> {
    let place = folder.display().to_string();
    if !folder.is_dir() {
        return Err(bad_input(format!("{place}: there is no such folder, expected a checkpoint's")));
    }
    read(folder).map_err(|fault| {
        let fault = sentence(&anyhow::Error::new(fault));
        bad_input(if fault.contains(&place) { fault } else { format!("{place}: {fault}") })
    })
}

/// Trains as requested, with the progress on the terminal under the name `label`.
///
/// # Errors
/// What the trainer reports.
pub fn train_with_progress<M: Trainable>(
    request: &TrainRequest<'_, M>,
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
