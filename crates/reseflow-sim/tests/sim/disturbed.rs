//! Disturbed demonstrations: the expert begins anew, and windows begin where it does.

use reseflow_data::Split;
use reseflow_sim::{GenerateRequest, Generated, SimError, generate, task};

const EPISODES: usize = 12;

fn made(name: &str, disturbed_share: f64) -> Result<Generated, SimError> {
    let request = GenerateRequest { disturbed_share, ..GenerateRequest::new(Split::Train, 6, EPISODES) };
    generate(task(name).unwrap().as_ref(), &request, &|| ())
}

#[test]
fn an_expert_whose_scene_is_disturbed_does_something_else_from_then_on() {
    for name in ["door", "painting", "triangle"] {
        let (calm, disturbed) = (made(name, 0.0).unwrap(), made(name, 1.0).unwrap());
        let wanted = task(name).unwrap().spec().disturb_before;
        let mut differing = 0;
        for (index, (calm, disturbed)) in calm.episodes.iter().zip(&disturbed.episodes).enumerate() {
            assert_eq!(calm.disturbance, None);
            let disturbance = disturbed.disturbance.unwrap();
            assert_eq!(disturbance.before, wanted, "{name} {index}");
            let after = disturbance.answered_from.checked_sub(disturbance.before);
            assert!(after.is_some_and(|steps| (1..=3).contains(&steps)), "{name} {index}: {disturbance:?}");
            assert_eq!(disturbed.first_step(), disturbance.answered_from);
            // A key of which an attempt was dropped names another scene.
            if calm.observations[0] != disturbed.observations[0] {
                continue;
            }
            let shown = disturbance.answered_from;
            assert_eq!(calm.actions[..shown], disturbed.actions[..shown], "{name} {index}: before it");
            assert_ne!(calm.actions[shown], disturbed.actions[shown], "{name} {index}: from it on");
            differing += 1;
        }
        assert!(2 * differing > EPISODES, "{name}: {differing} scenes compared");
    }
}

#[test]
fn a_share_of_the_episodes_is_disturbed_and_the_others_are_as_they_were() {
    let (calm, some) = (made("triangle", 0.0).unwrap(), made("triangle", 0.5).unwrap());
    let disturbed = some.episodes.iter().filter(|episode| episode.disturbance.is_some()).count();
    assert!((2..=10).contains(&disturbed), "{disturbed} of {EPISODES}");
    for (calm, episode) in calm.episodes.iter().zip(&some.episodes) {
        assert!(episode.disturbance.is_some() || calm == episode);
    }
}

#[test]
fn what_cannot_be_disturbed_is_refused() {
    for share in [-0.1, 1.1, f64::NAN] {
        assert!(matches!(made("door", share), Err(SimError::Setting { key: "disturbed_share", .. })));
    }
    let fault = made("coin_toss", 0.5).unwrap_err().to_string();
    assert!(fault.contains("expected 0 for coin_toss"), "{fault}");
}
