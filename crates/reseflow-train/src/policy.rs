//! A trained network as a policy.

use std::path::Path;

use burn::tensor::Device;
use reseflow_data::{ActionChunk, ObservationHistory, Plan, Policy, PolicyError};
use reseflow_flow::Solver;

use crate::half_turn::take_nearest_half_turn;
use crate::{DeviceKind, TrainError, Trainable, checkpoint};

/// Histories that are encoded together and share an adaptive solver's steps; more are drawn group by group, which bounds the memory.
const TOGETHER: usize = 32;

/// One drawn trajectory.
#[derive(Debug, Clone, PartialEq)]
pub struct PolicySample {
    /// What the nodes agree on; openings clamped to \[0, 1\].
    pub consensus: ActionChunk,
    /// Each node's trajectory; none where the network has no nodes that answer with one by themselves.
    pub nodes: Vec<ActionChunk>,
    /// Weighted rms of the nodes' distances to the consensus, one for each action: D_geo between endpoints, and in twist form the
    /// same of velocities, per unit of flow time; none without nodes.
    pub spread: Vec<f64>,
}

/// Drawn trajectories, and what they cost.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Drawn {
    /// Samples `[history][seed]`.
    pub samples: Vec<Vec<PolicySample>>,
    /// Integration steps; where an adaptive solver took now more and now fewer, the most.
    pub steps: usize,
    /// Evaluations of the network, likewise.
    pub evaluations: usize,
}

/// A policy that draws trajectories with a trained network.
#[derive(Debug)]
pub struct TrainedPolicy<M: Trainable> {
    pub(crate) net: M::Net,
    pub(crate) model: M,
    pub(crate) device: Device,
    solver: Solver,
    seed: u64,
    plans: u64,
}

impl<M: Trainable> TrainedPolicy<M> {
    /// Loads a checkpoint; draws as in validations until told otherwise.
    ///
    /// # Errors
    /// [`TrainError::Io`] and [`TrainError::Checkpoint`] where the folder holds no whole checkpoint of this kind.
    pub fn load(folder: &Path, device: DeviceKind) -> Result<Self, TrainError> {
        let device = device.device();
        let (net, config) = checkpoint::read::<M>(folder, &device)?;
        Ok(Self::new(net, config.model, device))
    }

    /// A policy around a network in memory.
    pub(crate) fn new(net: M::Net, model: M, device: Device) -> Self {
        Self { solver: model.solver(), net, model, device, seed: 0, plans: 0 }
    }

    /// How [`Policy::plan`] draws.
    pub fn set_solver(&mut self, solver: Solver) {
        self.solver = solver;
    }

    /// The network and what it is made of.
    pub fn model(&self) -> &M {
        &self.model
    }

    /// A copy for another thread.
    pub(crate) fn fork(&self) -> Self {
        Self::new(self.net.clone(), self.model.clone(), self.device.clone())
    }

    /// Observation frames O.
    pub fn observation_horizon(&self) -> usize {
        self.model.network().decoder.frames
    }

    /// Samples `[history][seed]`: each scene is encoded once, and the noise of history i is stream i of the seed.
    ///
    /// # Errors
    /// Where an observation cannot be used, or the solver is none for this kind of policy.
    pub fn draw(
        &self,
        histories: &[ObservationHistory],
        seeds: &[u64],
        solver: &Solver,
    ) -> Result<Drawn, TrainError> {
        let mut all = Drawn::default();
        for (group, together) in histories.chunks(TOGETHER).enumerate() {
            let drawn =
                self.model.draw(&self.net, together, seeds, group * TOGETHER, solver, &self.device)?;
            let mut samples = drawn.samples;
            if self.model.network().decoder.nearest_half_turn {
                for (history, samples) in together.iter().zip(&mut samples) {
                    let gripper = &history.latest().world_from_gripper;
                    samples.iter_mut().for_each(|sample| take_nearest_half_turn(sample, gripper));
                }
            }
            all.samples.extend(samples);
            all.steps = all.steps.max(drawn.steps);
            all.evaluations = all.evaluations.max(drawn.evaluations);
        }
        Ok(all)
    }

    /// The samples of [`TrainedPolicy::draw`] in `steps` uniform Euler steps.
    ///
    /// # Errors
    /// As [`TrainedPolicy::draw`].
    pub fn predict(
        &self,
        histories: &[ObservationHistory],
        seeds: &[u64],
        steps: usize,
    ) -> Result<Vec<Vec<PolicySample>>, TrainError> {
        Ok(self.draw(histories, seeds, &Solver::Euler { steps })?.samples)
    }
}

/// A trajectory whose openings are ones that a gripper has.
pub(crate) fn clamped(mut chunk: ActionChunk) -> ActionChunk {
    chunk.0.iter_mut().for_each(|action| action.opening = action.opening.clamp(0.0, 1.0));
    chunk
}

impl<M: Trainable> Policy for TrainedPolicy<M> {
    fn name(&self) -> &str {
        M::KIND.name()
    }

    fn reset(&mut self, seed: u64) {
        self.seed = seed;
        self.plans = 0;
    }

    fn plan(&mut self, history: &ObservationHistory) -> Result<Plan, PolicyError> {
        let failed = |reason: String| PolicyError { policy: M::KIND.name().to_owned(), reason };
        // Each plan of an episode has a seed of its own, spread over the whole range.
        let seed = self.seed.wrapping_add(self.plans.wrapping_mul(0x9E37_79B9_7F4A_7C15));
        self.plans += 1;
        let drawn = self
            .draw(std::slice::from_ref(history), &[seed], &self.solver)
            .map_err(|fault| failed(fault.to_string()))?;
        let sample = drawn.samples.into_iter().flatten().next();
        let PolicySample { consensus, spread, .. } =
            sample.ok_or_else(|| failed("nothing was drawn".to_owned()))?;
        Ok(Plan { actions: consensus, uncertainty: (!spread.is_empty()).then_some(spread) })
    }
}
