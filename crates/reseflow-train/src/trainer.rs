//! The training loop of everything that is trained: both flows, the regressor and the baseline.

use std::path::Path;
use std::time::Instant;

use burn::module::Module;
use burn::optim::{GradientsAccumulator, GradientsParams};
use burn::tensor::Device;
use reseflow_data::{Dataset, Window};
use serde::Serialize;

use crate::checkpoint::CheckpointConfig;
use crate::ema::WeightAverage;
use crate::fingerprint::Fingerprint;
use crate::gradients::{clip_global_norm, global_norm};
use crate::partial::PartialFolder;
use crate::state::TrainState;
use crate::trainable::random_stream;
use crate::validation::validate;
use crate::{Keep, Resume, TrainConfig, TrainError, TrainRequest, Trainable, ValidationMetrics, checkpoint};

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
    /// Windows a second since training was started or resumed.
    pub samples_per_sec: f64,
}

/// Hears how training goes.
pub trait TrainObserver {
    /// An update was made.
    fn on_update(&mut self, metrics: &UpdateMetrics);
    /// A validation was made.
    fn on_validation(&mut self, metrics: &ValidationMetrics);
    /// An interrupted training goes on after `update` updates; `validation` is the last one.
    fn on_resume(&mut self, update: usize, validation: Option<&ValidationMetrics>) {
        let _ = (update, validation);
    }
    /// An interrupted training left a state that cannot be used here.
    fn on_ignored_state(&mut self, reason: &TrainError) {
        let _ = reason;
    }
}

/// What training left.
#[derive(Debug, Clone, Serialize)]
pub struct TrainSummary {
    /// Trainable numbers.
    pub parameters: usize,
    /// Wall-clock seconds since training was started or resumed.
    pub seconds: f64,
    /// Updates made; fewer than configured where validations stopped improving.
    pub updates: usize,
    /// The last validation, where there were validation episodes.
    pub validation: Option<ValidationMetrics>,
    /// The best validation; its weights are in the checkpoint too, as the policy under `keep = "best"`, else beside it.
    pub best: Option<ValidationMetrics>,
}

/// Trains what is asked for and leaves a checkpoint in the folder `request.out`, which appears whole or not at all.
///
/// Until then `<request.out>.partial` holds the training's state, from which an interrupted training goes on to the same bytes.
///
/// # Errors
/// Bad configurations, a loss or gradient that is not finite, a state that cannot be used, and what the file system reports.
pub fn train<M: Trainable>(
    request: &TrainRequest<'_, M>,
    observer: &mut dyn TrainObserver,
) -> Result<TrainSummary, TrainError> {
    let TrainRequest { model, train, validation, out, .. } = *request;
    check(request)?;
    checkpoint::may_become(out)?;
    let mut partial = PartialFolder::claim(out)?;
    let base = request.device.device();
    let device = base.clone().autodiff();
    let fingerprint = (train.save_every > 0 || request.resume != Resume::Never)
        .then(|| Fingerprint::of(request))
        .transpose()?;
    let mut state = first_state(request, &partial, fingerprint.as_ref(), &device, observer)?;
    partial.append_metrics(&state.metrics)?;
    tracing::info!(
        kind = M::KIND.name(),
        parameters = state.net.num_params(),
        episodes = request.demonstrations.len(),
        first_update = state.update + 1,
        updates = train.updates,
        out = %out.display(),
        "training"
    );
    let (first, started) = (state.update, Instant::now());
    let is_over = |state: &TrainState<M::Net>| {
        state.update >= train.updates || (train.patience > 0 && state.stale >= train.patience)
    };

    while !is_over(&state) {
        let update = state.update + 1;
        let (mut gradients, loss) = gradients(&state.net, request, &device, update)?;
        let gradient_norm = clip_global_norm(&state.net, &mut gradients, train.clip_norm);
        if !gradient_norm.is_finite() {
            return Err(infinite_gradient(&state.net, request, &device, update));
        }
        let learning_rate = train.rate(update - 1);
        state.net = state.optimizer.step(learning_rate, state.net, gradients);
        state.average.update(&state.net, update);
        state.update = update;

        let windows = (update - first) * train.batch_size * train.accumulate;
        let samples_per_sec = windows as f64 / started.elapsed().as_secs_f64();
        let report = UpdateMetrics { update, loss, learning_rate, gradient_norm, samples_per_sec };
        note(&mut state.metrics, &mut partial, &report)?;
        tracing::debug!(update, loss, gradient_norm, learning_rate, "update");
        observer.on_update(&report);
        if let Some(held_out) = validation
            && (update % train.validate_every == 0 || update == train.updates)
        {
            let net = state.average.apply(state.net.valid());
            let report = validate(net, model, held_out, &base, update)
                .map_err(|fault| TrainError::Validation(Box::new(fault)))?;
            note(&mut state.metrics, &mut partial, &report)?;
            tracing::info!(update, d_geo = report.d_geo, "validation");
            observer.on_validation(&report);
            judge(&mut state, report);
        }
        // Also after the last update, so that nothing is lost where the checkpoint cannot be written.
        if let Some(fingerprint) = &fingerprint
            && train.save_every > 0
            && (update % train.save_every == 0 || is_over(&state))
        {
            let unwritable = |fault| TrainError::State { path: partial.state_path(), fault };
            partial.write_state(&state.to_bytes(fingerprint).map_err(unwritable)?)?;
            tracing::debug!(update, "state saved");
        }
    }
    let (kept, other) = averages(&state, train.keep);
    let net = kept.apply(state.net.valid());
    let other = other.map(|(name, average)| (name, average.apply(state.net.valid())));
    let config = CheckpointConfig {
        kind: M::KIND,
        task: request.demonstrations.meta.as_ref().map(|meta| meta.task.clone()),
        model: model.clone(),
        train: Some(train.clone()),
        mixture: request.mixture.map(|mixture| *mixture.parts().0),
    };
    partial.publish(|folder| {
        checkpoint::write(folder, &net, &config, &state.metrics)?;
        other.iter().try_for_each(|(name, net)| checkpoint::write_weights(&folder.join(name), net))
    })?;
    tracing::info!(updates = state.update, out = %out.display(), "checkpoint written");
    Ok(TrainSummary {
        parameters: net.num_params(),
        seconds: started.elapsed().as_secs_f64(),
        updates: state.update,
        validation: state.validation,
        best: state.best,
    })
}

