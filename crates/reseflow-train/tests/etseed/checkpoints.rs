//! What was trained is what is loaded, and a flow's checkpoint is not the baseline's.

use reseflow_data::{Policy, Split};
use reseflow_flow::Solver;
use reseflow_train::{DeviceKind, EtSeedPolicy, FlowPolicy};

use crate::support::{Shelf, demonstrations, errors, histories, tiny_config, tiny_training};

#[test]
fn damaged_and_foreign_checkpoints_are_refused_by_name() {
    let shelf = Shelf::new();
    let data = demonstrations(Split::Train, 1);
    shelf.train("good", &tiny_config(), &tiny_training(2), &data, None).unwrap();
    assert_eq!(shelf.policy("good").model(), &tiny_config());
    let foreign = FlowPolicy::load(&shelf.path("good"), DeviceKind::Cpu).unwrap_err().to_string();
    assert!(foreign.contains("config.toml") && foreign.contains("of kind `et_seed`"), "{foreign}");

    let load = |file: &str, change: &dyn Fn(String) -> String| {
        let copy = shelf.path("copy");
        std::fs::create_dir_all(&copy).unwrap();
        for name in ["config.toml", "model.safetensors"] {
            std::fs::copy(shelf.path("good").join(name), copy.join(name)).unwrap();
        }
        if file == "config.toml" {
            let text = std::fs::read_to_string(copy.join(file)).unwrap();
            std::fs::write(copy.join(file), change(text)).unwrap();
        } else {
            let bytes = std::fs::read(copy.join(file)).unwrap();
            std::fs::write(copy.join(file), &bytes[..bytes.len() / 2]).unwrap();
        }
        EtSeedPolicy::load(&copy, DeviceKind::Cpu).unwrap_err().to_string()
    };
    let replaced = |from: &'static str, to: &'static str| {
        move |text: String| {
            assert!(text.contains(from), "no `{from}` in:\n{text}");
            text.replacen(from, to, 1)
        }
    };
    for (change, part) in [
        (replaced("\"et_seed\"", "\"flow\""), "expected `et_seed`"),
        (replaced("last_step_share", "last_step"), "last_step"),
        (replaced("steps = 100", "steps = 0"), "diffusion.steps"),
        (replaced("token_scalars = 32", "token_scalars = 16"), "model.safetensors"),
    ] {
        let fault = load("config.toml", &change);
        assert!(fault.contains(part), "expected `{part}` in: {fault}");
    }
    let fault = load("model.safetensors", &|text| text);
    assert!(fault.contains("copy/model.safetensors: "), "{fault}");
}

#[test]
fn a_reset_replays_the_plans_of_an_episode_and_each_plan_has_its_own_noise() {
    let shelf = Shelf::new();
    let data = demonstrations(Split::Train, 1);
    shelf.train("policy", &tiny_config(), &tiny_training(5), &data, None).unwrap();
    let mut policy = shelf.policy("policy");
    policy.set_solver(Solver::Euler { steps: 3 });
    let seen = histories(&data, 0).remove(0);
    let mut plans = |seed: u64| {
        policy.reset(seed);
        [(); 3].map(|()| policy.plan(&seen).unwrap())
    };
    let first = plans(7);
    assert_eq!(plans(7), first);
    assert_ne!(plans(8)[0], first[0]);
    assert!(first[0] != first[1] && first[1] != first[2], "plans of one episode share their noise");
    assert_eq!((first[0].actions.len(), &first[0].uncertainty), (10, &None));
}

#[test]
fn a_policy_predicts_the_same_alone_and_among_others_for_the_same_stream() {
    let shelf = Shelf::new();
    let data = demonstrations(Split::Train, 3);
    shelf.train("policy", &tiny_config(), &tiny_training(5), &data, None).unwrap();
    let policy = shelf.policy("policy");
    let seen = histories(&data, 3);
    let together = policy.predict(&seen, &[1, 2], 10).unwrap();
    assert_eq!(together.iter().map(Vec::len).collect::<Vec<_>>(), [2, 2, 2]);
    assert_ne!(together[0][0], together[0][1], "seeds differ");
    let alone = policy.predict(&seen[..1], &[2], 10).unwrap();
    let worst = errors(&alone[0][0].consensus, &together[0][1].consensus).into_iter().fold(0.0, f64::max);
    assert!(worst < 1e-5, "a neighbour in the batch changed a prediction by {worst}");
    assert!(policy.predict(&[], &[1], 1).unwrap().is_empty());
    for (steps, part) in [(0, "at least 1 step"), (101, "got 101")] {
        let fault = policy.predict(&seen, &[1], steps).unwrap_err().to_string();
        assert!(fault.contains(part), "{fault}");
    }
    let mut broken = data.episodes[0].observations[0].clone();
    broken.world_from_gripper.translation.x = f64::NAN;
    let history = reseflow_data::ObservationHistory::new(broken, 2);
    assert!(policy.predict(&[history], &[1], 2).unwrap_err().to_string().contains("finite"));
    let single = reseflow_data::ObservationHistory::new(data.episodes[0].observations[0].clone(), 1);
    assert!(policy.predict(&[single], &[1], 2).unwrap_err().to_string().contains("expected 2, got 1"));
}
