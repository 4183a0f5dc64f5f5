//! Which of the plans that a policy has made in an episode is carried out next.
//!
//! A policy that plans again every few actions has several plans for the same steps. Taking the one that agrees most with the others
//! passes over a single plan that went astray. It has its price: what happens late in an episode is known to the newest plan alone, and that is
//! outvoted until as many plans know of it.
//!
//! Averages of overlapping plans are the usual choice (temporal ensembling, arXiv 2304.13705); they mix plans from before and after a
//! change of the scene.

use reseflow_data::{Action, ActionChunk, ObservationHistory, Plan, Policy, PolicyError};
use reseflow_lie::geodesic_distance;

use crate::config::PlanChoice;

/// A policy that remembers its plans and answers with one of them.
pub(super) struct Chooser<'a> {
    policy: &'a mut dyn Policy,
    choice: PlanChoice,
    /// Actions that are carried out of each answer.
    n_action_steps: usize,
    /// The episode's plans, each with the step at which it was made.
    plans: Vec<(usize, ActionChunk)>,
}

impl<'a> Chooser<'a> {
    /// A chooser among the plans of `policy`, of which `n_action_steps` actions are carried out each time.
    pub(super) fn new(policy: &'a mut dyn Policy, choice: PlanChoice, n_action_steps: usize) -> Self {
        Self { policy, choice, n_action_steps, plans: Vec::new() }
    }

    /// What each plan says for `step` and the steps after it, the newest plan first; plans that do not reach as far
    /// as the others are left out.
    fn rest(&self, step: usize) -> Vec<&[Action]> {
        let rest = |(made, plan): &'_ (usize, ActionChunk)| -> Option<std::ops::Range<usize>> {
            let begin = step - made;
            let end = (begin + self.n_action_steps).min(plan.len());
            (end > begin).then_some(begin..end)
        };
        let rests = self.plans.iter().rev().filter_map(|plan| Some(&plan.1.0[rest(plan)?]));
        let longest = rests.clone().map(<[Action]>::len).max().unwrap_or(0);
        rests.filter(|rest| rest.len() == longest).collect()
    }
}

/// The place of the first of `plans` that is nearest to the others: the least sum of D_geo over the actions.
fn medoid(plans: &[&[Action]]) -> usize {
    let apart = |a: &[Action], b: &[Action]| -> f64 {
        let poses = a.iter().zip(b).map(|(a, b)| (&a.world_from_gripper, &b.world_from_gripper));
        poses.map(|(a, b)| geodesic_distance(a, b).d_geo()).sum()
    };
    let mut best = (0, f64::INFINITY);
    for (place, plan) in plans.iter().enumerate() {
        let sum: f64 = plans.iter().map(|other| apart(plan, other)).sum();
        // By more than rounding.
        if sum < best.1 - 1e-9 {
            best = (place, sum);
        }
    }
    best.0
}

impl Policy for Chooser<'_> {
    fn name(&self) -> &str {
        self.policy.name()
    }

    fn reset(&mut self, seed: u64) {
        self.plans.clear();
        self.policy.reset(seed);
    }

    fn plan(&mut self, history: &ObservationHistory) -> Result<Plan, PolicyError> {
        let newest = self.policy.plan(history)?;
        if self.choice == PlanChoice::Newest {
            return Ok(newest);
        }
        let step = history.elapsed_steps();
        self.plans.push((step, newest.actions.clone()));
        let rests = self.rest(step);
        match medoid(&rests) {
            0 => Ok(newest),
            // What the newest plan is unsure of says nothing about an older one.
            place => Ok(Plan { actions: ActionChunk(rests[place].to_vec()), uncertainty: None }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use reseflow_data::{Observation, PointCloud};
    use reseflow_lie::{SE3, SO3, Vector3};

    /// Plans ten actions whose step s lies at s + what is next in its list.
    struct Offsets(std::collections::VecDeque<f64>);

    impl Policy for Offsets {
        fn name(&self) -> &str {
            "offsets"
        }

        fn reset(&mut self, _: u64) {}

        fn plan(&mut self, history: &ObservationHistory) -> Result<Plan, PolicyError> {
            let off = self.0.pop_front().unwrap();
            let action = |ahead: usize| {
                let x_m = (history.elapsed_steps() + ahead) as f64 + off;
                Action {
                    world_from_gripper: SE3::new(SO3::identity(), Vector3::new(x_m, 0.0, 0.0)),
                    opening: 0.0,
                }
            };
            Ok(Plan { actions: ActionChunk((0..10).map(action).collect()), uncertainty: None })
        }
    }

    fn observation() -> Observation {
        Observation {
            cloud: PointCloud::default(),
            world_from_gripper: SE3::identity(),
            gripper_opening: 1.0,
        }
    }

    /// How far off the first action of each answer is, planning again every three steps.
    fn answers(choice: PlanChoice, offsets: &[f64]) -> Vec<f64> {
        let mut policy = Offsets(offsets.iter().copied().collect());
        let mut chooser = Chooser::new(&mut policy, choice, 3);
        chooser.reset(1);
        let mut history = ObservationHistory::new(observation(), 1);
        let mut found = Vec::new();
        for _ in offsets {
            let plan = chooser.plan(&history).unwrap();
            let off = plan.actions.0[0].world_from_gripper.translation.x - history.elapsed_steps() as f64;
            found.push((off * 10.0).round() / 10.0);
            (0..3).for_each(|_| history.push(observation()));
        }
        found
    }

    #[test]
    fn a_single_plan_that_went_astray_is_passed_over() {
        let offsets = [0.0, 0.1, 5.0, 0.2];
        assert_eq!(answers(PlanChoice::Newest, &offsets), offsets, "control");
        // At the last choice the first plan is over, and 0.2 is nearer to 5 than 0.1 is.
        assert_eq!(answers(PlanChoice::Medoid, &offsets), [0.0, 0.1, 0.1, 0.2]);
    }

    #[test]
    fn of_two_plans_the_newer_one_counts_and_an_early_change_prevails() {
        assert_eq!(answers(PlanChoice::Medoid, &[0.0, 5.0, 5.1]), [0.0, 5.0, 5.0]);
    }

    #[test]
    fn a_new_episode_forgets_the_plans_of_the_last() {
        let mut policy = Offsets([0.0, 0.1, 5.0].into());
        let mut chooser = Chooser::new(&mut policy, PlanChoice::Medoid, 3);
        let mut history = ObservationHistory::new(observation(), 1);
        chooser.reset(1);
        chooser.plan(&history).unwrap();
        (0..3).for_each(|_| history.push(observation()));
        chooser.plan(&history).unwrap();
        chooser.reset(2);
        let plan = chooser.plan(&ObservationHistory::new(observation(), 1)).unwrap();
        assert_eq!(plan.actions.0[0].world_from_gripper.translation.x, 5.0);
    }
}
