//! A trained flow as a policy.

use std::path::Path;

use burn::tensor::Device;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use reseflow_data::{ActionChunk, Observation, ObservationHistory, Plan, Policy, PolicyError};
use reseflow_flow::{Flow, PriorFrame, Solver, Straightness, integrate, straightness};
use reseflow_lie::geodesic_distance;
use reseflow_net::DriftNet;

use crate::convert::HostPrediction;
use crate::field::NetField;
use crate::{DeviceKind, ModelConfig, TrainError, checkpoint};

/// One drawn trajectory.
#[derive(Debug, Clone, PartialEq)]
pub struct PolicySample {
    /// What the nodes agree on; openings clamped to \[0, 1\].
    pub consensus: ActionChunk,
    /// Each node's trajectory.
    pub nodes: Vec<ActionChunk>,
    /// Weighted rms of the nodes' D_geo to the consensus, one for each action.
    pub spread: Vec<f64>,
}

/// A policy that integrates a learned flow from noise about the gripper.
#[derive(Debug)]
pub struct FlowPolicy {
    pub(crate) net: DriftNet,
    pub(crate) config: ModelConfig,
    pub(crate) device: Device,
    steps: usize,
    seed: u64,
    plans: u64,
}

impl FlowPolicy {
    /// Loads a checkpoint; integrates in one step until told otherwise.
    ///
    /// # Errors
    /// [`TrainError::Io`] and [`TrainError::Checkpoint`] where the folder holds no whole checkpoint.
    pub fn load(folder: &Path, device: DeviceKind) -> Result<Self, TrainError> {
        let device = device.device();
        let (net, config) = checkpoint::read(folder, &device)?;
        Ok(Self { net, config, device, steps: 1, seed: 0, plans: 0 })
    }

    /// A policy around a network in memory.
    pub(crate) fn new(net: DriftNet, config: ModelConfig, device: Device) -> Self {
        Self { net, config, device, steps: 1, seed: 0, plans: 0 }
    }

    /// Integration steps of [`Policy::plan`].
    pub fn set_steps(&mut self, steps: usize) {
        self.steps = steps;
    }

    /// The network and the flow.
    pub fn model(&self) -> &ModelConfig {
        &self.config
    }

    /// A copy for another thread.
    pub(crate) fn fork(&self) -> Self {
        Self::new(self.net.clone(), self.config.clone(), self.device.clone())
    }

    /// Observation frames O.
    pub fn observation_horizon(&self) -> usize {
        self.config.network.decoder.frames
    }

    /// Samples `[history][seed]`: each scene is encoded once, and the noise of history i is stream i of the seed.
    ///
    /// # Errors
    /// Where an observation cannot be used or `steps` is zero.
    pub fn predict(
        &self,
        histories: &[ObservationHistory],
        seeds: &[u64],
        steps: usize,
    ) -> Result<Vec<Vec<PolicySample>>, TrainError> {
        let mut samples = vec![Vec::with_capacity(seeds.len()); histories.len()];
        if histories.is_empty() {
            return Ok(samples);
        }
        let scenes: Vec<(Vec<&Observation>, usize)> =
            histories.iter().map(|history| (history.frames().collect(), history.elapsed_steps())).collect();
        let mut field = NetField::new(&self.net, &scenes, &self.device)?;
        for &seed in seeds {
            let noise = histories
                .iter()
                .enumerate()
                .map(|(stream, history)| self.noise(history, seed, stream as u64));
            let mut flow = Flow::Endpoint(&mut field);
            let solver = Solver::Euler { steps };
            let states = integrate(&mut flow, self.config.path, noise.collect(), &solver)?.states;
            let Some(last) = field.last.take() else { continue };
            for (scene, state) in states.into_iter().enumerate() {
                samples[scene].push(sample(state, &last, scene));
            }
        }
        Ok(samples)
    }

    /// How straight the flow is along `steps` uniform Euler steps, from the noise that [`FlowPolicy::predict`] draws for the seed.
    ///
    /// # Errors
    /// Where an observation cannot be used, or `histories` is empty or `steps` zero.
    pub fn straightness(
        &self,
        histories: &[ObservationHistory],
        seed: u64,
        steps: usize,
    ) -> Result<Straightness, TrainError> {
        if histories.is_empty() {
            return Err(TrainError::NoData);
        }
        let scenes: Vec<(Vec<&Observation>, usize)> =
            histories.iter().map(|history| (history.frames().collect(), history.elapsed_steps())).collect();
        let mut field = NetField::new(&self.net, &scenes, &self.device)?;
        let streams = histories.iter().zip(0..);
        let noise: Vec<_> = streams.map(|(history, stream)| self.noise(history, seed, stream)).collect();
        Ok(straightness(&mut Flow::Endpoint(&mut field), self.config.path, &noise, steps)?)
    }

    fn noise(&self, history: &ObservationHistory, seed: u64, stream: u64) -> ActionChunk {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(stream);
        let horizon = self.config.network.decoder.horizon;
        self.config.prior.sample(&PriorFrame::of(history.latest()), horizon, &mut rng)
    }
}

fn sample(state: ActionChunk, last: &HostPrediction, scene: usize) -> PolicySample {
    let nodes = last.nodes[scene].clone();
    let spread = (state.iter().enumerate())
        .map(|(step, consensus)| {
            let weighted = nodes.iter().zip(&last.weights[scene][step]).map(|(node, weight)| {
                let to_node = &node.0[step].world_from_gripper;
                weight * geodesic_distance(&consensus.world_from_gripper, to_node).d_geo().powi(2)
            });
            weighted.sum::<f64>().sqrt()
        })
        .collect();
    let clamp = |chunk: ActionChunk| {
        ActionChunk(
            chunk
                .0
                .into_iter()
                .map(|mut action| {
                    action.opening = action.opening.clamp(0.0, 1.0);
                    action
                })
                .collect(),
        )
    };
    PolicySample { consensus: clamp(state), nodes: nodes.into_iter().map(clamp).collect(), spread }
}

impl Policy for FlowPolicy {
    fn name(&self) -> &str {
        "flow"
    }

    fn reset(&mut self, seed: u64) {
        self.seed = seed;
        self.plans = 0;
    }

    fn plan(&mut self, history: &ObservationHistory) -> Result<Plan, PolicyError> {
        let failed = |reason: String| PolicyError { policy: "flow".to_owned(), reason };
        // Each plan of an episode has a seed of its own, spread over the whole range.
        let seed = self.seed.wrapping_add(self.plans.wrapping_mul(0x9E37_79B9_7F4A_7C15));
        self.plans += 1;
        let drawn = self
            .predict(std::slice::from_ref(history), &[seed], self.steps)
            .map_err(|fault| failed(fault.to_string()))?;
        let sample =
            drawn.into_iter().flatten().next().ok_or_else(|| failed("nothing was drawn".to_owned()))?;
        Ok(Plan { actions: sample.consensus, uncertainty: Some(sample.spread) })
    }
}
