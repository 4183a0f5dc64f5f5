//! How a run's policies act in the simulator: the table `[rollout]`.

use clap::ValueEnum;
use serde::{Deserialize, Serialize};

use super::SolverChoice;
use super::counts::{check_counts, first_repeated};

/// How policies are rolled out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RolloutSection {
    /// Episodes of the test split.
    pub episodes: usize,
    /// Integration steps.
    pub steps: usize,
    /// How the flow is integrated.
    pub solver: SolverChoice,
    /// Actions executed before the policy looks and plans again; open loop it is the whole trajectory.
    pub n_action_steps: usize,
    /// Which of the plans that a policy has made in an episode is carried out.
    pub plan_choice: PlanChoice,
    /// In which ways the last flow acts; the first of them is logged and pictured.
    pub variants: Vec<RolloutVariant>,
    /// Whether Flow 1, where there are more, and the references act as well, in the first way only.
    pub beside: bool,
    /// Noise levels that the baseline visits when it acts, at most as many as it has.
    pub baseline_steps: usize,
    /// Episodes in the MCAP log.
    pub log_episodes: usize,
    /// Episodes in the picture.
    pub picture_episodes: usize,
}

/// A way to act.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RolloutVariant {
    /// Looking and planning again every `n_action_steps` actions.
    Replan,
    /// Carrying out the first plan as a whole.
    OpenLoop,
    /// As `replan`, and before the action step that the task names the scene is disturbed: the board or the triangle is pushed aside, or
    /// the gripper knocked off the door's handle.
    Disturbed,
}

impl RolloutVariant {
    /// The name in configurations and file names.
    pub fn name(self) -> &'static str {
        match self {
            Self::Replan => "replan",
            Self::OpenLoop => "open_loop",
            Self::Disturbed => "disturbed",
        }
    }

    /// What summaries call it.
    pub fn title(self) -> &'static str {
        match self {
            Self::Replan => "planning again",
            Self::OpenLoop => "open loop",
            Self::Disturbed => "disturbed",
        }
    }
}

/// Which of the plans that a policy has made in an episode is carried out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum PlanChoice {
    /// The newest
    #[default]
    Newest,
    /// Of all plans of the episode, the one that is nearest to the others over the next actions; of equals the newest
    Medoid,
}

impl Default for RolloutSection {
    fn default() -> Self {
        Self {
            episodes: 50,
            steps: 1,
            solver: SolverChoice::default(),
            n_action_steps: 3,
            plan_choice: PlanChoice::Newest,
            variants: vec![RolloutVariant::Replan],
            beside: false,
            baseline_steps: 10,
            log_episodes: 5,
            picture_episodes: 4,
        }
    }
}

impl RolloutSection {
    /// Checks what the types cannot say.
    ///
    /// # Errors
    /// A sentence that names the key, what was expected and what was got.
    pub fn validate(&self) -> Result<(), String> {
        check_counts(&[
            ("rollout.episodes", self.episodes),
            ("rollout.steps", self.steps),
            ("rollout.n_action_steps", self.n_action_steps),
            ("rollout.picture_episodes", self.picture_episodes),
            ("rollout.baseline_steps", self.baseline_steps),
        ])?;
        if self.variants.is_empty() || first_repeated(&self.variants).is_some() {
            return Err(format!(
                "`rollout.variants` is [{}], expected one or more of replan, open_loop and disturbed, each once",
                self.variants.iter().map(|variant| variant.name()).collect::<Vec<_>>().join(", ")
            ));
        }
        self.solver.validate().map_err(|fault| format!("`rollout.solver`: {fault}"))?;
        if self.solver.is_adaptive() && self.steps != Self::default().steps {
            return Err(format!(
                "`rollout.steps` is {}, and the solver `rk45` of `rollout.solver` takes steps of its own choice, expected no \
                 `rollout.steps`",
                self.steps
            ));
        }
        Ok(())
    }
}
