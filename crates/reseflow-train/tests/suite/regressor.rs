//! The deterministic regressor: the same network, loop and policy without noise and flow time.

use reseflow_data::Split;
use reseflow_flow::{HaarPrior, Prior, Solver, TimeSampling};
use reseflow_train::{AugmentConfig, ModelConfig, PairConfig, TrainConfig, make_pairs};

use crate::support::{Shelf, demonstrations, histories, mean_d_geo, tiny_model, tiny_training};

#[test]
fn a_regressor_learns_answers_the_same_to_every_seed_and_knows_neither_noise_nor_time() {
    let shelf = Shelf::new();
    let data = demonstrations(Split::Train, 2);
    let model = ModelConfig { regression: true, ..tiny_model() };
    let base = TrainConfig {
        shards: 1,
        first_window_share: 1.0,
        augment: AugmentConfig::NONE,
        weight_decay: 0.0,
        ..tiny_training(200)
    };
    let untrained = TrainConfig { updates: 1, learning_rate: 0.0, validate_every: 1, ..base.clone() };
    // The configured flow times and prior play no part.
    let timed =
        TrainConfig { time: TimeSampling { zero_share: 0.0, ..TimeSampling::default() }, ..base.clone() };
    let (wide, narrow) =
        (model.clone(), ModelConfig { prior: Prior::Haar(HaarPrior::default()), ..model.clone() });
    shelf.train_model("untrained", &wide, &untrained, &data, None).unwrap();
    shelf.train_model("trained", &wide, &base, &data, None).unwrap();
    let short = |config: &TrainConfig| TrainConfig { updates: 3, validate_every: 3, ..config.clone() };
    shelf.train_model("one", &wide, &short(&base), &data, None).unwrap();
    shelf.train_model("other", &narrow, &short(&timed), &data, None).unwrap();
    let [one, other] =
        ["one", "other"].map(|name| std::fs::read(shelf.path(name).join("model.safetensors")).unwrap());
    assert!(one == other, "flow times or the prior changed a regressor");

    let policy = shelf.policy("trained");
    let drawn = policy.predict(&histories(&data, 0), &[1, 2, 3], 1).unwrap();
    for samples in &drawn {
        assert!(samples.iter().all(|sample| *sample == samples[0]), "an answer depends on the seed");
    }
    let before =
        mean_d_geo(&shelf.policy("untrained").predict(&histories(&data, 0), &[1], 1).unwrap(), &data);
    let after = mean_d_geo(&drawn, &data);
    println!("D_geo {before:.4} to {after:.4}");
    assert!(after * 5.0 <= before, "D_geo went from {before} to {after} only");

    for solver in [Solver::Euler { steps: 2 }, Solver::Heun { steps: 1 }] {
        let fault = policy.draw(&histories(&data, 0), &[1], &solver).unwrap_err().to_string();
        assert!(fault.contains("regressor answers at once"), "{fault}");
    }
    let fault = make_pairs(&policy, &data, &PairConfig::default(), &|_| ()).unwrap_err().to_string();
    assert!(fault.contains("regressor"), "{fault}");
}
