//! Orders of convergence on flows with a known answer, in both forms and along both geodesics.

use reseflow_data::{Action, ActionChunk};
use reseflow_flow::{Flow, Path, Solver, integrate};

use crate::known::{Known, ThreeScrews, Twisting};
use crate::{PATHS, apart, chunk, rng};

/// Uniform steps of one solver.
type OfSteps = fn(usize) -> Solver;

const EULER: OfSteps = |steps| Solver::Euler { steps };
const MIDPOINT: OfSteps = |steps| Solver::Midpoint { steps };
const HEUN: OfSteps = |steps| Solver::Heun { steps };
const RK4: OfSteps = |steps| Solver::Rk4 { steps };

fn noise() -> ActionChunk {
    chunk(4, &mut rng(13))
}

/// The error of the flow in twist form.
fn twist_error(truth: &ThreeScrews, path: Path, solver: &Solver) -> f64 {
    let mut field = Twisting::new(|action: &Action, t: f64| truth.velocity(action, t));
    let found = integrate(&mut Flow::Twist(&mut field), path, vec![noise()], solver);
    let found = found.expect("the field cannot fail");
    assert_eq!(field.asked, found.evaluations);
    apart(&found.states[0], &truth.solution(&noise()))
}

/// The error of the flow in endpoint form.
fn endpoint_error(truth: &ThreeScrews, path: Path, solver: &Solver) -> f64 {
    let mut field = Known::new(|state: &ActionChunk, t: f64| truth.endpoint(path, state, t));
    let found = integrate(&mut Flow::Endpoint(&mut field), path, vec![noise()], solver);
    apart(&found.expect("the field cannot fail").states[0], &truth.solution(&noise()))
}

/// The order between each doubling of the steps has to be `expected`.
fn check(name: &str, expected: f64, steps: &[usize], error: impl Fn(usize) -> f64) {
    let errors: Vec<f64> = steps.iter().map(|&steps| error(steps)).collect();
    let orders: Vec<f64> = errors.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect();
    let ends = (errors[0], errors[errors.len() - 1]);
    println!("{name}: errors {:.1e} to {:.1e} in {steps:?} steps, orders {orders:.2?}", ends.0, ends.1);
    for order in &orders {
        assert!((order - expected).abs() < 0.25, "{name}: order {order}, expected {expected}");
    }
    assert!(orders.last().is_some_and(|last| (last - expected).abs() < 0.12), "{name}: {orders:?}");
}

#[test]
fn in_twist_form_every_solver_has_its_order() {
    let truth = ThreeScrews { settles: false };
    let cases: [(&str, f64, OfSteps, &[usize]); 4] = [
        ("euler", 1.0, EULER, &[64, 128, 256, 512]),
        ("midpoint", 2.0, MIDPOINT, &[16, 32, 64, 128]),
        ("heun", 2.0, HEUN, &[16, 32, 64, 128]),
        ("rk4", 4.0, RK4, &[8, 16, 32, 64]),
    ];
    for path in PATHS {
        for (name, order, solver, steps) in cases {
            check(&format!("twist, {path:?}, {name}"), order, steps, |steps| {
                twist_error(&truth, path, &solver(steps))
            });
        }
    }
}

#[test]
fn in_endpoint_form_orders_one_and_two_are_kept_and_rk4_ends_with_order_two() {
    let truth = ThreeScrews { settles: false };
    let cases: [(&str, f64, OfSteps); 4] =
        [("euler", 1.0, EULER), ("midpoint", 2.0, MIDPOINT), ("heun", 2.0, HEUN), ("rk4", 2.0, RK4)];
    for path in PATHS {
        for (name, order, solver) in cases {
            check(&format!("endpoint, {path:?}, {name}"), order, &[64, 128, 256, 512], |steps| {
                endpoint_error(&truth, path, &solver(steps))
            });
        }
    }
}

#[test]
fn in_endpoint_form_rk4_keeps_order_four_where_the_drift_settles() {
    let truth = ThreeScrews { settles: true };
    let rk4 = |steps| endpoint_error(&truth, Path::Screw, &RK4(steps));
    check("endpoint, settling, rk4", 4.0, &[32, 64, 128, 256], rk4);
    // Control: settling alone does not make a solver better than it is.
    let midpoint = |steps| endpoint_error(&truth, Path::Screw, &MIDPOINT(steps));
    check("endpoint, settling, midpoint", 2.0, &[32, 64, 128, 256], midpoint);
}

#[test]
fn a_field_without_the_inverse_of_dexp_would_be_seen() {
    // Control: the same tableau with velocities added as if the group were flat has an error that stays far above.
    let truth = ThreeScrews { settles: false };
    let steps = 32;
    let mut action = noise().0[0];
    for step in 0..steps {
        let (t, h) = (step as f64 / f64::from(steps), 1.0 / f64::from(steps));
        let at = |action: &Action, t| truth.velocity(action, t).twist;
        let towards = |twist| Action { world_from_gripper: action.world_from_gripper.plus(&twist), ..action };
        let first = at(&action, t);
        let second = at(&towards(first * (h / 2.0)), t + h / 2.0);
        let third = at(&towards(second * (h / 2.0)), t + h / 2.0);
        let fourth = at(&towards(third * h), t + h);
        let mean = (first + second * 2.0 + third * 2.0 + fourth) * (h / 6.0);
        action = towards(mean);
    }
    let expected = truth.solution(&ActionChunk(vec![noise().0[0]])).0[0].world_from_gripper;
    let flat = reseflow_lie::geodesic_distance(&action.world_from_gripper, &expected).d_geo();
    let right = twist_error(&truth, Path::Screw, &RK4(32));
    println!("rk4 in 32 steps: {right:.1e}, and {flat:.1e} without the inverse of dexp");
    assert!(flat > 20.0 * right, "{flat:e} against {right:e}");
}
