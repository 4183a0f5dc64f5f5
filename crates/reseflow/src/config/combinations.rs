//! What the tables of an experiment exclude of each other: every refusal says why.

use reseflow_train::Keep;

use super::{ExperimentConfig, RolloutVariant, SolverChoice};

impl ExperimentConfig {
    /// Checks the tables against each other.
    ///
    /// # Errors
    /// A sentence that names the keys, why they exclude each other and what was expected.
    pub(super) fn validate_combinations(&self) -> Result<(), String> {
        if let Some(baseline) = &self.baseline {
            let levels = baseline.diffusion.steps;
            if let Some(steps) = self.eval.steps.iter().find(|steps| **steps > levels) {
                return Err(format!(
                    "`eval.steps` holds {steps}, expected at most the {levels} noise levels of `baseline.diffusion.steps`"
                ));
            }
        }
        if self.model.regression {
            self.validate_regression()?;
        }
        if self.pretrained.is_none() && self.train.augment.scene_rotation && self.model.is_equivariant() {
            return Err(
                "`train.augment.scene_rotation` is true, which teaches an equivariant network nothing, expected \
                 `model.network.symmetry` = \"none\" beside it"
                    .to_owned(),
            );
        }
        Ok(())
    }

    /// Checks what only a whole run asks for: single commands are given their own validation episodes and carry nothing out.
    ///
    /// # Errors
    /// As [`ExperimentConfig::validate`].
    pub fn validate_run(&self) -> Result<(), String> {
        // Policies that were trained elsewhere have settings of their own.
        if self.pretrained.is_some() {
            return Ok(());
        }
        self.validate_watching()?;
        self.validate_plans()
    }

    /// Checks that there are validations where training goes by them.
    fn validate_watching(&self) -> Result<(), String> {
        let watched = [
            ("`train.keep` is best", self.train.keep == Keep::Best),
            ("`train.patience` is not 0", self.train.patience > 0),
        ];
        if let Some((what, _)) =
            watched.iter().find(|(_, asked)| *asked && self.data.validation_episodes == 0)
        {
            return Err(format!(
                "{what}, which takes validations, and `data.validation_episodes` is 0, expected 1 or more"
            ));
        }
        Ok(())
    }

    /// Checks that plans are as long as what is carried out of them.
    fn validate_plans(&self) -> Result<(), String> {
        let (horizon, executed) = (self.model.network.decoder.horizon, self.rollout.n_action_steps);
        let length = format!("the {horizon} actions of a plan (`model.network.decoder.horizon`)");
        if executed > horizon {
            return Err(format!("`rollout.n_action_steps` is {executed}, expected at most {length}"));
        }
        // An unknown task is refused where it is looked up.
        let steps = reseflow_sim::task(&self.task).map_or(0, |task| task.spec().action_steps);
        if self.rollout.variants.contains(&RolloutVariant::OpenLoop) && steps > horizon {
            return Err(format!(
                "`rollout.variants` holds open_loop, one plan for the {steps} actions of the task `{}`, expected no more than {length}",
                self.task
            ));
        }
        Ok(())
    }

    /// Checks what goes with `model.regression`.
    fn validate_regression(&self) -> Result<(), String> {
        let what = "`model.regression` is true, and a regressor";
        let plain = SolverChoice::default();
        if self.reflow.is_some() {
            return Err(format!("{what} has no flow that the table `reflow` could straighten"));
        }
        if self.samplers.is_some() {
            return Err(format!("{what} has no flow that the table `samplers` could compare solvers on"));
        }
        if self.regressor {
            return Err(format!("{what} is what `regressor` trains beside a flow: say one of them"));
        }
        if self.eval.steps != [1] || self.rollout.steps != 1 {
            return Err(format!(
                "{what} answers at once: expected `eval.steps` = [1] and `rollout.steps` = 1"
            ));
        }
        if self.eval.solver != plain || self.rollout.solver != plain {
            return Err(format!(
                "{what} integrates nothing: expected no `eval.solver` and no `rollout.solver`"
            ));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{Override, parse};

    fn verdict(sets: &[&str]) -> Result<(), String> {
        let sets: Vec<Override> = sets.iter().map(|set| set.parse().unwrap()).collect();
        let config = parse::<ExperimentConfig>("", "a.toml", &sets).unwrap();
        config.validate().and_then(|()| config.validate_run())
    }

    #[test]
    fn keys_that_exclude_each_other_are_both_named_and_either_alone_is_fine() {
        let decoder = "model.network.decoder.horizon";
        for (first, second, keys) in [
            ("train.keep=best", "data.validation_episodes=0", ["`train.keep`", "`data.validation_episodes`"]),
            (
                "train.patience=3",
                "data.validation_episodes=0",
                ["`train.patience`", "`data.validation_episodes`"],
            ),
            (
                "rollout.n_action_steps=8",
                "model.network.decoder.horizon=7",
                ["`rollout.n_action_steps`", decoder],
            ),
            (
                "rollout.variants=[\"open_loop\"]",
                "model.network.decoder.horizon=9",
                ["`rollout.variants`", decoder],
            ),
            ("rollout.steps=5", "rollout.solver.kind=rk45", ["`rollout.steps`", "rk45"]),
            (
                "eval.steps=[60]",
                "baseline.diffusion.steps=50",
                ["`eval.steps`", "`baseline.diffusion.steps`"],
            ),
        ] {
            let fault = verdict(&[first, second]).unwrap_err();
            assert!(keys.iter().all(|key| fault.contains(key)), "{first} and {second}: {fault}");
            for alone in [first, second].into_iter().filter(|set| !set.starts_with("baseline")) {
                verdict(&[alone]).unwrap_or_else(|fault| panic!("{alone}: {fault}"));
            }
        }
    }

    #[test]
    fn turned_scenes_are_for_networks_that_are_not_equivariant() {
        let turned = "train.augment.scene_rotation=true";
        let fault = verdict(&[turned]).unwrap_err();
        assert!(
            ["`train.augment.scene_rotation`", "`model.network.symmetry`"]
                .iter()
                .all(|key| fault.contains(key))
        );
        verdict(&[turned, "model.network.symmetry=none"]).unwrap();
    }

    #[test]
    fn lines_are_redrawn_for_one_frame_no_grasp_and_noise_about_the_gripper() {
        let (redraw, frame) = ("train.augment.redraw_share=0.5", "model.network.decoder.frames=1");
        verdict(&[redraw, frame]).unwrap();
        for (set, key) in [
            ("model.network.decoder.frames=2", "model.network.decoder.frames"),
            ("model.network.decoder.grasp_memory=true", "model.network.decoder.grasp_memory"),
            ("model.prior.kind=haar", "model.prior.kind"),
        ] {
            let fault = verdict(&[frame, set, redraw]).unwrap_err();
            assert!(fault.contains("train.augment.redraw_share") && fault.contains(key), "{fault}");
            verdict(&[frame, set]).unwrap();
        }
        // A regressor draws no noise.
        let regressor =
            ["model.regression=true", "eval.steps=[1]", "rollout.steps=1", "model.prior.kind=haar"];
        verdict(&[&regressor[..], &[frame, redraw]].concat()).unwrap();
    }

    #[test]
    fn policies_that_were_trained_elsewhere_have_settings_of_their_own() {
        for sets in [
            ["train.keep=best", "data.validation_episodes=0"],
            ["rollout.n_action_steps=8", "model.network.decoder.horizon=7"],
        ] {
            verdict(&[sets[0], sets[1], "pretrained=door"]).unwrap();
            verdict(&sets).unwrap_err();
        }
    }
}
