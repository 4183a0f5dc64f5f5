//! A rectified flow as the training loop and the policy see it, and the regressor, which is the same without noise and flow time.

use burn::tensor::{Device, Tensor};
use rand_chacha::ChaCha8Rng;
use reseflow_data::{Action, ActionChunk, ObservationHistory, Window};
use reseflow_flow::{FlowError, PriorFrame, Solver, Straightness, integrate, straightness, trace};
use reseflow_lie::geodesic_distance;
use reseflow_net::{DriftNet, DriftNetConfig};

use crate::batch::shard_loss;
use crate::field::{NetField, NodeAnswers, scenes_of};
use crate::policy::clamped;
use crate::trainable::random_stream;
use crate::{
    Drawn, ModelConfig, PolicyKind, PolicySample, TrainConfig, TrainError, TrainRequest, Trainable,
    TrainedPolicy,
};

/// A policy that integrates a learned flow from noise about the gripper.
pub type FlowPolicy = TrainedPolicy<ModelConfig>;

impl Trainable for ModelConfig {
    type Net = DriftNet;

    const KIND: PolicyKind = PolicyKind::Flow;

    fn network(&self) -> &DriftNetConfig {
        &self.network
    }

    fn check(&self) -> Result<(), TrainError> {
        self.validate()
    }

    fn check_training(&self, train: &TrainConfig) -> Result<(), TrainError> {
        self.validate_training(train)
    }

    fn init(&self, device: &Device, rng: &mut ChaCha8Rng) -> Result<DriftNet, TrainError> {
        Ok(self.network.init(device, rng)?)
    }

    fn shard_loss(
        net: &DriftNet,
        request: &TrainRequest<'_>,
        device: &Device,
        rng: &mut ChaCha8Rng,
        drawn: &mut Vec<Window>,
    ) -> Result<Tensor<1>, TrainError> {
        Ok(shard_loss(net, request, device, rng, drawn)?.total)
    }

    fn solver(&self) -> Solver {
        Solver::Euler { steps: 1 }
    }

    fn draw(
        &self,
        net: &DriftNet,
        histories: &[ObservationHistory],
        seeds: &[u64],
        first: usize,
        solver: &Solver,
        device: &Device,
    ) -> Result<Drawn, TrainError> {
        if self.regression && *solver != self.solver() {
            let fault = "a regressor answers at once, so its solver is one step of \"euler\"".to_owned();
            return Err(FlowError::Config(fault).into());
        }
        let mut drawn = Drawn { samples: vec![Vec::new(); histories.len()], ..Drawn::default() };
        let mut field = NetField::new(net, &scenes_of(histories), device)?;
        for &seed in seeds {
            let noise = self.noise(histories, seed, first);
            let ends = integrate(&mut field.flow(), self.path, noise, solver)?;
            drawn.steps = drawn.steps.max(ends.steps);
            drawn.evaluations = drawn.evaluations.max(ends.evaluations);
            let Some(last) = field.last.take() else { continue };
            for (scene, (state, samples)) in ends.states.into_iter().zip(&mut drawn.samples).enumerate() {
                samples.push(sample(state, &last, scene));
            }
        }
        Ok(drawn)
    }
}

impl ModelConfig {
    /// The noise that trajectories from `histories` start at; that of history i is stream `first` + i of the seed.
    pub(crate) fn noise(
        &self,
        histories: &[ObservationHistory],
        seed: u64,
        first: usize,
    ) -> Vec<ActionChunk> {
        let streams = histories.iter().zip(first as u64..);
        let noise = streams.map(|(history, stream)| {
            self.start(&PriorFrame::of(history.latest()), &mut random_stream(seed, stream))
        });
        noise.collect()
    }

    /// Where a trajectory starts: at noise, or, of a regressor, at the gripper's pose.
    pub(crate) fn start(&self, frame: &PriorFrame, rng: &mut ChaCha8Rng) -> ActionChunk {
        let horizon = self.network.decoder.horizon;
        if self.regression {
            let PriorFrame { world_from_gripper, opening, .. } = *frame;
            return ActionChunk(vec![Action { world_from_gripper, opening }; horizon]);
        }
        self.prior.sample(frame, horizon, rng)
    }
}

impl FlowPolicy {
    /// How straight the flow is along `steps` uniform Euler steps, from the noise that [`TrainedPolicy::draw`] draws for the seed.
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
        let mut field = NetField::new(&self.net, &scenes_of(histories), &self.device)?;
        let noise = self.model.noise(histories, seed, 0);
        Ok(straightness(&mut field.flow(), self.model.path, &noise, steps)?)
    }

    /// The ways of `steps` uniform Euler steps from the noise that [`TrainedPolicy::draw`] draws for `history` alone:
    /// `[seed][grid time]`, `steps` + 1 trajectories each, with openings as the flow has them.
    ///
    /// # Errors
    /// Where the observation cannot be used, or `steps` is zero.
    pub fn trace(
        &self,
        history: &ObservationHistory,
        seeds: &[u64],
        steps: usize,
    ) -> Result<Vec<Vec<ActionChunk>>, TrainError> {
        let alone = std::slice::from_ref(history);
        let mut field = NetField::new(&self.net, &scenes_of(alone), &self.device)?;
        let way = |&seed: &u64| {
            let noise = self.model.noise(alone, seed, 0);
            let states = trace(&mut field.flow(), self.model.path, noise, steps)?;
            Ok(states.into_iter().flatten().collect())
        };
        seeds.iter().map(way).collect()
    }
}

fn sample(state: ActionChunk, last: &NodeAnswers, scene: usize) -> PolicySample {
    let said = match last {
        NodeAnswers::Endpoints(said) => said,
        NodeAnswers::Twists(spread) => {
            let spread = spread[scene].clone();
            return PolicySample { consensus: clamped(state), nodes: Vec::new(), spread };
        }
    };
    let nodes = said.nodes[scene].clone();
    let spread = (state.iter().enumerate())
        .map(|(step, consensus)| {
            let weighted = nodes.iter().zip(&said.weights[scene][step]).map(|(node, weight)| {
                let to_node = &node.0[step].world_from_gripper;
                weight * geodesic_distance(&consensus.world_from_gripper, to_node).d_geo().powi(2)
            });
            weighted.sum::<f64>().sqrt()
        })
        .collect();
    PolicySample { consensus: clamped(state), nodes: nodes.into_iter().map(clamped).collect(), spread }
}
