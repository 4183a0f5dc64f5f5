//! Flows whose network predicts velocities: trained, loaded, integrated, made pairs of, and refused where they make no sense.

use reseflow_data::{Dataset, Split};
use reseflow_flow::{ObjectiveConfig, Path, PoseError, Solver, TimeSampling};
use reseflow_lie::geodesic_distance;
use reseflow_net::Parameterisation;
use reseflow_train::{
    AugmentConfig, ModelConfig, PairConfig, PolicySample, TrainConfig, TrainError, make_pairs,
};

use crate::equivariance::{SEEDS, errors};
use crate::support::{Shelf, contents, demonstrations, histories, mean_d_geo, tiny_model, tiny_training};

fn in_twist_form(path: Path) -> ModelConfig {
    let mut model = ModelConfig { path, ..tiny_model() };
    model.network.decoder.parameterisation = Parameterisation::Twist;
    model
}

fn training(updates: usize) -> TrainConfig {
    let objective = ObjectiveConfig { error: PoseError::Twist, ..ObjectiveConfig::default() };
    TrainConfig { objective, warmup: 5, ..tiny_training(updates) }
}

/// The mean error of the openings in the first episode.
fn opening_error(samples: &[PolicySample], data: &Dataset) -> f64 {
    let off = samples.iter().flat_map(|sample| {
        let wanted = &data.episodes[0].actions;
        sample.consensus.iter().zip(wanted).map(|(got, wanted)| (got.opening - wanted.opening).abs())
    });
    off.sum::<f64>() / (samples.len() * data.episodes[0].actions.len()) as f64
}

#[test]
fn velocities_of_one_demonstration_are_learned_by_heart_and_kept_in_the_checkpoint() {
    let (shelf, data) = (Shelf::new(), demonstrations(Split::Train, 1));
    let mut model = in_twist_form(Path::Screw);
    let decoder = &mut model.network.decoder;
    (decoder.layers, decoder.token_scalars, decoder.token_vectors) = (2, 32, 16);
    let base = TrainConfig {
        learning_rate: 1e-2,
        shards: 1,
        first_window_share: 1.0,
        augment: AugmentConfig::NONE,
        weight_decay: 0.0,
        time: TimeSampling { zero_share: 0.3, ..TimeSampling::default() },
        ..training(300)
    };
    let untrained = TrainConfig { updates: 1, learning_rate: 0.0, validate_every: 1, ..base.clone() };
    shelf.train_model("untrained", &model, &untrained, &data, None).unwrap();
    let (summary, _) = shelf.train_model("trained", &model, &base, &data, Some(&data)).unwrap();
    let seen = histories(&data, 0);
    let loaded = shelf.policy("trained").predict(&seen, &[3407], 1).unwrap();
    assert_eq!(mean_d_geo(&loaded, &data), summary.validation.unwrap().d_geo, "what was trained is loaded");

    let seeds: Vec<u64> = (0..10).collect();
    for solver in [Solver::Euler { steps: 1 }, Solver::Heun { steps: 5 }] {
        let draw = |name: &str| shelf.policy(name).draw(&seen, &seeds, &solver).unwrap().samples;
        let (before, after) = (draw("untrained"), draw("trained"));
        let [before_d_geo, after_d_geo] = [&before, &after].map(|drawn| mean_d_geo(drawn, &data));
        let [before_opening, after_opening] = [&before, &after].map(|drawn| opening_error(&drawn[0], &data));
        println!(
            "{}: D_geo {before_d_geo:.4} to {after_d_geo:.4}, opening {before_opening:.3} to {after_opening:.3}",
            solver.name()
        );
        assert!(after_d_geo * 5.0 <= before_d_geo, "D_geo went from {before_d_geo} to {after_d_geo} only");
        assert!(
            after_opening * 2.0 <= before_opening,
            "openings went from {before_opening} to {after_opening} only"
        );
    }
    let drawn = shelf.policy("trained").predict(&seen, &seeds, 5).unwrap();
    for sample in drawn.iter().flatten() {
        assert!(sample.nodes.is_empty(), "nodes say velocities, no trajectories");
        assert_eq!(sample.spread.len(), 10);
        assert!(sample.spread.iter().all(|spread| spread.is_finite() && *spread > 0.0));
    }
}

