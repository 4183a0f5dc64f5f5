//! A training that was interrupted and resumed ends with the bytes of one that was not; a state that does not fit is never used.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;

use reseflow_data::{Dataset, Split};
use reseflow_train::{
    DeviceKind, Keep, Resume, TrainConfig, TrainError, TrainObserver, TrainRequest, TrainSummary,
    UpdateMetrics, ValidationMetrics, train,
};

use crate::support::{Shelf, contents, demonstrations, tiny_model, tiny_training, untimed};

/// Goes down after an update, if told so, and remembers where it began and what it was told.
#[derive(Default)]
struct Fuse {
    after: Option<usize>,
    resumed_at: Option<usize>,
    ignored: Option<String>,
}

impl TrainObserver for Fuse {
    fn on_update(&mut self, metrics: &UpdateMetrics) {
        assert!(self.after != Some(metrics.update), "the power fails");
    }

    fn on_validation(&mut self, _: &ValidationMetrics) {}

    fn on_resume(&mut self, update: usize, _: Option<&ValidationMetrics>) {
        self.resumed_at = Some(update);
    }

    fn on_ignored_state(&mut self, reason: &TrainError) {
        self.ignored = Some(reason.to_string());
    }
}

/// A shelf with its data and a training of twelve updates, whose states are those of updates 4 and 8.
struct Workshop {
    shelf: Shelf,
    data: Dataset,
    held_out: Dataset,
    config: TrainConfig,
}

impl Workshop {
    fn new() -> Self {
        let config = TrainConfig {
            save_every: 4,
            validate_every: 3,
            keep: Keep::Best,
            patience: 9,
            ..tiny_training(12)
        };
        let (data, held_out) = (demonstrations(Split::Train, 2), demonstrations(Split::Validation, 2));
        Self { shelf: Shelf::new(), data, held_out, config }
    }

    fn train(&self, name: &str, resume: Resume, fuse: &mut Fuse) -> Result<TrainSummary, TrainError> {
        self.train_as(name, &self.config, &self.data, resume, fuse)
    }

    fn train_as(
        &self,
        name: &str,
        config: &TrainConfig,
        data: &Dataset,
        resume: Resume,
        observer: &mut dyn TrainObserver,
    ) -> Result<TrainSummary, TrainError> {
        let request = TrainRequest {
            model: &tiny_model(),
            train: config,
            demonstrations: data,
            mixture: None,
            validation: Some(&self.held_out),
            start: None,
            resume,
            device: DeviceKind::Cpu,
            out: &self.shelf.path(name),
        };
        train(&request, observer)
    }

    /// Trains until the power fails after `update`.
    fn interrupt(&self, name: &str, resume: Resume, update: usize) -> Fuse {
        let mut fuse = Fuse { after: Some(update), ..Fuse::default() };
        let ended = catch_unwind(AssertUnwindSafe(|| self.train(name, resume, &mut fuse)));
        assert!(ended.is_err(), "the training of {name} was not interrupted");
        fuse
    }
}

#[test]
fn a_resumed_training_ends_with_the_bytes_of_one_that_was_never_interrupted() {
    let shop = Workshop::new();
    let summary = shop.train("whole", Resume::Never, &mut Fuse::default()).unwrap();
    let whole = contents(&shop.shelf.path("whole"));
    for (update, expected) in [(2, None), (4, None), (5, Some(4)), (8, Some(4)), (9, Some(8)), (12, Some(8))]
    {
        let name = format!("broken-{update}");
        shop.interrupt(&name, Resume::Never, update);
        assert!(!shop.shelf.path(&name).exists(), "a checkpoint appeared before its time");
        assert_eq!(shop.shelf.path(&format!("{name}.partial")).exists(), expected.is_some());
        let mut fuse = Fuse::default();
        let resumed = shop.train(&name, Resume::Always, &mut fuse).unwrap();
        assert_eq!(fuse.resumed_at, expected, "interrupted in update {update}");
        let broken = contents(&shop.shelf.path(&name));
        assert!(broken["model.safetensors"] == whole["model.safetensors"], "update {update}: other weights");
        assert_eq!(broken["config.toml"], whole["config.toml"]);
        assert_eq!(untimed(&broken["metrics.jsonl"]), untimed(&whole["metrics.jsonl"]), "update {update}");
        let d_geo =
            |summary: &TrainSummary| [summary.best, summary.validation].map(|seen| seen.unwrap().d_geo);
        assert_eq!(d_geo(&resumed), d_geo(&summary));
        assert!(!shop.shelf.path(&format!("{name}.partial")).exists(), "success leaves no state");
    }
}

/// Puts something in the way of the checkpoint once the last update is made.
struct Blocker(PathBuf);

impl TrainObserver for Blocker {
    fn on_update(&mut self, metrics: &UpdateMetrics) {
        if metrics.update == 12 {
            std::fs::create_dir(&self.0).unwrap();
        }
    }

    fn on_validation(&mut self, _: &ValidationMetrics) {}
}

