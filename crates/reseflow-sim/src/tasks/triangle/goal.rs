//! How far the triangle is to be turned, and whether it was.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_3, PI, TAU};

use rand::RngExt;
use reseflow_data::EpisodeKey;

const TOLERANCE_RAD: f64 = 0.1;

/// How far to turn.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum TriangleGoal {
    /// By π/3.
    Sixth,
    /// By π/2.
    #[default]
    Quarter,
    /// By 2π/3.
    Third,
    /// By π/2 to either side, the expert's choice is random: two modes that nothing in the observation tells apart.
    CoinToss,
}

impl TriangleGoal {
    /// Every goal.
    pub(crate) const ALL: [TriangleGoal; 4] =
        [TriangleGoal::Quarter, TriangleGoal::Sixth, TriangleGoal::Third, TriangleGoal::CoinToss];

    /// The registered name of the task with this goal.
    pub(crate) const fn task_name(self) -> &'static str {
        match self {
            TriangleGoal::Sixth => "triangle_60",
            TriangleGoal::Quarter => "triangle",
            TriangleGoal::Third => "triangle_120",
            TriangleGoal::CoinToss => "coin_toss",
        }
    }

    pub(super) fn wording(self) -> &'static str {
        match self {
            TriangleGoal::Sixth => "by 60 degrees counter-clockwise",
            TriangleGoal::Quarter => "by a quarter turn counter-clockwise",
            TriangleGoal::Third => "by 120 degrees counter-clockwise",
            TriangleGoal::CoinToss => "by a quarter turn to either side",
        }
    }

    /// The expert's turn in the episode that `key` names, radians, counter-clockwise seen from above.
    pub(super) fn turn_rad(self, key: &EpisodeKey) -> f64 {
        match self {
            TriangleGoal::Sixth => FRAC_PI_3,
            TriangleGoal::Quarter => FRAC_PI_2,
            TriangleGoal::Third => 2.0 * FRAC_PI_3,
            TriangleGoal::CoinToss if key.rng("coin").random::<bool>() => -FRAC_PI_2,
            TriangleGoal::CoinToss => FRAC_PI_2,
        }
    }

    /// The turn of the other expert, where there are two.
    pub(super) fn other_turn_rad(self, turn_rad: f64) -> Option<f64> {
        (self == TriangleGoal::CoinToss).then_some(-turn_rad)
    }

    /// The branch of an angle that has the goal, or the middle of both goals, at its centre, radians.
    pub(super) fn branch(self, angle_rad: f64) -> f64 {
        let center = match self {
            TriangleGoal::Sixth => FRAC_PI_3,
            TriangleGoal::Quarter => FRAC_PI_2,
            TriangleGoal::Third => 2.0 * FRAC_PI_3,
            TriangleGoal::CoinToss => 0.0,
        };
        (angle_rad - center + PI).rem_euclid(TAU) - PI + center
    }

    /// Whether a turn, as [`Self::branch`] gives it, is the goal.
    pub(super) fn is_reached(self, turned_rad: f64) -> bool {
        let off = match self {
            TriangleGoal::Sixth => turned_rad - FRAC_PI_3,
            TriangleGoal::Quarter => turned_rad - FRAC_PI_2,
            TriangleGoal::Third => turned_rad - 2.0 * FRAC_PI_3,
            TriangleGoal::CoinToss => turned_rad.abs() - FRAC_PI_2,
        };
        off.abs() <= TOLERANCE_RAD
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use reseflow_data::Split;

    fn key(index: u64) -> EpisodeKey {
        EpisodeKey { task: "coin_toss".to_owned(), split: Split::Train, seed: 1, index, attempt: 0 }
    }

    #[test]
    fn every_expert_turns_to_its_goal_and_nothing_else_counts() {
        for goal in TriangleGoal::ALL {
            for turn in [
                goal.turn_rad(&key(3)),
                goal.other_turn_rad(goal.turn_rad(&key(3))).unwrap_or(goal.turn_rad(&key(3))),
            ] {
                assert!((goal.branch(turn + TAU) - turn).abs() < 1e-12);
                assert!(
                    goal.is_reached(turn) && goal.is_reached(turn + 0.09) && goal.is_reached(turn - 0.09)
                );
                assert!(!goal.is_reached(turn + 0.11) && !goal.is_reached(turn - 0.11));
            }
            assert!(!goal.is_reached(0.0));
        }
    }

    #[test]
    fn the_coin_is_fair() {
        let left = (0..400).filter(|&index| TriangleGoal::CoinToss.turn_rad(&key(index)) > 0.0).count();
        // Within four standard deviations of 200.
        assert!((160..=240).contains(&left), "{left}");
    }
}
