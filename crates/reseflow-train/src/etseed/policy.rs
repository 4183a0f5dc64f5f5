//! The baseline as the training loop and the policy see it.

use burn::tensor::{Device, Tensor};
use rand_chacha::ChaCha8Rng;
use reseflow_data::{ObservationHistory, Window};
use reseflow_flow::{Anchor, Diffusion, FlowError, Solver, denoise};
use reseflow_net::DriftNetConfig;

use super::batch;
use super::config::EtSeedConfig;
use super::denoiser::NetDenoiser;
use super::input::SceneView;
use super::net::EtSeedNet;
use crate::field::scenes_of;
use crate::policy::clamped;
use crate::trainable::random_stream;
use crate::{Drawn, PolicyKind, PolicySample, TrainError, TrainRequest, Trainable, TrainedPolicy};

/// A policy that takes noise about the gripper down the levels of the baseline's diffusion.
pub type EtSeedPolicy = TrainedPolicy<EtSeedConfig>;

impl Trainable for EtSeedConfig {
    type Net = EtSeedNet;

    const KIND: PolicyKind = PolicyKind::EtSeed;

    fn network(&self) -> &DriftNetConfig {
        &self.network
    }

    fn check(&self) -> Result<(), TrainError> {
        self.validate()
    }

    fn init(&self, device: &Device, rng: &mut ChaCha8Rng) -> Result<EtSeedNet, TrainError> {
        EtSeedNet::new(self, device, rng)
    }

    fn shard_loss(
        net: &EtSeedNet,
        request: &TrainRequest<'_, Self>,
        device: &Device,
        rng: &mut ChaCha8Rng,
        drawn: &mut Vec<Window>,
    ) -> Result<Tensor<1>, TrainError> {
        if request.mixture.is_some() {
            return Err(TrainError::Pairs("belong to a flow, and the baseline is none".to_owned()));
        }
        let examples = batch::draw(request, rng)?;
        drawn.extend(examples.iter().map(|example| example.window));
        batch::loss(net, &examples, request.model, device)
    }

    /// Every noise level.
    fn solver(&self) -> Solver {
        Solver::Euler { steps: self.diffusion.steps }
    }

    /// An Euler step is an evaluation at one noise level; there are no nodes, so a sample has neither their trajectories nor a spread.
    fn draw(
        &self,
        net: &EtSeedNet,
        histories: &[ObservationHistory],
        seeds: &[u64],
        first: usize,
        solver: &Solver,
        device: &Device,
    ) -> Result<Drawn, TrainError> {
        let Solver::Euler { steps } = *solver else {
            let fault = format!(
                "the baseline goes down noise levels and has no flow to integrate, so its solver is \"euler\", got \"{}\"",
                solver.name()
            );
            return Err(FlowError::Config(fault).into());
        };
        let views: Result<Vec<SceneView>, TrainError> =
            scenes_of(histories).iter().map(|scene| SceneView::new(scene, self)).collect();
        let views = views?;
        let anchors: Vec<Anchor> = views.iter().map(|view| view.anchor).collect();
        let diffusion = Diffusion::new(&self.diffusion)?;
        let mut denoiser = NetDenoiser::new(net, &views, self.diffusion.steps, device)?;
        let mut samples = vec![Vec::with_capacity(seeds.len()); histories.len()];
        for &seed in seeds {
            let streams = first as u64..(first + histories.len()) as u64;
            let mut rngs: Vec<_> = streams.map(|stream| random_stream(seed, stream)).collect();
            let horizon = self.network.decoder.horizon;
            let drawn = denoise(&mut denoiser, &diffusion, &anchors, horizon, steps, &mut rngs)?;
            for (samples, trajectory) in samples.iter_mut().zip(drawn) {
                let consensus = clamped(trajectory);
                samples.push(PolicySample { consensus, nodes: Vec::new(), spread: Vec::new() });
            }
        }
        Ok(Drawn { samples, steps, evaluations: steps })
    }
}