#[test]
fn a_checkpoint_that_cannot_be_written_costs_no_update() {
    let shop = Workshop::new();
    shop.train("whole", Resume::Never, &mut Fuse::default()).unwrap();
    let mut blocker = Blocker(shop.shelf.path("policy.partial/new"));
    let config = &shop.config;
    let fault = shop.train_as("policy", config, &shop.data, Resume::Never, &mut blocker).unwrap_err();
    assert!(matches!(fault, TrainError::Io { .. }), "{fault}");
    assert_eq!(shop.shelf.names(), ["policy.partial", "whole"]);

    let mut fuse = Fuse::default();
    shop.train("policy", Resume::Always, &mut fuse).unwrap();
    assert_eq!(fuse.resumed_at, Some(12));
    let [policy, whole] = ["policy", "whole"].map(|name| contents(&shop.shelf.path(name)));
    assert!(policy["model.safetensors"] == whole["model.safetensors"]);
    assert_eq!(untimed(&policy["metrics.jsonl"]), untimed(&whole["metrics.jsonl"]));
}

#[test]
fn a_training_may_be_interrupted_again_and_again() {
    let shop = Workshop::new();
    shop.train("whole", Resume::Never, &mut Fuse::default()).unwrap();
    for (update, resumed_at) in [(6, None), (7, Some(4)), (8, Some(4)), (10, Some(4)), (11, Some(8))] {
        assert_eq!(shop.interrupt("broken", Resume::IfSame, update).resumed_at, resumed_at);
    }
    shop.train("broken", Resume::IfSame, &mut Fuse::default()).unwrap();
    let [whole, broken] = ["whole", "broken"].map(|name| contents(&shop.shelf.path(name)));
    assert!(whole["model.safetensors"] == broken["model.safetensors"]);
    assert_eq!(untimed(&whole["metrics.jsonl"]), untimed(&broken["metrics.jsonl"]));
    assert_eq!(shop.shelf.names(), ["broken", "whole"]);
}

#[test]
fn how_often_states_are_saved_changes_nothing() {
    let shop = Workshop::new();
    shop.train("often", Resume::Never, &mut Fuse::default()).unwrap();
    let config = TrainConfig { save_every: 0, ..shop.config.clone() };
    shop.train_as("never", &config, &shop.data, Resume::Never, &mut Fuse::default()).unwrap();
    let [often, never] = ["often", "never"].map(|name| contents(&shop.shelf.path(name)));
    assert!(often["model.safetensors"] == never["model.safetensors"]);

    shop.interrupt("other", Resume::Never, 6);
    let mut fuse = Fuse::default();
    shop.train_as("other", &config, &shop.data, Resume::Always, &mut fuse).unwrap();
    assert_eq!(fuse.resumed_at, Some(4), "a state is good however often states are saved from now on");
    assert!(contents(&shop.shelf.path("other"))["model.safetensors"] == never["model.safetensors"]);
}

#[test]
fn a_state_that_does_not_fit_is_refused_or_ignored_but_never_used() {
    let shop = Workshop::new();
    shop.interrupt("policy", Resume::Never, 6);
    let path = shop.shelf.path("policy.partial/state");
    let state = std::fs::read(&path).unwrap();
    let flipped = |at: usize| {
        let mut bytes = state.clone();
        bytes[at] ^= 1;
        bytes
    };
    let other_config = TrainConfig { learning_rate: 4e-3, ..shop.config.clone() };
    let mut other_data = shop.data.clone();
    other_data.episodes[1].observations[3].cloud.points[5][1] += 1e-3;
    let (config, data) = (&shop.config, &shop.data);
    let cases: [(&str, Vec<u8>, &TrainConfig, &Dataset, &str); 7] = [
        ("half", state[..state.len() / 2].to_vec(), config, data, "cut off"),
        ("empty", Vec::new(), config, data, "cut off"),
        ("one byte short", state[..state.len() - 1].to_vec(), config, data, "cut off"),
        ("a bit of the header", flipped(60), config, data, "damaged"),
        ("a bit of the moments", flipped(state.len() - 9), config, data, "damaged"),
        ("another configuration", state.clone(), &other_config, data, "another configuration"),
        ("other data", state.clone(), config, &other_data, "other demonstrations"),
    ];
    for (what, bytes, config, data, part) in cases {
        std::fs::write(&path, &bytes).unwrap();
        let mut fuse = Fuse::default();
        let fault = shop.train_as("policy", config, data, Resume::Always, &mut fuse).unwrap_err().to_string();
        println!("{what}: {fault}");
        assert!(fault.contains("policy.partial/state: ") && fault.contains(part), "{what}: {fault}");
        assert!(fault.lines().count() == 1, "{what}: {fault}");
        assert!(std::fs::read(&path).unwrap() == bytes, "{what}: the state was touched");
        assert_eq!(shop.shelf.names(), ["policy.partial"]);
    }

    // Ignored, it leaves no trace in the result.
    std::fs::write(&path, &state[..state.len() / 2]).unwrap();
    let mut fuse = Fuse::default();
    shop.train("policy", Resume::IfSame, &mut fuse).unwrap();
    assert!(fuse.resumed_at.is_none() && fuse.ignored.unwrap().contains("cut off"));
    shop.train("whole", Resume::Never, &mut Fuse::default()).unwrap();
    let [policy, whole] = ["policy", "whole"].map(|name| contents(&shop.shelf.path(name)));
    assert!(policy["model.safetensors"] == whole["model.safetensors"]);
}
