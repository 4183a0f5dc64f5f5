//! What a set of predictions scores: K noise seeds × E episodes of trajectory errors, boiled down as the paper does it.

use serde::{Deserialize, Serialize};

use super::{TrajectoryError, bootstrap_mean_interval, mean, std_ddof1};

/// The aggregated errors of one predictor.
///
/// "Over seeds" means the standard deviation (n − 1) of the K per-seed means, as in the paper; it is `null` for one seed. "Over
/// episodes" means that of the E per-episode means.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Scores {
    /// D̄_geo: mean over actions, episodes and seeds.
    pub d_geo_mean: f64,
    /// Its standard deviation over seeds.
    pub d_geo_std: Option<f64>,
    /// Its standard deviation over episodes.
    pub d_geo_episode_std: Option<f64>,
    /// The lower end of its 95 % bootstrap interval over episodes.
    pub d_geo_low: Option<f64>,
    /// The upper end.
    pub d_geo_high: Option<f64>,
    /// D̄_geo up to the gripper's half-turn symmetry.
    pub d_geo_half_turn_mean: f64,
    /// Mean rotation error, radian.
    pub rotation_rad: f64,
    /// Mean translation error, metre.
    pub translation_m: f64,
    /// Mean error of the gripper's opening, of 1.
    pub opening_error: f64,
    /// Mean D_geo of each of the L actions.
    pub per_action_mean: Vec<f64>,
    /// The standard deviation of each over seeds.
    pub per_action_std: Vec<Option<f64>>,
    /// D̄_geo of each seed.
    pub per_seed: Vec<f64>,
    /// D̄_geo of each episode, mean over seeds.
    pub per_episode: Vec<f64>,
}

impl Scores {
    /// Aggregates `errors[seed][episode]`; `None` when there is no error at all.
    pub fn aggregate(errors: &[Vec<TrajectoryError>]) -> Option<Self> {
        let all: Vec<&TrajectoryError> = errors.iter().flatten().collect();
        let over_all =
            |value: &dyn Fn(&TrajectoryError) -> f64| mean(&all.iter().map(|e| value(e)).collect::<Vec<_>>());
        let d_geo =
            |errors: &[TrajectoryError]| mean(&errors.iter().map(TrajectoryError::d_geo).collect::<Vec<_>>());

        let per_seed: Vec<f64> = errors.iter().filter_map(|of_seed| d_geo(of_seed)).collect();
        let episodes = errors.iter().map(Vec::len).min()?;
        let of_episode =
            |e: usize| mean(&errors.iter().map(|of_seed| of_seed[e].d_geo()).collect::<Vec<_>>());
        let per_episode: Vec<f64> = (0..episodes).filter_map(of_episode).collect();

        let horizon = all.iter().map(|error| error.poses.len()).max()?;
        let of_action = |errors: &mut dyn Iterator<Item = &TrajectoryError>, action: usize| {
            mean(&errors.filter_map(|e| e.poses.get(action)).map(|pose| pose.d_geo()).collect::<Vec<_>>())
        };
        let action_mean = |action| of_action(&mut errors.iter().flatten(), action);
        let action_std = |action| {
            let means: Vec<f64> =
                errors.iter().filter_map(|of_seed| of_action(&mut of_seed.iter(), action)).collect();
            std_ddof1(&means)
        };
        let interval = bootstrap_mean_interval(&per_episode);
        let pose_mean = |value: fn(&reseflow_lie::GeodesicDistance) -> f64| {
            over_all(&|error| mean(&error.poses.iter().map(value).collect::<Vec<_>>()).unwrap_or_default())
        };
        Some(Self {
            d_geo_mean: mean(&per_seed)?,
            d_geo_std: std_ddof1(&per_seed),
            d_geo_episode_std: std_ddof1(&per_episode),
            d_geo_low: interval.map(|interval| interval.low),
            d_geo_high: interval.map(|interval| interval.high),
            d_geo_half_turn_mean: over_all(&|error| error.half_turn_d_geo)?,
            rotation_rad: pose_mean(|pose| pose.rotation_rad)?,
            translation_m: pose_mean(|pose| pose.translation_m)?,
            opening_error: over_all(&|error| error.opening)?,
            per_action_mean: (0..horizon).filter_map(action_mean).collect(),
            per_action_std: (0..horizon).map(action_std).collect(),
            per_seed,
            per_episode,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use reseflow_lie::GeodesicDistance;

    fn error(translations_m: [f64; 2]) -> TrajectoryError {
        let poses: Vec<_> = translations_m
            .map(|translation_m| GeodesicDistance { rotation_rad: 0.0, translation_m })
            .to_vec();
        TrajectoryError { poses, half_turn_d_geo: translations_m[0], opening: translations_m[1] }
    }

    #[test]
    fn aggregates_seeds_episodes_and_actions() {
        // Two seeds, two episodes, two actions. Per-seed means: (1+3+5+7)/4 = 4 and (2+2+2+2)/4 = 2.
        let errors = [vec![error([1.0, 3.0]), error([5.0, 7.0])], vec![error([2.0, 2.0]), error([2.0, 2.0])]];
        let scores = Scores::aggregate(&errors).unwrap();
        assert_eq!(scores.per_seed, [4.0, 2.0]);
        assert_eq!(scores.d_geo_mean, 3.0);
        assert!((scores.d_geo_std.unwrap() - 2f64.sqrt()).abs() < 1e-12);
        assert_eq!(scores.per_episode, [2.0, 4.0]);
        assert!((scores.d_geo_episode_std.unwrap() - 2f64.sqrt()).abs() < 1e-12);
        assert_eq!(scores.per_action_mean, [2.5, 3.5]);
        // Action 0: per-seed means 3 and 2; action 1: 5 and 2.
        assert!((scores.per_action_std[0].unwrap() - 0.5f64.sqrt()).abs() < 1e-12);
        assert!((scores.per_action_std[1].unwrap() - 4.5f64.sqrt()).abs() < 1e-12);
        assert_eq!(scores.translation_m, 3.0);
        assert_eq!(scores.rotation_rad, 0.0);
        assert_eq!(scores.d_geo_half_turn_mean, 2.5);
        assert_eq!(scores.opening_error, 3.5);
        assert!(scores.d_geo_low.unwrap() >= 2.0 && scores.d_geo_high.unwrap() <= 4.0);
    }

    #[test]
    fn one_seed_has_no_spread_and_nothing_has_no_score() {
        let scores = Scores::aggregate(&[vec![error([1.0, 3.0])]]).unwrap();
        assert_eq!((scores.d_geo_mean, scores.d_geo_std, scores.d_geo_low), (2.0, None, None));
        assert_eq!(scores.per_action_std, [None, None]);
        assert_eq!(Scores::aggregate(&[]), None);
        assert_eq!(Scores::aggregate(&[vec![]]), None);
    }
}
