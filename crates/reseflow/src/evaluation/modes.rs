//! Whether samples keep to one of two modes: for data sets that hold, beside each episode's expert, another one as good.

use reseflow_data::{Action, ActionChunk, Dataset, Episode};
use reseflow_lie::geodesic_distance;
use reseflow_train::PolicySample;
use serde::{Deserialize, Serialize};

use crate::metrics::mean;

/// How samples lie about two experts' trajectories.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ModeScores {
    /// The share of samples whose nearer expert turns further counter-clockwise about the gripper's approach axis, and of the others.
    pub share_per_mode: [f64; 2],
    /// The share of the rarer mode within a scene, mean over scenes: 0 where every scene has one answer only.
    pub rarer_share_within_scene: f64,
    /// The share of samples that are further than `between_d_geo` from both experts.
    pub share_between: f64,
    /// Three times D̄_geo of a policy for a task with one mode.
    pub between_d_geo: f64,
    /// D̄_geo to the nearer expert.
    pub d_geo_nearer: f64,
    /// D̄_geo between both experts.
    pub d_geo_apart: f64,
    /// 2 E d(X, Y) − E d(X, X′) − E d(Y, Y′) with d = D̄_geo, X the samples of a scene and Y either expert; mean over scenes.
    pub energy_distance: Option<f64>,
}

/// Scores the samples `[episode][seed]`, given D̄_geo of a policy for a task with one mode; `None` where the data set has one expert only.
pub(super) fn score_modes(
    samples: &[Vec<PolicySample>],
    dataset: &Dataset,
    unimodal_d_geo: f64,
) -> Option<ModeScores> {
    let scenes: Option<Vec<Scene>> =
        samples.iter().zip(&dataset.episodes).map(|(drawn, episode)| Scene::new(drawn, episode)).collect();
    let scenes = scenes?;
    let over_samples = |value: &dyn Fn(&Scene, &[f64; 2]) -> f64| {
        let of_scene = |scene: &Scene| {
            let values: Vec<f64> = scene.distances.iter().map(|distances| value(scene, distances)).collect();
            mean(&values)
        };
        mean(&scenes.iter().filter_map(of_scene).collect::<Vec<_>>())
    };
    let over_scenes =
        |value: &dyn Fn(&Scene) -> Option<f64>| mean(&scenes.iter().filter_map(value).collect::<Vec<_>>());
    let between_d_geo = 3.0 * unimodal_d_geo;
    let first = over_samples(&|_, [to_first, to_second]| f64::from(u8::from(to_first <= to_second)))?;
    Some(ModeScores {
        share_per_mode: [first, 1.0 - first],
        rarer_share_within_scene: over_scenes(&Scene::rarer_share)?,
        share_between: over_samples(&|_, [a, b]| f64::from(u8::from(a.min(*b) > between_d_geo)))?,
        between_d_geo,
        d_geo_nearer: over_samples(&|_, [a, b]| a.min(*b))?,
        d_geo_apart: over_scenes(&|scene| Some(scene.apart))?,
        energy_distance: over_scenes(&Scene::energy_distance),
    })
}

/// The samples of one episode, each with its distance to both experts; the first one turns further counter-clockwise.
struct Scene {
    distances: Vec<[f64; 2]>,
    apart: f64,
    /// The mean distance of two different samples, where there are two.
    among: Option<f64>,
}

impl Scene {
    fn new(drawn: &[PolicySample], episode: &Episode) -> Option<Self> {
        let other = episode.alternative.as_ref()?.iter().zip(&episode.actions);
        let other: Vec<Action> = other
            .map(|(pose, action)| Action { world_from_gripper: *pose, opening: action.opening })
            .collect();
        let mut experts = [episode.actions.as_slice(), other.as_slice()];
        if turn_rad(experts[0]) < turn_rad(experts[1]) {
            experts.reverse();
        }
        let to = |sample: &PolicySample, expert: &[Action]| distance(&sample.consensus.0, expert);
        let distances = drawn.iter().map(|sample| [to(sample, experts[0]), to(sample, experts[1])]).collect();
        let mut among = Vec::new();
        for (index, one) in drawn.iter().enumerate() {
            let ActionChunk(one) = &one.consensus;
            among.extend(drawn[..index].iter().map(|other| distance(one, &other.consensus.0)));
        }
        Some(Self { distances, apart: distance(experts[0], experts[1]), among: mean(&among) })
    }

    fn rarer_share(&self) -> Option<f64> {
        let first = self.distances.iter().map(|[a, b]| f64::from(u8::from(a <= b)));
        mean(&first.collect::<Vec<_>>()).map(|share| share.min(1.0 - share))
    }

