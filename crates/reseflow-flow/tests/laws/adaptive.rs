//! The adaptive solver: its error follows the tolerance, its steps follow the flow, and it says where it had to give up.

use reseflow_data::{Action, ActionChunk};
use reseflow_flow::{ActionVelocity, AdaptiveConfig, Flow, FlowError, Integrated, Path, Solver, integrate};
use reseflow_lie::{BodyTwist, Vector3};

use crate::known::{Known, ThreeScrews, Twisting};
use crate::{PATHS, apart, chunk, moved, pose, rng};

fn tolerance(rtol: f64) -> AdaptiveConfig {
    AdaptiveConfig { rtol, atol: rtol * 1e-2, max_steps: 10_000 }
}

fn noise() -> ActionChunk {
    chunk(4, &mut rng(81))
}

/// The integrated flow and its true error.
fn twist_form(truth: &ThreeScrews, path: Path, config: AdaptiveConfig) -> (Integrated, f64) {
    let mut field = Twisting::new(|action: &Action, t: f64| truth.velocity(action, t));
    let solver = Solver::DormandPrince(config);
    let found = integrate(&mut Flow::Twist(&mut field), path, vec![noise()], &solver);
    let found = found.expect("the field cannot fail");
    assert_eq!(field.asked, found.evaluations);
    let error = apart(&found.states[0], &truth.solution(&noise()));
    (found, error)
}

fn endpoint_form(truth: &ThreeScrews, path: Path, config: AdaptiveConfig) -> (Integrated, f64) {
    let mut field = Known::new(|state: &ActionChunk, t: f64| truth.endpoint(path, state, t));
    let solver = Solver::DormandPrince(config);
    let found = integrate(&mut Flow::Endpoint(&mut field), path, vec![noise()], &solver);
    let found = found.expect("the field cannot fail");
    assert_eq!(field.asked.len(), found.evaluations);
    assert!(field.asked.iter().all(|(t, _)| *t <= 1.0 - 1e-3 + 1e-15), "the end of time is not asked for");
    let error = apart(&found.states[0], &truth.solution(&noise()));
    (found, error)
}

/// From one tolerance to the next, a hundred times smaller, the error has to fall about a hundredfold.
fn check_proportional(name: &str, run: impl Fn(AdaptiveConfig) -> (Integrated, f64)) {
    let tolerances = [1e-5, 1e-7, 1e-9, 1e-11];
    let runs: Vec<_> = tolerances.map(|rtol| run(tolerance(rtol))).to_vec();
    for ((found, error), rtol) in runs.iter().zip(tolerances) {
        println!(
            "{name}, rtol {rtol:.0e}: error {error:.1e}, estimate {:.1e}, {} steps, {} rejected, {} evaluations",
            found.error.unwrap_or_default(),
            found.steps,
            found.rejected,
            found.evaluations
        );
        assert!(*error < 10.0 * rtol, "{name}: {error:e} at {rtol:e}");
        let estimate = found.error.expect("an adaptive solver estimates its error");
        assert!(*error < 3.0 * estimate, "{name}: {error:e} against an estimate of {estimate:e}");
        // A way of at most 10, and its tolerance once for every step.
        assert!(estimate < 10.0 * rtol * found.steps as f64, "{name}: estimate {estimate:e} at {rtol:e}");
    }
    let slope = (runs[0].1 / runs[3].1).log10() / (tolerances[0] / tolerances[3]).log10();
    println!("{name}: the error goes with the tolerance to the power {slope:.2}");
    assert!((0.8..1.25).contains(&slope), "{name}: {slope}");
    // Order 5: steps go with the tolerance to the power −1/5.
    let growth = (runs[3].0.evaluations as f64 / runs[1].0.evaluations as f64).log10() / 4.0;
    println!("{name}: evaluations with the power -{growth:.2}");
    assert!((0.14..0.27).contains(&growth), "{name}: {growth}");
}

#[test]
fn in_twist_form_the_error_is_proportional_to_the_tolerance() {
    let truth = ThreeScrews { settles: false };
    for path in PATHS {
        check_proportional(&format!("twist, {path:?}"), |config| twist_form(&truth, path, config));
    }
}

#[test]
fn in_endpoint_form_the_error_is_proportional_to_the_tolerance_where_the_drift_settles() {
    // It settles on a screw, so that only a screw arrives without an error of its own.
    let truth = ThreeScrews { settles: true };
    check_proportional("endpoint, Screw", |config| endpoint_form(&truth, Path::Screw, config));
}

#[test]
fn in_endpoint_form_the_arrival_costs_about_a_millionth() {
    // The arrival is an Euler step of 10⁻³, with an error of its square times how fast the drift changes.
    let truth = ThreeScrews { settles: false };
    for path in PATHS {
        let (found, error) = endpoint_form(&truth, path, tolerance(1e-9));
        println!("{path:?}: the arrival costs {error:.1e} in {} steps", found.steps);
        assert!(error < 2e-6, "{error:e}");
    }
}

#[test]
fn evaluations_are_six_a_step_tried_and_one_to_begin_with() {
    let truth = ThreeScrews { settles: false };
    let (found, _) = twist_form(&truth, Path::Screw, tolerance(1e-8));
    assert_eq!(found.evaluations, 1 + 6 * (found.steps + found.rejected));
    let (found, _) = endpoint_form(&truth, Path::Screw, tolerance(1e-8));
    assert_eq!(found.evaluations, 1 + 6 * (found.steps - 1 + found.rejected), "the arrival costs none");
}

