//! The training loop of both flows.

use std::io::Write;
use std::path::Path;
use std::time::Instant;

use burn::module::Module;
use burn::optim::{AdamWConfig, GradientsAccumulator, GradientsParams};
use burn::tensor::Device;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use reseflow_data::{Dataset, ObservationHistory};
use reseflow_lie::geodesic_distance;
use reseflow_net::DriftNet;
use serde::Serialize;

use crate::batch::shard_loss;
use crate::ema::WeightAverage;
use crate::gradients::clip_global_norm;
use crate::{FlowPolicy, ModelConfig, TrainError, TrainRequest, checkpoint};

/// The noise seed of validations.
const VALIDATION_SEED: u64 = 3407;

/// How an update went.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct UpdateMetrics {
    /// The update, from 1.
    pub update: usize,
    /// The objective.
    pub loss: f64,
    /// The learning rate.
    pub learning_rate: f64,
    /// The global gradient norm before clipping.
    pub gradient_norm: f64,
    /// Windows a second since the start.
    pub samples_per_sec: f64,
}

/// One-step errors of the averaged weights on the validation episodes' first windows.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct ValidationMetrics {
    /// The update, from 1.
    pub update: usize,
    /// Mean D_geo.
    pub d_geo: f64,
    /// Its rotation part, radians.
    pub rotation_rad: f64,
    /// Its translation part, metres.
    pub translation_m: f64,
}

/// Hears how training goes.
pub trait TrainObserver {
    /// An update was made.
    fn on_update(&mut self, metrics: &UpdateMetrics);
    /// A validation was made.
    fn on_validation(&mut self, metrics: &ValidationMetrics);
}

/// What training left.
#[derive(Debug, Clone, Serialize)]
pub struct TrainSummary {
    /// Trainable numbers.
    pub parameters: usize,
    /// Wall-clock seconds.
    pub seconds: f64,
    /// The last validation, where there were validation episodes.
    pub validation: Option<ValidationMetrics>,
}

/// Trains a flow and leaves a checkpoint in the folder `request.out`, which appears whole or not at all.
///
/// # Errors
/// Bad configurations, a loss that is not finite, and what the file system reports.
pub fn train(
    request: &TrainRequest<'_>,
    observer: &mut dyn TrainObserver,
) -> Result<TrainSummary, TrainError> {
    let TrainRequest { model, train, demonstrations, validation, out, .. } = *request;
    model.validate()?;
    train.validate()?;
    for data in std::iter::once(demonstrations).chain(validation) {
        check(data)?;
    }
    checkpoint::may_become(out)?;
    let io = |source| TrainError::Io { path: out.to_owned(), source };
    let parent = out.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    std::fs::create_dir_all(parent).map_err(io)?;
    let aside = tempfile::Builder::new().prefix(".training-").tempdir_in(parent).map_err(io)?;
    let folder = aside.path().join("new");
    std::fs::create_dir(&folder).map_err(io)?;
    let metrics = std::fs::File::create(folder.join(checkpoint::METRICS)).map_err(io)?;
    let mut metrics = std::io::BufWriter::new(metrics);

    let base = request.device.device();
    let device = base.clone().autodiff();
    let mut net = first_weights(request, &device)?;
    let mut optimizer = AdamWConfig::new().with_weight_decay(train.weight_decay as f32).init();
    let mut average = WeightAverage::new(train.ema_decay);
    let mut last_validation = None;
    let started = Instant::now();

    for update in 1..=train.updates {
        let (mut gradients, loss) = gradients(&net, request, &device, update)?;
        if !loss.is_finite() {
            return Err(TrainError::Diverged { update });
        }
        let gradient_norm = clip_global_norm(&net, &mut gradients, train.clip_norm);
        let learning_rate = train.rate(update - 1);
        net = optimizer.step(learning_rate, net, gradients);
        average.update(&net, update);

        let samples_per_sec = (update * train.batch_size) as f64 / started.elapsed().as_secs_f64();
        let report = UpdateMetrics { update, loss, learning_rate, gradient_norm, samples_per_sec };
        write_line(&mut metrics, &report).map_err(io)?;
        observer.on_update(&report);
        if let Some(held_out) = validation
            && (update % train.validate_every == 0 || update == train.updates)
        {
            let report = validate(average.apply(net.valid()), model, held_out, &base, update)?;
            write_line(&mut metrics, &report).map_err(io)?;
            observer.on_validation(&report);
            last_validation = Some(report);
        }
    }
    metrics.flush().map_err(io)?;
    checkpoint::write(&folder, &average.apply(net.valid()), model)?;
    checkpoint::put_in_place(&folder, out, &aside.path().join("old")).map_err(io)?;
    let seconds = started.elapsed().as_secs_f64();
    Ok(TrainSummary { parameters: net.num_params(), seconds, validation: last_validation })
}