#[test]
fn a_moved_scene_gives_the_moved_trajectory_of_integrated_velocities() {
    let (data, held_out) = (demonstrations(Split::Train, 4), demonstrations(Split::Validation, 4));
    let seen = histories(&held_out, 0);
    for (name, path) in [("screw", Path::Screw), ("product", Path::Product)] {
        let shelf = Shelf::new();
        let (_, journal) = shelf.train_model(name, &in_twist_form(path), &training(80), &data, None).unwrap();
        let losses: Vec<f64> = journal.updates.iter().map(|update| update.loss).collect();
        let mean = |losses: &[f64]| losses.iter().sum::<f64>() / losses.len() as f64;
        let (first, last) = (mean(&losses[..5]), mean(&losses[70..]));
        let policy = shelf.policy(name);
        let together = errors(&policy, &seen, 3, true);
        let typical = together[together.len() * 99 / 100];
        // The control: velocities in the frame of a gripper that stays behind must not give the moved trajectory.
        let left_behind = errors(&policy, &seen, 3, false);
        let median = left_behind[left_behind.len() / 2];
        println!("{name}: loss {first:.3} to {last:.3}, moved {typical:.1e}, left behind {median:.1e}");
        assert!(last < 0.7 * first, "{name}: the loss went from {first} to {last} only");
        assert!(typical < 1e-4, "{name}: {typical}");
        assert!(median > 1e-2, "{name}: moving the cloud alone changes too little: {median}");
    }
}

#[test]
fn pairs_and_straightness_follow_the_velocities() {
    let (shelf, data) = (Shelf::new(), demonstrations(Split::Train, 2));
    shelf.train_model("flow", &in_twist_form(Path::Screw), &training(30), &data, None).unwrap();
    let policy = shelf.policy("flow");
    let solver = Solver::Euler { steps: 4 };
    let config = PairConfig { windows: 1, noises: 1, solver, seed: 6 };
    let pairs = make_pairs(&policy, &data, &config, &|_| ()).unwrap();
    // Stream 2n + 1 is window n's: so many histories in, the policy draws from the same noise.
    let first = histories(&data, 0);
    let spread: Vec<_> = first.iter().flat_map(|history| [history.clone(), history.clone()]).collect();
    let drawn = policy.draw(&spread, &[6], &solver).unwrap();
    assert_eq!((drawn.steps, drawn.evaluations), (4, 4));
    for (n, of) in pairs.iter().enumerate() {
        let image = of.pairs[0].image.iter();
        let off = image.zip(drawn.samples[2 * n + 1][0].consensus.iter()).map(|(one, other)| {
            geodesic_distance(&one.world_from_gripper, &other.world_from_gripper).d_geo()
        });
        assert!(off.fold(0.0, f64::max) < 1e-4, "the image of window {n} is not where the policy ends");
    }
    let measured = policy.straightness(&first, SEEDS[0], 10).unwrap();
    assert!(measured.absolute > 0.0 && measured.relative.is_finite(), "{measured:?}");
}

#[test]
fn an_objective_of_clean_poses_and_a_regressor_of_velocities_are_refused_with_the_reason() {
    let (shelf, data) = (Shelf::new(), demonstrations(Split::Train, 1));
    let model = in_twist_form(Path::Screw);
    let refused = |model: &ModelConfig, train: &TrainConfig, parts: &[&str]| {
        let fault = shelf.train_model("policy", model, train, &data, None).unwrap_err();
        assert!(matches!(fault, TrainError::Config(_)), "{fault:?}");
        let fault = fault.to_string();
        for part in parts.iter().chain(&["model.network.decoder.parameterisation"]) {
            assert!(fault.contains(part), "`{part}` is not in: {fault}");
        }
    };
    let chordal = tiny_training(2);
    refused(&model, &chordal, &["train.objective.error = \"chordal\"", "predicts none", "\"twist\""]);
    let regressor = ModelConfig { regression: true, ..model };
    refused(&regressor, &training(2), &["model.regression = true", "velocities only"]);
    assert!(shelf.names().is_empty(), "something was written");
    // Clean poses can be judged either way.
    shelf.train("policy", &training(2), &data, None).unwrap();
    let config = String::from_utf8(contents(&shelf.path("policy"))["config.toml"].clone()).unwrap();
    assert!(config.contains("error = \"twist\"") && !config.contains("parameterisation"), "{config}");
}