#[test]
fn a_sudden_turn_is_met_with_short_steps() {
    // A turn by an arctangent, spread out or within a hundredth of the time.
    let turn = |width: f64| {
        move |_: &Action, t: f64| {
            let speed = width / ((t - 0.6).powi(2) + width * width);
            ActionVelocity {
                twist: BodyTwist::new(Vector3::new(0.0, 0.0, speed), Vector3::zeros()),
                opening: 0.0,
            }
        }
    };
    let run = |width: f64| {
        let mut field = Twisting::new(turn(width));
        let solver = Solver::DormandPrince(tolerance(1e-6));
        integrate(&mut Flow::Twist(&mut field), Path::Screw, vec![noise()], &solver)
            .expect("the field cannot fail")
    };
    let (gentle, sudden) = (run(0.3), run(0.01));
    println!("gentle: {} steps; sudden: {} and {} rejected", gentle.steps, sudden.steps, sudden.rejected);
    assert!(sudden.steps > 3 * gentle.steps && sudden.rejected > 0);
    let turned = noise().0[0].world_from_gripper.body_twist_to(&sudden.states[0].0[0].world_from_gripper);
    let whole = (0.4_f64 / 0.01).atan() + (0.6_f64 / 0.01).atan();
    assert!((turned.angular - Vector3::z() * whole).norm() < 1e-5, "{whole} and not {}", turned.angular);
}

#[test]
fn a_constant_endpoint_is_reached_exactly_and_cheaply() {
    let mut rng = rng(82);
    for path in PATHS {
        let (noise, end) = (chunk(5, &mut rng), chunk(5, &mut rng));
        let mut field = Known::new(|_: &ActionChunk, _| end.clone());
        let solver = Solver::DormandPrince(AdaptiveConfig::default());
        let found = integrate(&mut Flow::Endpoint(&mut field), path, vec![noise], &solver);
        let found = found.expect("the field cannot fail");
        assert_eq!(found.states, [end]);
        assert!(found.steps < 25, "{} steps", found.steps);
    }
}

#[test]
fn a_moved_flow_takes_the_same_steps() {
    let mut rng = rng(83);
    let (noise, goal, far) = (chunk(4, &mut rng), chunk(4, &mut rng), pose(&mut rng));
    let run = |noise: ActionChunk, goal: ActionChunk| {
        let mut field = Known::new(|state: &ActionChunk, t: f64| {
            Path::Screw.at(state, &goal, 0.3 + 0.7 * t).expect("equal horizons")
        });
        let solver = Solver::DormandPrince(AdaptiveConfig::default());
        integrate(&mut Flow::Endpoint(&mut field), Path::Screw, vec![noise], &solver)
            .expect("the field cannot fail")
    };
    let (here, there) = (run(noise.clone(), goal.clone()), run(moved(&far, &noise), moved(&far, &goal)));
    assert_eq!([here.steps, here.rejected], [there.steps, there.rejected]);
    assert!(apart(&there.states[0], &moved(&far, &here.states[0])) < 1e-9);
}

#[test]
fn a_scene_is_never_followed_less_closely_for_its_company() {
    let truth = ThreeScrews { settles: false };
    let mut rng = rng(84);
    let scenes: Vec<_> = (0..5).map(|_| chunk(3, &mut rng)).collect();
    let mut field = Twisting::new(|action: &Action, t: f64| truth.velocity(action, t));
    let solver = Solver::DormandPrince(tolerance(1e-7));
    let together = integrate(&mut Flow::Twist(&mut field), Path::Screw, scenes.clone(), &solver);
    for (scene, state) in scenes.iter().zip(together.expect("the field cannot fail").states) {
        let error = apart(&state, &truth.solution(scene));
        assert!(error < 1e-6, "{error:e}");
    }
}

#[test]
fn where_the_tolerance_cannot_be_kept_the_solver_says_how_far_it_came() {
    let truth = ThreeScrews { settles: false };
    let mut field = Twisting::new(|action: &Action, t: f64| truth.velocity(action, t));
    let solver = Solver::DormandPrince(AdaptiveConfig { max_steps: 3, ..tolerance(1e-10) });
    let found = integrate(&mut Flow::Twist(&mut field), Path::Screw, vec![noise()], &solver);
    let Err(FlowError::Tolerance { t, steps: 3 }) = found else { panic!("{found:?}") };
    assert!(t > 0.0 && t < 1.0, "{t}");

    // A speed that jumps at every scale: no step is short enough.
    let mut rough = Twisting::new(|_: &Action, t: f64| {
        let speed = if t.to_bits().count_ones().is_multiple_of(2) { 1.0 } else { -1.0 };
        ActionVelocity { twist: BodyTwist::zero(), opening: speed }
    });
    let solver = Solver::DormandPrince(tolerance(1e-12));
    let found = integrate(&mut Flow::Twist(&mut rough), Path::Screw, vec![noise()], &solver);
    let Err(error @ FlowError::Tolerance { .. }) = found else { panic!("{found:?}") };
    assert!(error.to_string().contains("gave up"), "{error}");
}

#[test]
fn a_tolerance_that_is_none_is_refused() {
    for value in [0.0, -1e-3, f64::NAN, f64::INFINITY] {
        for (key, config) in [
            ("rtol", AdaptiveConfig { rtol: value, ..AdaptiveConfig::default() }),
            ("atol", AdaptiveConfig { atol: value, ..AdaptiveConfig::default() }),
        ] {
            let Err(FlowError::Config(text)) = Solver::DormandPrince(config).validate() else {
                panic!("{key} = {value} is taken")
            };
            assert!(text.contains(&format!("solver.{key}")), "{text}");
        }
    }
    let none = AdaptiveConfig { max_steps: 0, ..AdaptiveConfig::default() };
    assert_eq!(Solver::DormandPrince(none).validate(), Err(FlowError::NoSteps));
    assert_eq!(Solver::DormandPrince(AdaptiveConfig::default()).validate(), Ok(()));
}