/// Makes sure that what was asked for can be done: configurations, and something to learn from and to compare with.
fn check<M: Trainable>(request: &TrainRequest<'_, M>) -> Result<(), TrainError> {
    let TrainConfig { keep, patience, .. } = *request.train;
    request.model.check()?;
    request.model.check_training(request.train)?;
    if request.validation.is_none() && (keep == Keep::Best || patience > 0) {
        let key = if keep == Keep::Best { "train.keep = \"best\"" } else { "train.patience" };
        return Err(TrainError::Config(format!("{key} needs validation episodes, got none")));
    }
    check_data(request.demonstrations)?;
    let held_out = request.validation.map_or(Ok(()), |data| check_data(data).and_then(|()| check_calm(data)));
    held_out.map_err(|fault| TrainError::Validation(Box::new(fault)))
}

/// Scores are taken from an episode's first step on.
fn check_calm(data: &Dataset) -> Result<(), TrainError> {
    match data.episodes.iter().position(|episode| episode.disturbance.is_some()) {
        Some(index) => Err(TrainError::Disturbed { index }),
        None => Ok(()),
    }
}

fn check_data(data: &Dataset) -> Result<(), TrainError> {
    if data.episodes.is_empty() {
        return Err(TrainError::NoData);
    }
    match data.episodes.iter().position(|episode| episode.actions.len() <= episode.first_step()) {
        Some(index) => Err(TrainError::NoActions { index }),
        None => Ok(()),
    }
}

/// Where training begins: at the state that an interrupted one left, if that is wanted and can be used, or before any update.
fn first_state<M: Trainable>(
    request: &TrainRequest<'_, M>,
    partial: &PartialFolder,
    fingerprint: Option<&Fingerprint>,
    device: &Device,
    observer: &mut dyn TrainObserver,
) -> Result<TrainState<M::Net>, TrainError> {
    let train = request.train;
    let left = if request.resume == Resume::Never { None } else { partial.read_state()? };
    if let (Some(bytes), Some(fingerprint)) = (left, fingerprint) {
        // The drawn weights are all replaced.
        let fresh = request.model.init(device, &mut random_stream(train.seed, 0))?;
        match TrainState::from_bytes(&bytes, fingerprint, fresh, train, device) {
            Ok(state) => {
                observer.on_resume(state.update, state.validation.as_ref());
                return Ok(state);
            }
            Err(fault) => {
                let fault = TrainError::State { path: partial.state_path(), fault };
                if request.resume == Resume::Always {
                    return Err(fault);
                }
                observer.on_ignored_state(&fault);
            }
        }
    }
    let net = match request.start {
        Some(start) => weights_of(start, request, device)?,
        None => request.model.init(device, &mut random_stream(train.seed, 0))?,
    };
    Ok(TrainState::new(net, train))
}

/// The averaged weights of the checkpoint `start`.
fn weights_of<M: Trainable>(
    start: &Path,
    request: &TrainRequest<'_, M>,
    device: &Device,
) -> Result<M::Net, TrainError> {
    let (net, config) = checkpoint::read::<M>(start, device)?;
    if config.model.network() != request.model.network() {
        let fault = "its network is not the one to be trained, so training cannot start from it".to_owned();
        return Err(TrainError::Checkpoint { path: start.to_owned(), fault });
    }
    Ok(net)
}

