//! Configurations of a flow's parts as TOML: strict, tagged, the defaults those that always were, and what makes no sense refused.

use reseflow_flow::{
    AdaptiveConfig, Coupling, FlowError, GripperPrior, HaarPrior, ObjectiveConfig, Path, PoseError, Prior,
    Solver, TimeSampling, TimeShape,
};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// A flow's parts, side by side as in a file.
#[derive(Debug, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Parts {
    path: Path,
    prior: Prior,
    time: TimeSampling,
    objective: ObjectiveConfig,
}

impl Parts {
    fn validate(&self) -> Result<(), FlowError> {
        self.prior.validate()?;
        self.time.validate()?;
        self.objective.validate()
    }
}

fn parse<T: DeserializeOwned>(text: &str) -> Result<T, String> {
    toml::from_str(text).map_err(|fault| fault.message().to_owned())
}

#[test]
fn nothing_said_is_the_flow_of_the_first_days() {
    let default: Parts = parse("").unwrap();
    let expected = Parts {
        path: Path::Screw,
        prior: Prior::Gripper(GripperPrior {
            sigma_rotation_rad: 0.5,
            sigma_translation_m: 0.1,
            sigma_opening: 0.2,
        }),
        time: TimeSampling { zero_share: 0.3, shape: TimeShape::Uniform },
        objective: ObjectiveConfig {
            error: PoseError::Chordal,
            pseudo_huber: None,
            nodes: 0.5,
            opening: 0.25,
            overlap: 0.01,
        },
    };
    assert_eq!(default, expected);
    assert_eq!(default.validate(), Ok(()));
    assert_eq!(Solver::default(), Solver::Euler { steps: 1 });
    assert_eq!(Coupling::default(), Coupling::Anchored);
}

#[test]
fn a_prior_without_a_kind_is_the_gripper_prior() {
    // Configurations and checkpoints written before there was a second prior.
    let old = "sigma_rotation_rad = 0.4\nsigma_translation_m = 0.1\nsigma_opening = 0.2\n";
    let gripper = GripperPrior { sigma_rotation_rad: 0.4, ..GripperPrior::default() };
    assert_eq!(parse::<Prior>(old), Ok(Prior::Gripper(gripper)));
    assert_eq!(parse::<Prior>("kind = \"gripper\"\nsigma_rotation_rad = 0.4"), Ok(Prior::Gripper(gripper)));
    let haar = HaarPrior { sigma_translation_m: 0.3, ..HaarPrior::default() };
    assert_eq!(parse::<Prior>("kind = \"haar\"\nsigma_translation_m = 0.3"), Ok(Prior::Haar(haar)));
}

#[test]
fn what_is_written_is_read_back() {
    let config = Parts {
        path: Path::Product,
        prior: Prior::Haar(HaarPrior::default()),
        time: TimeSampling { zero_share: 0.1, shape: TimeShape::UShaped },
        objective: ObjectiveConfig {
            error: PoseError::Twist,
            pseudo_huber: Some(0.3),
            ..ObjectiveConfig::default()
        },
    };
    assert_eq!(config.validate(), Ok(()));
    for config in [config, Parts::default()] {
        let text = toml::to_string(&config).unwrap();
        assert_eq!(parse::<Parts>(&text), Ok(config), "{text}");
    }
    for solver in [
        Solver::Euler { steps: 3 },
        Solver::Midpoint { steps: 3 },
        Solver::Heun { steps: 3 },
        Solver::Rk4 { steps: 3 },
        Solver::DormandPrince(AdaptiveConfig { rtol: 1e-5, ..AdaptiveConfig::default() }),
    ] {
        let text = toml::to_string(&solver).unwrap();
        assert!(text.contains(&format!("kind = \"{}\"", solver.name())), "{text}");
        assert_eq!(parse::<Solver>(&text), Ok(solver));
    }
    let adaptive = Solver::DormandPrince(AdaptiveConfig::default());
    assert_eq!(parse::<Solver>("kind = \"dormand_prince\""), Ok(adaptive), "with tolerances of its own");
}

#[test]
fn keys_and_values_that_do_not_exist_are_named() {
    let flow = |text: &str| parse::<Parts>(text).unwrap_err();
    for (text, key) in [
        ("paths = \"screw\"", "paths"),
        ("path = \"straight\"", "straight"),
        ("[prior]\nsigma = 0.1", "sigma"),
        ("[prior]\nkind = \"identity\"", "identity"),
        ("[prior]\nkind = \"haar\"\nsigma = 0.1", "sigma"),
        ("[time]\nshape = \"v_shaped\"", "v_shaped"),
        ("[time]\nzero = 0.1", "zero"),
        ("[objective]\nerror = \"angle\"", "angle"),
        ("[objective]\nhuber = 0.1", "huber"),
    ] {
        let fault = flow(text);
        assert!(fault.contains(&format!("`{key}`")) && fault.contains("expected"), "{text}: {fault}");
    }
    for (text, key) in [
        ("kind = \"rk5\"\nsteps = 3", "rk5"),
        ("kind = \"euler\"\nsteps = 3\nrtol = 1e-3", "rtol"),
        ("kind = \"dormand_prince\"\nsteps = 3", "steps"),
        ("kind = \"heun\"", "steps"),
    ] {
        let fault = parse::<Solver>(text).unwrap_err();
        assert!(fault.contains(&format!("`{key}`")), "{text}: {fault}");
    }
    assert!(parse::<Solver>("steps = 3").unwrap_err().contains("kind"));
}

#[test]
fn a_deviation_of_rotations_has_no_meaning_where_all_are_equally_likely() {
    let fault = parse::<Prior>("kind = \"haar\"\nsigma_rotation_rad = 0.5").unwrap_err();
    assert!(fault.contains("sigma_rotation_rad") && fault.contains("equally likely"), "{fault}");
}

#[test]
fn what_makes_no_sense_is_refused_with_the_reason() {
    let refused = |text: &str| match parse::<Parts>(text).unwrap().validate() {
        Err(FlowError::Config(reason)) => reason,
        other => panic!("{text}: {other:?}"),
    };
    let reason = refused("[time]\nzero_share = 1.0\nshape = \"u_shaped\"");
    assert!(reason.contains("time.shape") && reason.contains("time.zero_share"), "{reason}");
    assert!(refused("[prior]\nsigma_opening = -1.0").contains("prior.sigma_opening"));
    let reason = refused("[prior]\nsigma_rotation_rad = 0.0\nsigma_translation_m = 0.0\nsigma_opening = 0.0");
    assert!(reason.contains("all") && reason.contains("noise"), "{reason}");
    assert!(refused("[objective]\npseudo_huber = 0.0").contains("objective.pseudo_huber"));
    for text in [
        "[objective]\nerror = \"twist\"\npseudo_huber = 0.1",
        "path = \"product\"\n[prior]\nkind = \"haar\"",
        "[prior]\nsigma_rotation_rad = 0.0\nsigma_opening = 0.0",
        "[prior]\nkind = \"haar\"\nsigma_translation_m = 0.0\nsigma_opening = 0.0",
    ] {
        assert_eq!(parse::<Parts>(text).unwrap().validate(), Ok(()), "{text}");
    }
}
