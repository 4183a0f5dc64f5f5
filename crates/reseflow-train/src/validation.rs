//! Validation: errors of the averaged weights on held-out episodes.

use burn::tensor::Device;
use reseflow_data::{Dataset, ObservationHistory};
use reseflow_lie::geodesic_distance;
use serde::Serialize;

use crate::{TrainError, Trainable, TrainedPolicy};

/// The noise seed of validations.
const VALIDATION_SEED: u64 = 3407;

/// Errors of the averaged weights on the validation episodes' first windows: a flow's in one step, the baseline's at all its levels.
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

/// Scores `net` on the first windows of `held_out`.
pub(crate) fn validate<M: Trainable>(
    net: M::Net,
    model: &M,
    held_out: &Dataset,
    device: &Device,
    update: usize,
) -> Result<ValidationMetrics, TrainError> {
    let frames = model.network().decoder.frames;
    let histories: Vec<_> = held_out
        .episodes
        .iter()
        .map(|episode| ObservationHistory::at_step(&episode.observations, 0, frames))
        .collect();
    let policy = TrainedPolicy::new(net, model.clone(), device.clone());
    let drawn = policy.draw(&histories, &[VALIDATION_SEED], &model.solver())?.samples;
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
