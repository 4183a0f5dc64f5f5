//! Training scenes turned at random: to an equivariant network they say nothing new, to one that sees any of the world's axes they are other
//! scenes.

use reseflow_data::{Dataset, FlowPair, ObservationHistory, Split, Window, WindowPairs};
use reseflow_flow::{PriorFrame, TimeSampling};
use reseflow_net::Symmetry;
use reseflow_train::{
    AugmentConfig, DeviceKind, Mixture, MixtureConfig, ModelConfig, Resume, TrainConfig, TrainRequest, train,
};

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use crate::support::{Journal, Shelf, demonstrations, histories, tiny_model, tiny_training};

/// One window a batch, always the first of the only episode, and weights that stay as they were drawn: what is left to chance is
/// the scene's turn.
fn training(scene_rotation: bool) -> TrainConfig {
    TrainConfig {
        batch_size: 1,
        shards: 1,
        first_window_share: 1.0,
        learning_rate: 0.0,
        time: TimeSampling { zero_share: 1.0, ..TimeSampling::default() },
        augment: AugmentConfig { scene_rotation, ..AugmentConfig::NONE },
        ..tiny_training(8)
    }
}

/// The losses of a training on one scene, each update with another turn of it.
fn losses(
    model: &ModelConfig,
    scene_rotation: bool,
    data: &Dataset,
    pairs: Option<&[WindowPairs]>,
) -> Vec<f64> {
    let (shelf, mut journal) = (Shelf::new(), Journal::default());
    let horizon = model.network.decoder.horizon;
    let mixed = MixtureConfig { pair_share: 1.0, ..MixtureConfig::default() };
    let mixture = pairs.map(|pairs| Mixture::new(mixed, pairs, data, horizon).unwrap());
    let request = TrainRequest {
        model,
        train: &training(scene_rotation),
        demonstrations: data,
        mixture: mixture.as_ref(),
        validation: None,
        start: None,
        resume: Resume::Never,
        device: DeviceKind::Cpu,
        out: &shelf.path("policy"),
    };
    train(&request, &mut journal).unwrap();
    journal.updates.iter().map(|update| update.loss).collect()
}

/// One pair of noise and image for the window that is drawn.
fn pair(history: &ObservationHistory, model: &ModelConfig) -> Vec<WindowPairs> {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let frame = PriorFrame::of(history.latest());
    let mut draw = || model.prior.sample(&frame, model.network.decoder.horizon, &mut rng);
    let pairs = vec![FlowPair { noise: draw(), image: draw() }];
    vec![WindowPairs { window: Window { episode: 0, step: 0 }, pairs }]
}

/// The regressor starts out from the gripper and its targets are the demonstration; of a flow's pair both ends were recorded.
#[test]
fn a_turned_scene_has_the_same_loss_for_an_equivariant_network_and_another_for_one_that_sees_axes() {
    let data = demonstrations(Split::Train, 1);
    let pairs = pair(&histories(&data, 0)[0], &tiny_model());
    for regression in [true, false] {
        let pairs = (!regression).then_some(pairs.as_slice());
        for symmetry in [Symmetry::SE3, Symmetry::Upright, Symmetry::None] {
            let mut model = ModelConfig { regression, ..tiny_model() };
            model.network.symmetry = symmetry;
            let still = losses(&model, false, &data, pairs);
            assert!(
                still.iter().all(|loss| *loss == still[0]),
                "something else is left to chance: {still:?}"
            );
            let turned = losses(&model, true, &data, pairs);
            let off = turned.iter().map(|loss| (loss / still[0] - 1.0).abs());
            let (least, most) =
                off.fold((f64::INFINITY, 0.0_f64), |(least, most), off| (least.min(off), most.max(off)));
            println!(
                "{symmetry:?}, regression {regression}: loss {}, turned off by {least:.1e} to {most:.1e}",
                still[0]
            );
            match symmetry {
                Symmetry::SE3 => assert!(most < 1e-4, "{most}"),
                Symmetry::Upright | Symmetry::None => {
                    assert!(least > 1e-4 && most > 1e-2, "{least} to {most}")
                }
            }
        }
    }
}
