//! Reflow as its users see it: pairs of a trained flow, and a flow that learns from pairs.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use reseflow_data::{ActionChunk, Dataset, FlowPair, ObservationHistory, Split, Window, WindowPairs};
use reseflow_flow::{PriorFrame, Solver, TimeSampling};
use reseflow_lie::geodesic_distance;
use reseflow_train::{
    AugmentConfig, DeviceKind, Mixture, MixtureConfig, PairConfig, Resume, TrainConfig, TrainRequest,
    make_pairs, train,
};

use crate::support::{Journal, Shelf, demonstrations, histories, tiny_model, tiny_training};

const STEPS: usize = 4;

fn distance(one: &ActionChunk, other: &ActionChunk) -> f64 {
    let poses = one.iter().zip(other.iter());
    let apart = poses.map(|(a, b)| geodesic_distance(&a.world_from_gripper, &b.world_from_gripper).d_geo());
    apart.sum::<f64>() / one.len() as f64
}

fn noise(history: &ObservationHistory, seed: u64, stream: u64) -> ActionChunk {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(stream);
    let model = tiny_model();
    model.prior.sample(&PriorFrame::of(history.latest()), model.network.decoder.horizon, &mut rng)
}

#[test]
fn pairs_end_where_the_policy_carries_the_same_noise() {
    let (shelf, data) = (Shelf::new(), demonstrations(Split::Train, 2));
    shelf.train("policy", &tiny_training(20), &data, None).unwrap();
    let policy = shelf.policy("policy");
    let config = PairConfig { windows: 1, noises: 2, solver: Solver::Euler { steps: STEPS }, seed: 6 };
    let pairs = make_pairs(&policy, &data, &config, &|_| {}).unwrap();
    assert_eq!(pairs.len(), 2);

    // Window n has the noise stream 2n + 1, and a policy draws the noise of its history i from stream i.
    let first = histories(&data, 0);
    let spread: Vec<_> = first.iter().flat_map(|history| [history.clone(), history.clone()]).collect();
    let drawn = policy.predict(&spread, &[6], STEPS).unwrap();
    for (n, of) in pairs.iter().enumerate() {
        assert_eq!((of.window, of.pairs.len()), (Window { episode: n, step: 0 }, 2));
        assert_eq!(of.pairs[0].noise, noise(&first[n], 6, 2 * n as u64 + 1));
        let off = distance(&of.pairs[0].image, &drawn[2 * n + 1][0].consensus);
        assert!(off < 1e-4, "the image is {off} from where the policy ends");
        assert!(distance(&of.pairs[1].image, &of.pairs[0].image) > 1e-3, "another noise, the same image");
    }
    assert_eq!(make_pairs(&policy, &data, &config, &|_| {}).unwrap(), pairs);
    let all = make_pairs(&policy, &data, &PairConfig { windows: 99, noises: 1, ..config }, &|_| {}).unwrap();
    assert_eq!(all.len(), 2 * data.steps());
    // Also half-way, where the policy is told of earlier frames and of where the gripper took hold.
    let seen = all.iter().flat_map(|WindowPairs { window, .. }| {
        let recorded = &data.episodes[window.episode].observations;
        let history = ObservationHistory::at_step(recorded, window.step, 2);
        [history.clone(), history]
    });
    let drawn = policy.predict(&seen.collect::<Vec<_>>(), &[6], STEPS).unwrap();
    for (n, of) in all.iter().enumerate() {
        let off = distance(&of.pairs[0].image, &drawn[2 * n + 1][0].consensus);
        assert!(off < 1e-4, "{:?}: the image is {off} from where the policy ends", of.window);
    }
}

/// Pairs of a flow that goes half the way to the demonstration, in a line.
fn half_way(data: &Dataset, noises: u64) -> Vec<WindowPairs> {
    let of = |(episode, history): (usize, &ObservationHistory)| {
        let pair = |seed: u64| {
            let noise = noise(history, 1000 + seed, episode as u64);
            let image = half_of(&noise, data, episode);
            FlowPair { noise, image }
        };
        WindowPairs { window: Window { episode, step: 0 }, pairs: (0..noises).map(pair).collect() }
    };
    histories(data, 0).iter().enumerate().map(of).collect()
}

fn half_of(noise: &ActionChunk, data: &Dataset, episode: usize) -> ActionChunk {
    tiny_model().path.at(noise, &ActionChunk(data.episodes[episode].actions.clone()), 0.5).unwrap()
}

#[test]
fn pairs_alone_teach_the_straight_flow_that_they_come_from() {
    let (shelf, data, model) = (Shelf::new(), demonstrations(Split::Train, 2), tiny_model());
    shelf.train("flow-1", &tiny_training(100), &data, None).unwrap();
    let pairs = half_way(&data, 64);
    let config = MixtureConfig { pair_share: 1.0, ..MixtureConfig::default() };
    let mixture = Mixture::new(config, &pairs, &data, model.network.decoder.horizon).unwrap();
    let training = TrainConfig {
        augment: AugmentConfig::NONE,
        time: TimeSampling { zero_share: 0.5, ..TimeSampling::default() },
        ..tiny_training(400)
    };
    let (start, out) = (shelf.path("flow-1"), shelf.path("flow-2"));
    let request = TrainRequest {
        model: &model,
        train: &training,
        demonstrations: &data,
        mixture: Some(&mixture),
        validation: None,
        start: Some(&start),
        resume: Resume::Never,
        device: DeviceKind::Cpu,
        out: &out,
    };
    train(&request, &mut Journal::default()).unwrap();

    // Noise that is in no pair.
    let seeds: Vec<u64> = (0..10).collect();
    let first = histories(&data, 0);
    let error = |name: &str| {
        let drawn = shelf.policy(name).predict(&first, &seeds, 1).unwrap();
        let mut sum = 0.0;
        for (episode, samples) in drawn.iter().enumerate() {
            for (&seed, sample) in seeds.iter().zip(samples) {
                let wanted = half_of(&noise(&first[episode], seed, episode as u64), &data, episode);
                sum += distance(&sample.consensus, &wanted);
            }
        }
        sum / (seeds.len() * drawn.len()) as f64
    };
    let (before, after) = (error("flow-1"), error("flow-2"));
    println!("distance to the straight flow's end: {before:.4} for Flow 1, {after:.4} for Flow 2");
    assert!(after * 2.0 < before, "from {before} to {after} only");
}
