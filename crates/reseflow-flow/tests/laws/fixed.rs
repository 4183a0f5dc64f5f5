//! Solvers on a fixed grid: exact where they must be, equivariant, and every scene by itself.

use reseflow_data::{Action, ActionChunk};
use reseflow_flow::{ActionVelocity, DriftField, Flow, FlowError, Integrated, Path, Solver, integrate};
use reseflow_lie::{BodyTwist, Vector3};

use crate::known::{GROWTH, Known, ThreeScrews, Twisting, mapped};
use crate::{PATHS, apart, chunk, moved, pose, rng};

/// Every solver on a fixed grid, with its evaluations for a step.
fn solvers(steps: usize) -> [(Solver, usize); 4] {
    [
        (Solver::Euler { steps }, 1),
        (Solver::Midpoint { steps }, 2),
        (Solver::Heun { steps }, 2),
        (Solver::Rk4 { steps }, 4),
    ]
}

fn solve(field: &mut dyn DriftField, path: Path, noise: Vec<ActionChunk>, solver: &Solver) -> Integrated {
    integrate(&mut Flow::Endpoint(field), path, noise, solver).expect("the field cannot fail")
}

#[test]
fn one_step_is_the_predicted_endpoint() {
    let mut rng = rng(11);
    let noise = vec![chunk(5, &mut rng), chunk(5, &mut rng)];
    let step = pose(&mut rng);
    let mut field = Known::new(|state: &ActionChunk, t: f64| {
        assert_eq!(t, 0.0);
        mapped(state, |action| Action {
            world_from_gripper: action.world_from_gripper * step,
            opening: 1.0 - action.opening,
        })
    });
    let expected = field.endpoints(&noise, 0.0).expect("the field cannot fail");
    for path in PATHS {
        for (solver, _) in solvers(1) {
            let found = solve(&mut field, path, noise.clone(), &solver);
            assert_eq!(found.states, expected, "to the last bit");
            assert_eq!([found.evaluations, found.steps, found.rejected], [1, 1, 0]);
            assert_eq!(found.error, None);
        }
    }
}

#[test]
fn a_constant_endpoint_is_reached_along_the_geodesic_in_any_number_of_steps() {
    let mut rng = rng(12);
    for path in PATHS {
        for steps in [1, 2, 3, 7, 10, 100] {
            let (noise, end) = (chunk(5, &mut rng), chunk(5, &mut rng));
            let mut field = Known::new(|_: &ActionChunk, _| end.clone());
            let found = solve(&mut field, path, vec![noise.clone()], &Solver::Euler { steps });
            assert_eq!(found.states, std::slice::from_ref(&end));
            assert_eq!([found.evaluations, found.steps, field.asked.len()], [steps; 3]);
            for (index, (t, states)) in field.asked.iter().enumerate() {
                assert!((t - index as f64 / steps as f64).abs() < 1e-15, "a uniform grid");
                let expected = path.at(&noise, &end, *t).expect("equal horizons");
                let off = apart(&states[0], &expected);
                assert!(off < 1e-11, "{off:e} off the geodesic at {t}");
            }
        }
    }
}

#[test]
fn every_solver_arrives_and_never_asks_at_the_end_of_time() {
    let mut rng = rng(18);
    let (noise, end) = (chunk(4, &mut rng), chunk(4, &mut rng));
    for path in PATHS {
        for (solver, per_step) in solvers(6) {
            let mut field = Known::new(|_: &ActionChunk, _| end.clone());
            let found = solve(&mut field, path, vec![noise.clone()], &solver);
            assert_eq!(found.states, std::slice::from_ref(&end), "{}", solver.name());
            assert_eq!(found.evaluations, 5 * per_step + 1);
            assert_eq!(field.asked.len(), found.evaluations);
            let latest = field.asked.iter().fold(0.0, |latest: f64, (t, _)| latest.max(*t));
            assert!((latest - 5.0 / 6.0).abs() < 1e-15, "{} asked at {latest}", solver.name());
        }
    }
}

