//! One shard of a training batch: augmented windows, each at a noise level, in two groups for the two kernels.

use burn::tensor::{Device, Tensor, TensorData};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use reseflow_data::{ActionChunk, Window};
use reseflow_flow::{AnchoredChunk, Diffusion};

use super::config::EtSeedConfig;
use super::input::{KernelInput, SceneView, anchored_tensors, world_tensors};
use super::net::EtSeedNet;
use super::objective::left_factor_loss;
use crate::batch::{Scene, draw_window};
use crate::{TrainError, TrainRequest};

/// One drawn example.
pub(super) struct Example {
    pub(super) window: Window,
    pub(super) view: SceneView,
    pub(super) level: usize,
    pub(super) clean: AnchoredChunk,
    pub(super) noisy: AnchoredChunk,
    pub(super) weights: Vec<f64>,
}

/// Draws the examples of a shard.
pub(super) fn draw(
    request: &TrainRequest<'_, EtSeedConfig>,
    rng: &mut ChaCha8Rng,
) -> Result<Vec<Example>, TrainError> {
    let TrainRequest { model: config, train, demonstrations: data, .. } = *request;
    let decoder = &config.network.decoder;
    let diffusion = Diffusion::new(&config.diffusion)?;
    let mut examples = Vec::with_capacity(train.batch_size / train.shards);
    for _ in 0..train.batch_size / train.shards {
        let window = draw_window(data, train, rng);
        let scene = Scene::draw(window, data, decoder, train, rng);
        let view = SceneView::new(&scene.seen(), config)?;
        let level = draw_level(config, rng);
        let clean = view.anchor.see(&scene.clean);
        let noisy = diffusion.noised(&clean, level, rng);
        examples.push(Example { window, view, level, clean, noisy, weights: scene.weights });
    }
    Ok(examples)
}

/// The noise level of one window, from 1 up to K.
fn draw_level(config: &EtSeedConfig, rng: &mut ChaCha8Rng) -> usize {
    let steps = config.diffusion.steps;
    if rng.random::<f64>() < config.last_step_share {
        return 1;
    }
    let noisiest = config.noisiest_share > 0.0 && rng.random::<f64>() < config.noisiest_share;
    let least = if noisiest { (steps - steps / 10 + 1).clamp(2, steps) } else { 2 };
    rng.random_range(least..=steps)
}

/// The mean loss of `examples`, each judged on the kernel of its level.
pub(super) fn loss(
    net: &EtSeedNet,
    examples: &[Example],
    config: &EtSeedConfig,
    device: &Device,
) -> Result<Tensor<1>, TrainError> {
    let mut total = Tensor::zeros([1], device);
    let (last, above): (Vec<&Example>, Vec<&Example>) =
        examples.iter().partition(|example| example.level == 1);
    for group in [above, last] {
        let Some(first) = group.first() else { continue };
        let views: Vec<&SceneView> = group.iter().map(|example| &example.view).collect();
        let noisy: Vec<_> = group.iter().map(|example| example.noisy.clone()).collect();
        let clean: Vec<_> = group.iter().map(|example| example.clean.clone()).collect();
        let weights: Vec<f64> = group.iter().flat_map(|example| example.weights.clone()).collect();
        let actions = weights.len();
        let weights = Tensor::from_data(TensorData::new(weights, [actions]), device);
        let (predicted, targets) = if first.level == 1 {
            let place = |chunks: &[AnchoredChunk]| -> Vec<ActionChunk> {
                views.iter().zip(chunks).map(|(view, chunk)| view.anchor.place(chunk)).collect()
            };
            let input = KernelInput::equivariant(&views, &place(&noisy), device)?;
            let scenes = net.equivariant.trunk.encode(&views, device)?;
            (net.equivariant.forward(&scenes, &input)?, world_tensors(&views, &place(&clean), device))
        } else {
            let levels: Vec<usize> = group.iter().map(|example| example.level).collect();
            let input = KernelInput::invariant(&views, &noisy, &levels, config.diffusion.steps, device)?;
            let scenes = net.invariant.trunk.encode(&views, device)?;
            (net.invariant.forward(&scenes, &input)?, anchored_tensors(&clean, device))
        };
        let share = group.len() as f64 / examples.len() as f64;
        total = total + left_factor_loss(&predicted, &targets, weights, config.opening).mul_scalar(share);
    }
    Ok(total)
}
