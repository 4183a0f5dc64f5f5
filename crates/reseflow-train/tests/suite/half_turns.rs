//! Policies of grippers whose fingers are alike: what they draw begins with the nearer half-turn, if they are asked for it.

use std::f64::consts::PI;

use reseflow_data::{ActionChunk, Split};
use reseflow_flow::{HaarPrior, ObjectiveConfig, PoseError, Prior};
use reseflow_lie::{SE3, SO3, Vector3, geodesic_distance};
use reseflow_net::Parameterisation;
use reseflow_train::{ModelConfig, PolicySample, TrainConfig};

use crate::support::{Shelf, demonstrations, histories, tiny_model, tiny_training};

fn first(chunk: &ActionChunk) -> SE3 {
    chunk.0[0].world_from_gripper
}

/// One step of a velocity that was never learned leaves noise where it is, and that is turned anyhow.
#[test]
fn a_policy_that_is_asked_to_draws_the_nearer_half_turn_and_otherwise_the_same() {
    let (shelf, data) = (Shelf::new(), demonstrations(Split::Train, 1));
    let objective = ObjectiveConfig { error: PoseError::Twist, ..ObjectiveConfig::default() };
    let train = TrainConfig { objective, learning_rate: 0.0, ..tiny_training(1) };
    let mut model = ModelConfig { prior: Prior::Haar(HaarPrior::default()), ..tiny_model() };
    model.network.decoder.parameterisation = Parameterisation::Twist;
    shelf.train_model("any", &model, &train, &data, None).unwrap();
    model.network.decoder.nearest_half_turn = true;
    shelf.train_model("nearer", &model, &train, &data, None).unwrap();

    let (seen, seeds) = (histories(&data, 0), (0..60).collect::<Vec<u64>>());
    let drawn = |name: &str| shelf.policy(name).predict(&seen, &seeds, 1).unwrap().remove(0);
    let half_turn = SE3::new(SO3::exp(&(Vector3::z() * PI)), Vector3::zeros());
    let gripper = seen[0].latest().world_from_gripper;
    let mut turned = 0;
    for (any, nearer) in drawn("any").iter().zip(&drawn("nearer")) {
        let closing = |pose: &SE3| pose.rotation.act(&Vector3::y());
        let is_turned = closing(&gripper).dot(&closing(&first(&any.consensus))) < 0.0;
        let poses = |sample: &PolicySample| -> Vec<SE3> {
            let chunks = std::iter::once(&sample.consensus).chain(&sample.nodes);
            chunks.flat_map(|chunk| chunk.iter().map(|action| action.world_from_gripper)).collect()
        };
        for (before, after) in poses(any).iter().zip(poses(nearer)) {
            let expected = if is_turned { *before * half_turn } else { *before };
            assert!(geodesic_distance(&expected, &after).d_geo() < 1e-9);
        }
        turned += usize::from(is_turned);
    }
    assert!((15..45).contains(&turned), "{turned} of 60 were turned");
}