/// The averaged weights of the checkpoint to start from, or freshly drawn ones.
fn first_weights(request: &TrainRequest<'_>, device: &Device) -> Result<DriftNet, TrainError> {
    let Some(start) = request.start else {
        return Ok(request.model.network.init(device, &mut stream(request.train.seed, 0)));
    };
    let (net, model) = checkpoint::read(start, device)?;
    if model.network != request.model.network {
        let fault = "its network is not the one to be trained, so training cannot start from it".to_owned();
        return Err(TrainError::Checkpoint { path: start.to_owned(), fault });
    }
    Ok(net)
}

/// Makes sure that every episode has something to learn or to compare with.
fn check(data: &Dataset) -> Result<(), TrainError> {
    if data.episodes.is_empty() {
        return Err(TrainError::NoData);
    }
    match data.episodes.iter().position(|episode| episode.actions.is_empty()) {
        Some(index) => Err(TrainError::NoActions { index }),
        None => Ok(()),
    }
}

/// Gradients and loss of one batch, its shards on threads of their own.
///
/// Every shard has its own copy of the network, hence its own autodiff graph, and its own random stream; the sums run in the order
/// of the shards, so the result does not depend on which thread is first.
fn gradients(
    net: &DriftNet,
    request: &TrainRequest<'_>,
    device: &Device,
    update: usize,
) -> Result<(GradientsParams, f64), TrainError> {
    let train = request.train;
    let shards: Vec<_> = (0..train.shards).map(|shard| (shard, net.clone().fork(device))).collect();
    let results: Vec<Result<(GradientsParams, f64), TrainError>> = std::thread::scope(|scope| {
        let work = |(shard, net): (usize, DriftNet)| {
            scope.spawn(move || {
                let mut rng = stream(train.seed, (update * train.shards + shard) as u64);
                let parts = shard_loss(&net, request, device, &mut rng)?;
                let loss = parts.total.div_scalar(train.shards as f64);
                let value = loss.clone().into_scalar::<f64>();
                Ok((GradientsParams::from_grads(loss.backward(), &net), value))
            })
        };
        let handles: Vec<_> = shards.into_iter().map(work).collect();
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

fn validate(
    net: DriftNet,
    model: &ModelConfig,
    held_out: &Dataset,
    device: &Device,
    update: usize,
) -> Result<ValidationMetrics, TrainError> {
    let frames = model.network.decoder.frames;
    let histories: Vec<_> = held_out
        .episodes
        .iter()
        .map(|episode| ObservationHistory::at_step(&episode.observations, 0, frames))
        .collect();
    let policy = FlowPolicy::new(net, model.clone(), device.clone());
    let drawn = policy.predict(&histories, &[VALIDATION_SEED], 1)?;
    let (mut d_geo, mut rotation_rad, mut translation_m, mut count) = (0.0, 0.0, 0.0, 0.0);
    for (samples, episode) in drawn.iter().zip(&held_out.episodes) {
        for (predicted, wanted) in
            samples.iter().flat_map(|sample| sample.consensus.iter().zip(&episode.actions))
        {
            let distance = geodesic_distance(&predicted.world_from_gripper, &wanted.world_from_gripper);
            d_geo += distance.d_geo();
            rotation_rad += distance.rotation_rad;
            translation_m += distance.translation_m;
            count += 1.0;
        }
    }
    Ok(ValidationMetrics {
        update,
        d_geo: d_geo / count,
        rotation_rad: rotation_rad / count,
        translation_m: translation_m / count,
    })
}

fn stream(seed: u64, stream: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(stream);
    rng
}

fn write_line(out: &mut impl Write, value: &impl Serialize) -> std::io::Result<()> {
    serde_json::to_writer(&mut *out, value)?;
    out.write_all(b"\n")
}
