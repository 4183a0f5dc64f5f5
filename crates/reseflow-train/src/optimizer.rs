//! What turns gradients into steps.

use burn::module::ParamGroup;
use burn::optim::decay::WeightDecayConfig;
use burn::optim::{AdamWConfig, AdjustLrFn, ModuleOptimizer, MuonConfig};
use serde::{Deserialize, Serialize};

/// The optimiser. Weight decay is decoupled in both.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Optimizer {
    /// Muon (K. Jordan, 2024) for the matrices of linear layers, whose steps it makes orthogonal, scaled so that learning rates are
    /// those of AdamW (arXiv 2502.16982); AdamW for everything else.
    #[default]
    Muon,
    /// AdamW for everything.
    AdamW,
}

impl Optimizer {
    /// The optimiser before the first step.
    pub(crate) fn init(self, weight_decay: f64) -> ModuleOptimizer {
        let adam_w = AdamWConfig::new().with_weight_decay(weight_decay as f32).init();
        match self {
            Optimizer::AdamW => adam_w,
            Optimizer::Muon => {
                let muon = MuonConfig::new()
                    .with_adjust_lr_fn(AdjustLrFn::MatchRmsAdamW)
                    .with_weight_decay(Some(WeightDecayConfig::new(weight_decay as f32)))
                    .build();
                // Only linear layers have parameters of that name, and theirs are matrices.
                adam_w.with_group(ParamGroup::from_predicate("weight"), muon, None)
            }
        }
    }
}