    fn energy_distance(&self) -> Option<f64> {
        let across = mean(self.distances.as_flattened())?;
        Some(2.0 * across - self.among? - 0.5 * self.apart)
    }
}

/// D̄_geo over the actions that both have.
fn distance(one: &[Action], other: &[Action]) -> f64 {
    let apart =
        |(a, b): (&Action, &Action)| geodesic_distance(&a.world_from_gripper, &b.world_from_gripper).d_geo();
    mean(&one.iter().zip(other).map(apart).collect::<Vec<_>>()).unwrap_or_default()
}

/// How far a trajectory turns about its first pose's approach axis, pointing away from the object.
fn turn_rad(actions: &[Action]) -> f64 {
    let (Some(first), Some(last)) = (actions.first(), actions.last()) else { return 0.0 };
    let turn = first.world_from_gripper.rotation.inverse() * last.world_from_gripper.rotation;
    -turn.log().z
}

#[cfg(test)]
mod tests {
    use super::*;
    use reseflow_lie::{SE3, SO3, Vector3};

    /// A trajectory that turns about the approach axis up to `rad`, seen from behind the gripper.
    fn turning(rad: f64) -> Vec<Action> {
        let pose = |rad: f64| SE3::new(SO3::exp(&(Vector3::z() * -rad)), Vector3::zeros());
        [0.0, rad].map(|rad| Action { world_from_gripper: pose(rad), opening: 0.0 }).to_vec()
    }

    fn sample(rad: f64) -> PolicySample {
        PolicySample { consensus: ActionChunk(turning(rad)), nodes: Vec::new(), spread: Vec::new() }
    }

    /// Two scenes in which the experts turn by ± 1; their own one, and so the other one, to different sides.
    fn dataset() -> Dataset {
        let episode = |own: f64| Episode {
            observations: Vec::new(),
            actions: turning(own),
            alternative: Some(turning(-own).iter().map(|action| action.world_from_gripper).collect()),
            disturbance: None,
        };
        Dataset { episodes: vec![episode(1.0), episode(-1.0)], meta: None }
    }

    fn scores(drawn: [&[f64]; 2]) -> ModeScores {
        let samples = drawn.map(|rads| rads.iter().map(|&rad| sample(rad)).collect::<Vec<_>>());
        score_modes(&samples, &dataset(), 0.035).unwrap()
    }

    #[test]
    fn a_policy_that_tosses_the_same_coin_is_perfect() {
        let scores = scores([&[1.0, -1.0], &[-1.0, 1.0]]);
        assert_eq!((scores.share_per_mode, scores.rarer_share_within_scene), ([0.5, 0.5], 0.5));
        assert_eq!((scores.share_between, scores.d_geo_nearer), (0.0, 0.0));
        assert!((scores.d_geo_apart - 1.0).abs() < 1e-12, "half of the actions are 2 rad apart");
        // 2 · ½ − 1 − ½: two samples that differ repel more than independent ones do on average.
        assert!((scores.energy_distance.unwrap() + 0.5).abs() < 1e-12);
    }

    #[test]
    fn a_policy_that_turns_to_one_side_only_is_seen_though_episodes_alternate() {
        let scores = scores([&[1.0, 1.0], &[1.0, 1.0]]);
        assert_eq!((scores.share_per_mode, scores.rarer_share_within_scene), ([1.0, 0.0], 0.0));
        assert!((scores.energy_distance.unwrap() - 0.5).abs() < 1e-12, "2 · ½ − 0 − ½");
    }

    #[test]
    fn samples_in_the_middle_are_between() {
        let scores = scores([&[0.0, 0.1], &[-0.05, 1.1]]);
        assert_eq!(scores.share_between, 0.75, "all but the last one, which is 0.05 off");
        let samples = [[0.0, 0.1], [-0.05, 1.1]].map(|rads| rads.map(sample).to_vec());
        let strict = score_modes(&samples, &dataset(), 0.01).unwrap();
        assert_eq!((strict.share_between, strict.between_d_geo), (1.0, 0.03), "0.05 is more than 3 · 0.01");
        assert!((scores.d_geo_nearer - (0.5 + 0.45 + 0.475 + 0.05) / 4.0).abs() < 1e-12);
    }

    #[test]
    fn one_expert_has_no_modes() {
        let mut dataset = dataset();
        dataset.episodes[1].alternative = None;
        assert_eq!(score_modes(&[vec![sample(0.0)], vec![sample(0.0)]], &dataset, 0.035), None);
    }
}