#[test]
fn one_euler_step_of_a_twist_follows_it_for_a_unit_of_time() {
    let mut rng = rng(19);
    let noise = chunk(3, &mut rng);
    let twist = BodyTwist::new(Vector3::new(0.4, -0.7, 0.2), Vector3::new(0.1, 0.2, -0.3));
    for path in PATHS {
        let mut field = Twisting::new(|_: &Action, t: f64| {
            assert_eq!(t, 0.0);
            ActionVelocity { twist, opening: 0.25 }
        });
        let solver = Solver::Euler { steps: 1 };
        let found = integrate(&mut Flow::Twist(&mut field), path, vec![noise.clone()], &solver);
        let expected = mapped(&noise, |action| Action {
            world_from_gripper: match path {
                Path::Screw => action.world_from_gripper.plus(&twist),
                Path::Product => action.world_from_gripper.plus_product(&twist),
            },
            opening: action.opening + 0.25,
        });
        let found = found.expect("the field cannot fail");
        assert!(apart(&found.states[0], &expected) < 1e-14);
        assert_eq!([found.evaluations, field.asked], [1; 2]);
    }
}

#[test]
fn openings_converge_with_order_one_by_themselves() {
    // The poses' errors could hide these: y′ = λ y by S steps of Euler is y (1 + λ/S)^S exactly.
    let noise = chunk(3, &mut rng(14));
    let truth = ThreeScrews { settles: false };
    for steps in [1, 4, 33] {
        let mut field = Known::new(|state: &ActionChunk, t| truth.endpoint(Path::Screw, state, t));
        let found = solve(&mut field, Path::Screw, vec![noise.clone()], &Solver::Euler { steps });
        let factor = (1.0 + GROWTH / steps as f64).powi(steps as i32);
        for (start, end) in noise.iter().zip(found.states[0].iter()) {
            assert!((end.opening - start.opening * factor).abs() < 1e-13);
        }
    }
}

#[test]
fn every_scene_of_a_batch_is_integrated_by_itself() {
    let mut rng = rng(15);
    let truth = ThreeScrews { settles: false };
    // Scenes of different horizons: nothing says that they have to be alike.
    let noise: Vec<_> = [4, 2, 7].map(|horizon| chunk(horizon, &mut rng)).to_vec();
    for path in PATHS {
        for (solver, _) in solvers(7) {
            let run = |noise: Vec<ActionChunk>| {
                let mut field = Known::new(|state: &ActionChunk, t| truth.endpoint(path, state, t));
                solve(&mut field, path, noise, &solver).states
            };
            let together = run(noise.clone());
            let alone: Vec<_> = noise.iter().flat_map(|one| run(vec![one.clone()])).collect();
            assert_eq!(together, alone);
            assert!(run(Vec::new()).is_empty(), "no scene at all");
        }
    }
}

#[test]
fn moved_noise_under_a_moved_field_gives_moved_trajectories() {
    let mut rng = rng(16);
    let (noise, goal, world) = (chunk(4, &mut rng), chunk(4, &mut rng), pose(&mut rng));
    for path in PATHS {
        for (solver, _) in solvers(10) {
            // Halfway between the state and a goal, so that both matter.
            let run = |noise: ActionChunk, goal: ActionChunk| {
                let halfway = |state: &ActionChunk, _| path.at(state, &goal, 0.5).expect("equal horizons");
                solve(&mut Known::new(halfway), path, vec![noise], &solver).states.remove(0)
            };
            let expected = moved(&world, &run(noise.clone(), goal.clone()));
            let found = run(moved(&world, &noise), moved(&world, &goal));
            assert!(apart(&found, &expected) < 1e-11);
            let still = run(noise.clone(), moved(&world, &goal));
            assert!(apart(&still, &expected) > 1e-3, "control: noise that stays behind leads elsewhere");
        }
    }
}

#[test]
fn no_step_is_refused_before_anything_is_asked() {
    let noise = vec![chunk(2, &mut rng(17))];
    for (solver, _) in solvers(0) {
        let mut field = Known::new(|state: &ActionChunk, _| state.clone());
        let found = integrate(&mut Flow::Endpoint(&mut field), Path::Screw, noise.clone(), &solver);
        assert_eq!(found, Err(FlowError::NoSteps));
        assert!(field.asked.is_empty());
    }
}
