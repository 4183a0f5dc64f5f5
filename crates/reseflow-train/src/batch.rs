//! One shard of a training batch: augmented windows, noise and flow times, drawn from a stream of its own.

use burn::tensor::{Device, Tensor, TensorData};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use reseflow_data::{ActionChunk, Dataset, Observation, Window};
use reseflow_flow::{EndpointTargets, LossContext, LossParts, NodeTargets, PriorFrame, endpoint_loss};
use reseflow_net::{CloudGraph, DriftNet, HeatMap, TokenBatch};

use crate::augment::{Scaling, drop_points, jitter};
use crate::convert::{graph, token, tokens};
use crate::reflow::Example;
use crate::{TrainConfig, TrainError, TrainRequest};

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
    let (mut frames, mut states, mut noisy, mut targets, mut weights, mut times) =
        (vec![Vec::new(); decoder.frames], Vec::new(), Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for _ in 0..count {
        let mixed = mixture.map(|mixture| mixture.draw(data, train.first_window_share, rng)).transpose()?;
        let window = mixed.as_ref().map_or_else(|| draw_window(data, train, rng), |mixed| mixed.window);
        drawn.push(window);
        let mut observed: Vec<Observation> = window.frames(&data.episodes, decoder.frames).cloned().collect();
        let scaling = Scaling::draw(&observed[observed.len() - 1].cloud, train, rng);
        observed.iter_mut().for_each(|seen| scaling.iter().for_each(|scaling| scaling.observation(seen)));
        let grippers: Vec<_> =
            observed.iter().map(|seen| token(&seen.world_from_gripper, seen.gripper_opening)).collect();
        observed.iter_mut().for_each(|seen| drop_points(&mut seen.cloud, train.drop_points, rng));
        let prior_frame = PriorFrame::of(&observed[observed.len() - 1]);
        for (frame, seen) in frames.iter_mut().zip(&mut observed) {
            jitter(&mut seen.cloud, train.jitter_m, rng);
            frame.push(graph(seen, &model.network.encoder.graph)?);
        }
        let progress = (window.step as f64 / decoder.horizon as f64).min(1.0);
        states.push(reseflow_net::SceneState { frames: grippers, progress });

        let wanted: Vec<_> = window.targets(&data.episodes, decoder.horizon).collect();
        let (noise, clean) = match mixed {
            Some(Example { mut noise, mut clean, .. }) => {
                // Both belong to the scene as it was recorded.
                scaling.iter().for_each(|scaling| scaling.actions(&mut noise));
                scaling.iter().for_each(|scaling| scaling.actions(&mut clean));
                (noise, clean)
            }
            None => {
                let mut clean = ActionChunk(wanted.iter().map(|target| *target.action).collect());
                scaling.iter().for_each(|scaling| scaling.actions(&mut clean));
                (model.prior.sample(&prior_frame, decoder.horizon, rng), clean)
            }
        };
        let t = train.time.sample(rng);
        noisy.push(model.path.at(&noise, &clean, t)?);
        times.push(t);
        weights.extend(wanted.iter().map(|target| target.weight()));
        targets.push(clean);
    }
    let encode = |(frame, graphs): (usize, &Vec<CloudGraph>)| {
        let grippers: Vec<_> = states.iter().map(|state| state.frames[frame]).collect();
        net.encode(graphs, &grippers, device)
    };
    let encoded: Result<Vec<_>, _> = frames.iter().enumerate().map(encode).collect();
    let encoded = encoded?;
    let context = net.context(&encoded, &states)?;
    let trajectories: Vec<_> = noisy.iter().map(tokens).collect();
    let batch = TokenBatch::new(&trajectories, &times, &context.origins_m, device)?;
    let prediction = net.decode(&context, &batch)?;
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
    Ok(endpoint_loss(
        &EndpointTargets {
            rotations: prediction.rotations,
            positions_m: prediction.positions_m,
            openings: prediction.openings,
        },
        &NodeTargets { rotations: prediction.node_rotations, positions_m: prediction.node_positions_m },
        &target_tensors(&targets, &context.origins_m, device),
        &judged,
        &train.objective,
    ))
}

fn draw_window(data: &Dataset, train: &TrainConfig, rng: &mut ChaCha8Rng) -> Window {
    let episode = rng.random_range(0..data.episodes.len());
    let first: f64 = rng.random();
    let step = rng.random_range(0..data.episodes[episode].actions.len());
    Window { episode, step: if first < train.first_window_share { 0 } else { step } }
}

fn target_tensors(chunks: &[ActionChunk], origins_m: &[[f64; 3]], device: &Device) -> EndpointTargets {
    let (mut rotations, mut positions, mut openings) = (Vec::new(), Vec::new(), Vec::new());
    for (chunk, origin) in chunks.iter().zip(origins_m) {
        for action in chunk.iter() {
            // nalgebra iterates by columns, tensors are laid out by rows.
            rotations.extend(action.world_from_gripper.rotation.matrix().transpose().iter().copied());
            positions.extend((0..3).map(|axis| action.world_from_gripper.translation[axis] - origin[axis]));
            openings.push(action.opening);
        }
    }
    let count = openings.len();
    EndpointTargets {
        rotations: Tensor::from_data(TensorData::new(rotations, [count, 3, 3]), device),
        positions_m: Tensor::from_data(TensorData::new(positions, [count, 3]), device),
        openings: Tensor::from_data(TensorData::new(openings, [count, 1]), device),
    }
}
