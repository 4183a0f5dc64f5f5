//! What the tables of an experiment exclude of each other: every refusal says why.

use reseflow_train::{Keep, Symmetry};

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
        if self.pretrained.is_none() {
            self.validate_symmetry()?;
        }
        Ok(())
    }

    /// Checks that training scenes are changed in no way that the network cannot use, or must not see.
    fn validate_symmetry(&self) -> Result<(), String> {
        let (symmetry, augment) = (self.model.network.symmetry, &self.train.augment);
        if augment.scene_rotation && symmetry != Symmetry::None {
            return Err(
                "`train.augment.scene_rotation` is true, which teaches an equivariant network nothing and shows one that is told which \
                 way is up what it never meets, expected `model.network.symmetry` = \"none\" beside it"
                    .to_owned(),
            );
        }
        let mirrors = augment.mirror_share > 0.0;
        if augment.mirror_upright && (symmetry == Symmetry::SE3 || !mirrors) {
            return Err(
                "`train.augment.mirror_upright` is true, which is for networks that know which way is up and for mirrors, expected \
                 `model.network.symmetry` = \"upright\" or \"none\" and a `train.augment.mirror_share` above 0 beside it"
                    .to_owned(),
            );
        }
        if symmetry != Symmetry::SE3 && mirrors && !augment.mirror_upright && !augment.scene_rotation {
            return Err(format!(
                "`train.augment.mirror_share` is {} in a gripper's own plane, which turns scenes over, and \
                 `model.network.symmetry` is not \"se3\", expected `train.augment.mirror_upright` = true beside it",
                augment.mirror_share
            ));
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
    fn scenes_are_turned_and_mirrored_as_the_networks_symmetry_asks() {
        let (turned, mirrored) = ("train.augment.scene_rotation=true", "train.augment.mirror_share=0.5");
        let (level, upright, none) = (
            "train.augment.mirror_upright=true",
            "model.network.symmetry=upright",
            "model.network.symmetry=none",
        );
        for sets in [
            &[turned, none][..],
            &[turned, none, mirrored],
            &[mirrored, none, level],
            &[mirrored, upright, level],
            &[mirrored],
            &[upright],
            &["pretrained=door", upright, mirrored],
        ] {
            verdict(sets).unwrap_or_else(|fault| panic!("{sets:?}: {fault}"));
        }
        for (key, sets) in [
            ("train.augment.scene_rotation", &[turned][..]),
            ("train.augment.scene_rotation", &[turned, upright]),
            ("train.augment.mirror_upright", &[mirrored, level]),
            ("train.augment.mirror_upright", &[upright, level]),
            ("train.augment.mirror_share", &[mirrored, upright]),
            ("train.augment.mirror_share", &[mirrored, none]),
        ] {
            let fault = verdict(sets).unwrap_err();
            let names_both =
                fault.starts_with(&format!("`{key}`")) && fault.contains("`model.network.symmetry`");
            assert!(names_both, "{sets:?}: {fault}");
        }
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