/// The averaged weights that become the policy, and the others with the name of their file: the last ones beside the best, or the best
/// beside the last, where they are not the same.
fn averages<N: Module>(
    state: &TrainState<N>,
    keep: Keep,
) -> (&WeightAverage, Option<(&'static str, &WeightAverage)>) {
    let is_last = state.best.is_none_or(|best| best.update == state.update);
    match (&state.best_average, keep) {
        (Some(best), Keep::Best) if !is_last => (best, Some((checkpoint::LAST, &state.average))),
        (Some(best), Keep::Last) if !is_last => (&state.average, Some((checkpoint::BEST, best))),
        _ => (&state.average, None),
    }
}

/// Takes in a validation: the best one so far, or one more without improvement.
fn judge<N: Module>(state: &mut TrainState<N>, report: ValidationMetrics) {
    state.validation = Some(report);
    if state.best.is_none_or(|best| report.d_geo < best.d_geo) {
        state.best = Some(report);
        state.best_average = Some(state.average.clone());
        state.stale = 0;
    } else {
        state.stale += 1;
    }
}

/// Gradients, loss and windows of one part of a batch.
struct Shard {
    gradients: GradientsParams,
    loss: f64,
    windows: Vec<Window>,
}

/// One of the `accumulate` · `shards` parts of an update's batch, with a random stream of its own.
fn shard<M: Trainable>(
    net: &M::Net,
    request: &TrainRequest<'_, M>,
    device: &Device,
    update: usize,
    part: usize,
) -> Result<Shard, TrainError> {
    let train = request.train;
    let parts = train.accumulate * train.shards;
    let mut rng = random_stream(train.seed, (update * parts + part) as u64);
    let mut windows = Vec::new();
    let loss = match M::shard_loss(net, request, device, &mut rng, &mut windows) {
        Ok(loss) => loss.div_scalar(parts as f64),
        Err(fault @ TrainError::Net(_)) => {
            return Err(TrainError::Batch { fault: Box::new(fault), update, shard: part, windows });
        }
        Err(fault) => return Err(fault),
    };
    let value = loss.clone().into_scalar::<f64>();
    if !value.is_finite() {
        return Err(TrainError::Diverged { what: "loss", update, shard: part, windows });
    }
    Ok(Shard { gradients: GradientsParams::from_grads(loss.backward(), net), loss: value, windows })
}

/// The network with parameters that begin a graph of their own.
///
/// A fork would hang its parameters on those of `net`; below a parameter that no gradient ever replaces, all forks of a training would
/// stay in the autodiff's books, and every update would look through them.
fn leaves<N: Module>(net: &N) -> N {
    net.valid().train()
}

/// Gradients and loss of one update, the shards of each batch on threads of their own.
///
/// Every shard has its own copy of the network, hence its own autodiff graph; the sums run in the order of the shards, so the result
/// does not depend on which thread is first.
fn gradients<M: Trainable>(
    net: &M::Net,
    request: &TrainRequest<'_, M>,
    device: &Device,
    update: usize,
) -> Result<(GradientsParams, f64), TrainError> {
    let train = request.train;
    let mut sum = GradientsAccumulator::new();
    let mut total = 0.0;
    for batch in 0..train.accumulate {
        let copies: Vec<_> = (0..train.shards).map(|index| (index, leaves(net))).collect();
        let results: Vec<Result<Shard, TrainError>> = std::thread::scope(|scope| {
            let work = |(index, net): (usize, M::Net)| {
                scope.spawn(move || shard(&net, request, device, update, batch * train.shards + index))
            };
            let handles: Vec<_> = copies.into_iter().map(work).collect();
            handles.into_iter().map(|handle| handle.join().unwrap_or(Err(TrainError::Worker))).collect()
        });
        for result in results {
            let Shard { gradients, loss, .. } = result?;
            sum.accumulate(net, gradients);
            total += loss;
        }
    }
    Ok((sum.grads(), total))
}

/// Finds the shard whose gradient is not finite, by doing the update once more.
fn infinite_gradient<M: Trainable>(
    net: &M::Net,
    request: &TrainRequest<'_, M>,
    device: &Device,
    update: usize,
) -> TrainError {
    let mut windows = Vec::new();
    for part in 0..request.train.accumulate * request.train.shards {
        match shard(&leaves(net), request, device, update, part) {
            Err(fault) => return fault,
            Ok(done) if !global_norm(net, &done.gradients).is_finite() => {
                return TrainError::Diverged { what: "gradient", update, shard: part, windows: done.windows };
            }
            Ok(done) => windows.extend(done.windows),
        }
    }
    // Each is finite, their sum is not.
    TrainError::Diverged { what: "summed gradient", update, shard: 0, windows }
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
