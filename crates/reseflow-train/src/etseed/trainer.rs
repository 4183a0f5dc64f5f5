//! The training loop of the baseline: the flows' optimiser, averages and clipping, its own batches and objective.

use std::path::Path;
use std::time::Instant;

use burn::module::Module;
use burn::optim::{AdamWConfig, GradientsAccumulator, GradientsParams};
use burn::tensor::Device;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use reseflow_data::{Dataset, ObservationHistory};
use reseflow_flow::Diffusion;
use reseflow_lie::geodesic_distance;
use serde::Serialize;

use super::batch::{draw, loss};
use super::checkpoint;
use super::config::EtSeedConfig;
use super::net::EtSeedNet;
use super::policy::EtSeedPolicy;
use crate::ema::WeightAverage;
use crate::gradients::clip_global_norm;
use crate::partial::PartialFolder;
use crate::{
    DeviceKind, Keep, TrainConfig, TrainError, TrainObserver, TrainSummary, UpdateMetrics, ValidationMetrics,
};

/// The noise seed of validations.
const VALIDATION_SEED: u64 = 3407;

/// A training of the baseline: what to train, on what, and where the checkpoint goes.
#[derive(Debug, Clone, Copy)]
pub struct EtSeedRequest<'a> {
    /// The networks, the diffusion and the objective.
    pub config: &'a EtSeedConfig,
    /// The optimisation and the augmentations; flow times and the flows' objective play no part.
    pub train: &'a TrainConfig,
    /// The episodes to learn from.
    pub demonstrations: &'a Dataset,
    /// Held-out episodes, scored during training at all noise levels.
    pub validation: Option<&'a Dataset>,
    /// Where to compute.
    pub device: DeviceKind,
    /// The checkpoint's folder.
    pub out: &'a Path,
}

/// Trains the baseline and leaves a checkpoint in the folder `request.out`, which appears whole or not at all.
///
/// # Errors
/// Bad configurations, a loss or gradient that is not finite, and what the file system reports.
pub fn train_et_seed(
    request: &EtSeedRequest<'_>,
    observer: &mut dyn TrainObserver,
) -> Result<TrainSummary, TrainError> {
    let EtSeedRequest { config, train, validation, out, .. } = *request;
    check(request)?;
    crate::checkpoint::may_become(out)?;
    let mut partial = PartialFolder::claim(out)?;
    let base = request.device.device();
    let device = base.clone().autodiff();
    let diffusion = Diffusion::new(&config.diffusion)?;
    let mut net = EtSeedNet::new(config, &device, &mut stream(train.seed, 0));
    let mut optimizer = AdamWConfig::new().with_weight_decay(train.weight_decay as f32).init();
    let mut average = WeightAverage::new(train.ema_decay);
    let (mut metrics, mut last_validation, mut best) = (Vec::new(), None, None::<ValidationMetrics>);
    let started = Instant::now();
    for update in 1..=train.updates {
        let (mut gradients, loss) = gradients(&net, request, &diffusion, &device, update)?;
        let gradient_norm = clip_global_norm(&net, &mut gradients, train.clip_norm);
        if !gradient_norm.is_finite() {
            let windows = (0..train.shards)
                .flat_map(|shard| draw(request, &diffusion, &mut batch_stream(train, update, shard)))
                .flatten()
                .map(|example| example.window);
            let windows = windows.collect();
            return Err(TrainError::Diverged { what: "gradient", update, shard: 0, windows });
        }
        let learning_rate = train.rate(update - 1);
        net = optimizer.step(learning_rate, net, gradients);
        average.update(&net, update);

        let samples_per_sec = (update * train.batch_size) as f64 / started.elapsed().as_secs_f64();
        let report = UpdateMetrics { update, loss, learning_rate, gradient_norm, samples_per_sec };
        note(&mut metrics, &mut partial, &report)?;
        observer.on_update(&report);
        if let Some(held_out) = validation
            && (update % train.validate_every == 0 || update == train.updates)
        {
            let report = validate(average.apply(net.valid()), config, held_out, &base, update)?;
            note(&mut metrics, &mut partial, &report)?;
            observer.on_validation(&report);
            last_validation = Some(report);
            if best.is_none_or(|best| report.d_geo < best.d_geo) {
                best = Some(report);
            }
        }
    }
    let net = average.apply(net.valid());
    partial.publish(|folder| checkpoint::write(folder, &net, config, &metrics))?;
    Ok(TrainSummary {
        parameters: net.num_params(),
        seconds: started.elapsed().as_secs_f64(),
        updates: train.updates,
        validation: last_validation,
        best,
    })
}

