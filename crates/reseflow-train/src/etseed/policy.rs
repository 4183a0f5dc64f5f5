//! The trained baseline as a policy.

use std::path::Path;

use burn::tensor::Device;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use reseflow_data::{ActionChunk, Observation, ObservationHistory, Plan, Policy, PolicyError};
use reseflow_flow::{Anchor, Diffusion, denoise};

use super::checkpoint;
use super::config::EtSeedConfig;
use super::denoiser::NetDenoiser;
use super::input::SceneView;
use super::net::EtSeedNet;
use crate::{DeviceKind, PolicySample, TrainError};

/// A policy that takes noise about the gripper down the levels of the baseline's diffusion.
#[derive(Debug)]
pub struct EtSeedPolicy {
    net: EtSeedNet,
    config: EtSeedConfig,
    diffusion: Diffusion,
    device: Device,
    steps: usize,
    seed: u64,
    plans: u64,
}

impl EtSeedPolicy {
    /// Loads a checkpoint; visits every noise level until told otherwise.
    ///
    /// # Errors
    /// [`TrainError::Io`] and [`TrainError::Checkpoint`] where the folder holds no whole checkpoint of the baseline.
    pub fn load(folder: &Path, device: DeviceKind) -> Result<Self, TrainError> {
        let device = device.device();
        let (net, config) = checkpoint::read(folder, &device)?;
        Self::new(net, config, device)
    }

    /// A policy around networks in memory.
    pub(super) fn new(net: EtSeedNet, config: EtSeedConfig, device: Device) -> Result<Self, TrainError> {
        let diffusion = Diffusion::new(&config.diffusion)?;
        let steps = config.diffusion.steps;
        Ok(Self { net, config, diffusion, device, steps, seed: 0, plans: 0 })
    }

    /// Evaluations of [`Policy::plan`], from 1 to the number of noise levels.
    pub fn set_steps(&mut self, steps: usize) {
        self.steps = steps;
    }

    /// The networks and the diffusion.
    pub fn config(&self) -> &EtSeedConfig {
        &self.config
    }

    /// Observation frames O.
    pub fn observation_horizon(&self) -> usize {
        self.config.network.decoder.frames
    }

    /// Samples `[history][seed]` in `steps` evaluations each; the noise of history i is stream i of the seed.
    ///
    /// The baseline has no nodes, so a sample has neither their trajectories nor a spread.
    ///
    /// # Errors
    /// Where an observation cannot be used, `steps` is zero, or there are fewer noise levels.
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
        let horizon = self.config.network.decoder.horizon;
        let view = |history: &ObservationHistory| {
            let observed: Vec<&Observation> = history.frames().collect();
            let progress = (history.elapsed_steps() as f64 / horizon as f64).min(1.0);
            let graph = &self.config.network.encoder.graph;
            SceneView::new(&observed, progress, graph, self.config.diffusion.frame)
        };
        let views: Result<Vec<SceneView>, TrainError> = histories.iter().map(view).collect();
        let views = views?;
        let anchors: Vec<Anchor> = views.iter().map(|view| view.anchor).collect();
        let mut denoiser = NetDenoiser::new(&self.net, &views, self.config.diffusion.steps, &self.device)?;
        for &seed in seeds {
            let stream = |stream: usize| {
                let mut rng = ChaCha8Rng::seed_from_u64(seed);
                rng.set_stream(stream as u64);
                rng
            };
            let mut rngs: Vec<_> = (0..histories.len()).map(stream).collect();
            let drawn = denoise(&mut denoiser, &self.diffusion, &anchors, horizon, steps, &mut rngs)?;
            for (samples, trajectory) in samples.iter_mut().zip(drawn) {
                samples.push(PolicySample {
                    consensus: clamped(trajectory),
                    nodes: Vec::new(),
                    spread: Vec::new(),
                });
            }
        }
        Ok(samples)
    }
}

fn clamped(mut chunk: ActionChunk) -> ActionChunk {
    chunk.0.iter_mut().for_each(|action| action.opening = action.opening.clamp(0.0, 1.0));
    chunk
}

impl Policy for EtSeedPolicy {
    fn name(&self) -> &str {
        "et_seed"
    }

    fn reset(&mut self, seed: u64) {
        self.seed = seed;
        self.plans = 0;
    }

    fn plan(&mut self, history: &ObservationHistory) -> Result<Plan, PolicyError> {
        let failed = |reason: String| PolicyError { policy: "et_seed".to_owned(), reason };
        // Each plan of an episode has a seed of its own, spread over the whole range.
        let seed = self.seed.wrapping_add(self.plans.wrapping_mul(0x9E37_79B9_7F4A_7C15));
        self.plans += 1;
        let drawn = self
            .predict(std::slice::from_ref(history), &[seed], self.steps)
            .map_err(|fault| failed(fault.to_string()))?;
        let sample =
            drawn.into_iter().flatten().next().ok_or_else(|| failed("nothing was drawn".to_owned()))?;
        Ok(Plan { actions: sample.consensus, uncertainty: None })
    }
}
