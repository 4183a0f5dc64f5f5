//! The baseline has all that the loop has: it resumes to the same bytes, keeps the best weights and stops early.

use std::panic::{AssertUnwindSafe, catch_unwind};

use reseflow_data::{Dataset, Split};
use reseflow_train::{
    DeviceKind, Keep, Resume, TrainConfig, TrainError, TrainObserver, TrainRequest, TrainSummary,
    UpdateMetrics, ValidationMetrics, train,
};

use crate::support::{Shelf, demonstrations, histories, mean_d_geo, tiny_config, tiny_training};

/// Goes down after an update, if told so, and remembers where it began and how it was scored.
#[derive(Default)]
struct Fuse {
    after: Option<usize>,
    resumed_at: Option<usize>,
    scores: Vec<f64>,
}

impl TrainObserver for Fuse {
    fn on_update(&mut self, metrics: &UpdateMetrics) {
        assert!(self.after != Some(metrics.update), "the power fails");
    }

    fn on_validation(&mut self, metrics: &ValidationMetrics) {
        self.scores.push(metrics.d_geo);
    }

    fn on_resume(&mut self, update: usize, _: Option<&ValidationMetrics>) {
        self.resumed_at = Some(update);
    }
}

fn run(
    shelf: &Shelf,
    name: &str,
    config: &TrainConfig,
    data: [&Dataset; 2],
    fuse: &mut Fuse,
) -> Result<TrainSummary, TrainError> {
    let request = TrainRequest {
        model: &tiny_config(),
        train: config,
        demonstrations: data[0],
        mixture: None,
        validation: Some(data[1]),
        start: None,
        resume: Resume::IfSame,
        device: DeviceKind::Cpu,
        out: &shelf.path(name),
    };
    train(&request, fuse)
}

#[test]
fn a_resumed_baseline_ends_with_the_bytes_of_one_that_was_never_interrupted() {
    let shelf = Shelf::new();
    let (data, held_out) = (demonstrations(Split::Train, 2), demonstrations(Split::Validation, 1));
    let data = [&data, &held_out];
    let config =
        TrainConfig { save_every: 3, validate_every: 4, keep: Keep::Best, patience: 9, ..tiny_training(8) };
    run(&shelf, "whole", &config, data, &mut Fuse::default()).unwrap();
    for (after, expected) in [(2, None), (5, Some(3)), (8, Some(6))] {
        let mut fuse = Fuse { after: Some(after), ..Fuse::default() };
        let ended = catch_unwind(AssertUnwindSafe(|| run(&shelf, "broken", &config, data, &mut fuse)));
        assert!(ended.is_err(), "the training was not interrupted");
        assert!(!shelf.path("broken").exists(), "a checkpoint appeared before its time");
        let mut fuse = Fuse::default();
        run(&shelf, "broken", &config, data, &mut fuse).unwrap();
        assert_eq!(fuse.resumed_at, expected, "interrupted in update {after}");
        let [whole, broken] = ["whole", "broken"]
            .map(|name| std::fs::read(shelf.path(name).join("model.safetensors")).unwrap());
        assert!(whole == broken, "interrupted in update {after}: other weights");
        std::fs::remove_dir_all(shelf.path("broken")).unwrap();
    }
}

#[test]
fn the_best_weights_are_kept_and_training_ends_once_validations_stop_improving() {
    let shelf = Shelf::new();
    let data = demonstrations(Split::Train, 1);
    // Steps this large and no averaging: the policy wanders about, and the best one is not the last.
    let wild = TrainConfig {
        learning_rate: 0.3,
        warmup: 0,
        ema_decay: 0.0,
        validate_every: 1,
        keep: Keep::Best,
        patience: 3,
        ..tiny_training(40)
    };
    let mut fuse = Fuse::default();
    let summary = run(&shelf, "best", &wild, [&data, &data], &mut fuse).unwrap();
    let lowest = fuse.scores.iter().copied().fold(f64::INFINITY, f64::min);
    println!("{:?}", fuse.scores);
    assert!(summary.updates < 40, "it did not stop early");
    assert!(fuse.scores[fuse.scores.len() - 3..].iter().all(|score| *score > lowest), "it stopped too early");
    let drawn = shelf.policy("best").predict(&histories(&data, 0), &[3407], 100).unwrap();
    assert_eq!(mean_d_geo(&drawn, &data), lowest, "the checkpoint is not the best one");
}