/// Makes sure that what was asked for can be done: configurations, and something to learn from and to compare with.
fn check(request: &EtSeedRequest<'_>) -> Result<(), TrainError> {
    request.config.validate()?;
    request.train.validate()?;
    let TrainConfig { keep, patience, accumulate, .. } = *request.train;
    for (key, refused) in
        [("keep = \"best\"", keep == Keep::Best), ("patience", patience > 0), ("accumulate", accumulate > 1)]
    {
        if refused {
            let fault =
                format!("train.{key} is not for the baseline, which keeps the weights of its last update");
            return Err(TrainError::Config(fault));
        }
    }
    for data in std::iter::once(request.demonstrations).chain(request.validation) {
        if data.episodes.is_empty() {
            return Err(TrainError::NoData);
        }
        if let Some(index) = data.episodes.iter().position(|episode| episode.actions.is_empty()) {
            return Err(TrainError::NoActions { index });
        }
    }
    Ok(())
}

/// Gradients and loss of one batch, its shards on threads of their own; the sums run in the order of the shards.
fn gradients(
    net: &EtSeedNet,
    request: &EtSeedRequest<'_>,
    diffusion: &Diffusion,
    device: &Device,
    update: usize,
) -> Result<(GradientsParams, f64), TrainError> {
    let (train, config) = (request.train, request.config);
    let copies: Vec<_> = (0..train.shards).map(|shard| (shard, net.clone().fork(device))).collect();
    let results: Vec<Result<(GradientsParams, f64), TrainError>> = std::thread::scope(|scope| {
        let work = |(shard, net): (usize, EtSeedNet)| {
            scope.spawn(move || {
                let examples = draw(request, diffusion, &mut batch_stream(train, update, shard))?;
                let loss = loss(&net, &examples, config.diffusion.steps, config.opening, device)?
                    .div_scalar(train.shards as f64);
                let value = loss.clone().into_scalar::<f64>();
                if !value.is_finite() {
                    let windows = examples.iter().map(|example| example.window).collect();
                    return Err(TrainError::Diverged { what: "loss", update, shard, windows });
                }
                Ok((GradientsParams::from_grads(loss.backward(), &net), value))
            })
        };
        let handles: Vec<_> = copies.into_iter().map(work).collect();
        handles.into_iter().map(|handle| handle.join().unwrap_or(Err(TrainError::Worker))).collect()
    });
    let mut sum = GradientsAccumulator::new();
    let mut total = 0.0;
    for result in results {
        let (gradients, loss) = result?;
        sum.accumulate(net, gradients);
        total += loss;
    }
    Ok((sum.grads(), total))
}

/// D_geo of the averaged weights on the first windows of `held_out`, at all noise levels.
fn validate(
    net: EtSeedNet,
    config: &EtSeedConfig,
    held_out: &Dataset,
    device: &Device,
    update: usize,
) -> Result<ValidationMetrics, TrainError> {
    let frames = config.network.decoder.frames;
    let first =
        |episode: &reseflow_data::Episode| ObservationHistory::at_step(&episode.observations, 0, frames);
    let histories: Vec<_> = held_out.episodes.iter().map(first).collect();
    let policy = EtSeedPolicy::new(net, config.clone(), device.clone())?;
    let drawn = policy.predict(&histories, &[VALIDATION_SEED], config.diffusion.steps)?;
    let mut report = ValidationMetrics { update, d_geo: 0.0, rotation_rad: 0.0, translation_m: 0.0 };
    let mut count = 0.0;
    for (samples, episode) in drawn.iter().zip(&held_out.episodes) {
        for (predicted, wanted) in
            samples.iter().flat_map(|sample| sample.consensus.iter().zip(&episode.actions))
        {
            let apart = geodesic_distance(&predicted.world_from_gripper, &wanted.world_from_gripper);
            report.d_geo += apart.d_geo();
            report.rotation_rad += apart.rotation_rad;
            report.translation_m += apart.translation_m;
            count += 1.0;
        }
    }
    report.d_geo /= count;
    report.rotation_rad /= count;
    report.translation_m /= count;
    Ok(report)
}

fn stream(seed: u64, stream: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(stream);
    rng
}

fn batch_stream(train: &TrainConfig, update: usize, shard: usize) -> ChaCha8Rng {
    stream(train.seed, (update * train.shards + shard) as u64)
}

/// Appends `value` as a line to the metrics, here and in the partial folder.
fn note(
    metrics: &mut Vec<u8>,
    partial: &mut PartialFolder,
    value: &impl Serialize,
) -> Result<(), TrainError> {
    let start = metrics.len();
    serde_json::to_writer(&mut *metrics, value).map_err(|fault| TrainError::Config(fault.to_string()))?;
    metrics.push(b'\n');
    partial.append_metrics(&metrics[start..])
}
