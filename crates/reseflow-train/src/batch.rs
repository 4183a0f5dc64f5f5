//! One shard of a training batch: augmented windows, noise and flow times, drawn from a stream of its own.

use burn::tensor::{Device, Tensor, TensorData};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use reseflow_data::{ActionChunk, Dataset, Observation, Window};
use reseflow_flow::{
    EndpointTargets, LossContext, LossParts, NodeTargets, PriorFrame, TwistTargets, endpoint_loss, twist_loss,
};
use reseflow_lie::Vector3;
use reseflow_net::{DecoderConfig, DriftNet, HeatMap, Parameterisation, TokenBatch};

use crate::augment::{Augmentation, drop_points, jitter};
use crate::convert::{endpoint_tensors, tokens, twist_tensors};
use crate::field::{Seen, encode};
use crate::reflow::Example;
use crate::{TrainConfig, TrainError, TrainRequest};

/// A training window as the network is to see it: its observations and its demonstration, augmented.
pub(crate) struct Scene {
    /// The window.
    pub(crate) window: Window,
    /// The O frames, oldest first.
    pub(crate) observed: Vec<Observation>,
    /// What a prior looks at.
    pub(crate) prior_frame: PriorFrame,
    /// The demonstrated actions.
    pub(crate) clean: ActionChunk,
    /// How much each of them counts.
    pub(crate) weights: Vec<f64>,
    augmentation: Augmentation,
}

impl Scene {
    /// Augments the window.
    pub(crate) fn draw(
        window: Window,
        data: &Dataset,
        decoder: &DecoderConfig,
        train: &TrainConfig,
        rng: &mut ChaCha8Rng,
    ) -> Self {
        let mut observed: Vec<Observation> = window.frames(&data.episodes, decoder.frames).cloned().collect();
        let wanted: Vec<_> = window.targets(&data.episodes, decoder.horizon).collect();
        let (latest, next) = (&observed[observed.len() - 1], wanted[0].action);
        let augmentation = Augmentation::draw(window.step, latest, next, &train.augment, rng);
        observed.iter_mut().for_each(|seen| augmentation.observation(seen));
        observed.iter_mut().for_each(|seen| drop_points(&mut seen.cloud, train.augment.drop_points, rng));
        let prior_frame = PriorFrame::of(&observed[observed.len() - 1]);
        observed.iter_mut().for_each(|seen| jitter(&mut seen.cloud, train.augment.jitter_m, rng));
        let weights = wanted.iter().map(|target| target.weight()).collect();
        let mut clean = ActionChunk(wanted.iter().map(|target| *target.action).collect());
        augmentation.actions(&mut clean);
        Self { window, observed, prior_frame, clean, weights, augmentation }
    }

    /// What the network is shown.
    pub(crate) fn seen(&self) -> Seen<'_> {
        (self.observed.iter().collect(), self.window.step)
    }
}

/// Draws windows and the loss's inputs, and evaluates the loss of `net`; `drawn` gets the windows.
pub(crate) fn shard_loss(
    net: &DriftNet,
    request: &TrainRequest<'_>,
    device: &Device,
    rng: &mut ChaCha8Rng,
    drawn: &mut Vec<Window>,
) -> Result<LossParts, TrainError> {
    let TrainRequest { model, train, demonstrations: data, mixture, .. } = *request;
    let decoder = &model.network.decoder;
    let count = train.batch_size / train.shards;
    let (mut scenes, mut noisy, mut ends, mut weights, mut times) =
        (Vec::new(), Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for _ in 0..count {
        let mixed = mixture.map(|mixture| mixture.draw(data, train.first_window_share, rng)).transpose()?;
        let window = mixed.as_ref().map_or_else(|| draw_window(data, train, rng), |mixed| mixed.window);
        drawn.push(window);
        let scene = Scene::draw(window, data, decoder, train, rng);
        let (noise, clean) = match mixed {
            Some(Example { mut noise, mut clean, .. }) => {
                // Both belong to the scene as it was recorded.
                scene.augmentation.noise(&mut noise);
                scene.augmentation.actions(&mut clean);
                (noise, clean)
            }
            None => (model.start(&scene.prior_frame, rng), scene.clean.clone()),
        };
        let t = if model.regression { 0.0 } else { train.time.sample(rng) };
        noisy.push(model.path.at(&noise, &clean, t)?);
        times.push(t);
        weights.extend(scene.weights.iter().copied());
        ends.push((noise, clean));
        scenes.push(scene);
    }
    let seen: Vec<Seen<'_>> = scenes.iter().map(Scene::seen).collect();
    let (encoded, context) = encode(net, &seen, device)?;
    let trajectories: Vec<_> = noisy.iter().map(tokens).collect();
    let batch = TokenBatch::new(&trajectories, &times, &context.origins_m, device)?;
    let overlap = match encoded.last() {
        Some(latest) => HeatMap::overlap(&latest.heat),
        None => Tensor::zeros([1], device),
    };
    let actions = weights.len();
    let judged = LossContext {
        path: model.path,
        states: target_tensors(&noisy, &context.origins_m, device),
        weights: Tensor::from_data(TensorData::new(weights, [actions]), device),
        overlap,
    };
    Ok(match decoder.parameterisation {
        Parameterisation::Endpoint => {
            let prediction = net.decode(&context, &batch)?;
            let targets: Vec<ActionChunk> = ends.into_iter().map(|(_, clean)| clean).collect();
            endpoint_loss(
                &EndpointTargets {
                    rotations: prediction.rotations,
                    positions_m: prediction.positions_m,
                    openings: prediction.openings,
                },
                &NodeTargets {
                    rotations: prediction.node_rotations,
                    positions_m: prediction.node_positions_m,
                },
                &target_tensors(&targets, &context.origins_m, device),
                &judged,
                &train.objective,
            )
        }
        Parameterisation::Twist => {
            let prediction = net.decode_twists(&context, &batch)?;
            let velocities: Result<Vec<_>, _> = (ends.iter().zip(&times))
                .map(|((noise, clean), &t)| model.path.velocity(noise, clean, t))
                .collect();
            twist_loss(
                &TwistTargets { twists: prediction.twists, openings: prediction.openings },
                prediction.node_twists,
                &twist_tensors(&velocities?, device),
                &judged,
                &train.objective,
            )
        }
    })
}

/// Draws an episode, and its first window with the share that the configuration says, else any of its windows; windows begin where the
/// actions suit what is seen.
pub(crate) fn draw_window(data: &Dataset, train: &TrainConfig, rng: &mut ChaCha8Rng) -> Window {
    let episode = rng.random_range(0..data.episodes.len());
    let first: f64 = rng.random();
    let first_step = data.episodes[episode].first_step();
    let step = rng.random_range(first_step..data.episodes[episode].actions.len());
    Window { episode, step: if first < train.first_window_share { first_step } else { step } }
}

/// Trajectories in the world's axes, each from its scene's origin.
fn target_tensors(chunks: &[ActionChunk], origins_m: &[[f64; 3]], device: &Device) -> EndpointTargets {
    let actions = chunks.iter().zip(origins_m).flat_map(|(chunk, origin)| {
        chunk.iter().map(|action| {
            let mut pose = action.world_from_gripper;
            pose.translation -= Vector3::from(*origin);
            (pose, action.opening)
        })
    });
    endpoint_tensors(actions, device)
}
