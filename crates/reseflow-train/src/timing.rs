//! How long the parts of a plan take.

use std::time::Instant;

use reseflow_data::ObservationHistory;
use reseflow_flow::{Solver, integrate};

use crate::field::{NetField, scenes_of};
use crate::{FlowPolicy, TrainError};

/// Wall-clock seconds of one plan's parts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlanTimes {
    /// Everything that is done once an observation: graph, encoder, and what the decoder keeps of the scene.
    pub encoder_secs: f64,
    /// Everything after it: noise and all solver steps.
    pub decoder_secs: f64,
}

impl FlowPolicy {
    /// Plans once, as [`FlowPolicy::draw`] does for one history and seed, and says what took how long.
    ///
    /// # Errors
    /// As [`FlowPolicy::draw`].
    pub fn time_plan(
        &self,
        history: &ObservationHistory,
        seed: u64,
        solver: &Solver,
    ) -> Result<PlanTimes, TrainError> {
        let alone = std::slice::from_ref(history);
        let started = Instant::now();
        let mut field = NetField::new(&self.net, &scenes_of(alone), &self.device)?;
        let encoder_secs = started.elapsed().as_secs_f64();
        let noise = self.model.noise(alone, seed, 0);
        integrate(&mut field.flow(), self.model.path, noise, solver)?;
        Ok(PlanTimes { encoder_secs, decoder_secs: started.elapsed().as_secs_f64() - encoder_secs })
    }
}
