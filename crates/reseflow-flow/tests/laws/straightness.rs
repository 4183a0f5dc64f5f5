//! Straightness: zero for flows along the path's own geodesics, and what one finds with a pencil for one that speeds up.

use reseflow_data::{Action, ActionChunk};
use reseflow_flow::{ActionVelocity, Flow, FlowError, Path, Solver, Straightness, integrate, straightness};
use reseflow_lie::{BodyTwist, Vector3};

use crate::known::{Known, ThreeScrews, Twisting};
use crate::{PATHS, chunk, moved, pose, rng};

#[test]
fn a_flow_along_the_geodesics_is_straight() {
    let mut rng = rng(91);
    for path in PATHS {
        let noise = [chunk(5, &mut rng), chunk(3, &mut rng)];
        let ends = [chunk(5, &mut rng), chunk(3, &mut rng)];
        let mut field = Known::new(|state: &ActionChunk, _| ends[usize::from(state.len() == 3)].clone());
        let found = straightness(&mut Flow::Endpoint(&mut field), path, &noise, 20);
        let found = found.expect("the field cannot fail");
        assert!(found.relative < 1e-20 && found.absolute < 1e-18, "{path:?}: {found:?}");
        assert_eq!(field.asked.len(), 20);
    }
}

#[test]
fn a_flow_along_the_other_geodesics_is_not() {
    // Control: the velocities of straight lines, measured as screws.
    let mut rng = rng(92);
    let (noise, end) = (chunk(1, &mut rng), chunk(1, &mut rng));
    for (flows, measured, straight) in [
        (Path::Product, Path::Product, true),
        (Path::Product, Path::Screw, false),
        (Path::Screw, Path::Screw, true),
        (Path::Screw, Path::Product, false),
    ] {
        let mut field =
            Twisting::new(|_: &Action, t: f64| flows.velocity(&noise, &end, t).expect("equal horizons").0[0]);
        let found = straightness(&mut Flow::Twist(&mut field), measured, std::slice::from_ref(&noise), 200);
        let relative = found.expect("the field cannot fail").relative;
        println!("{flows:?} measured as {measured:?}: {relative:.1e}");
        // Euler's own error in 200 steps of the other chart stays far below a true bend.
        assert_eq!(relative < 1e-4, straight, "{relative:e}");
    }
}

#[test]
fn a_flow_that_speeds_up_steadily_is_a_third_off() {
    // ξ(t) = 2t ξ: ∫(2t − 1)² dt = 1/3. In S Euler steps ξ̄ = (1 − 1/S) ξ and the mean square about it is (1 − 1/S²)/3.
    let twist = BodyTwist::new(Vector3::new(0.3, -0.4, 0.5), Vector3::new(0.1, 0.2, -0.1));
    let whole = ActionVelocity { twist, opening: 0.6 };
    let noise = chunk(3, &mut rng(93));
    for steps in [1, 2, 10, 1000] {
        let mut field = Twisting::new(|_: &Action, t: f64| whole * (2.0 * t));
        let found =
            straightness(&mut Flow::Twist(&mut field), Path::Screw, std::slice::from_ref(&noise), steps);
        let found = found.expect("the field cannot fail");
        let count = steps as f64;
        let absolute = whole.squared_norm() * (1.0 - count.powi(-2)) / 3.0;
        assert!((found.absolute - absolute).abs() < 1e-12, "{found:?} in {steps} steps");
        let way = whole.squared_norm() * (1.0 - 1.0 / count).powi(2);
        let relative = if steps == 1 { 0.0 } else { absolute / way };
        assert!((found.relative - relative).abs() < 1e-12, "{found:?} in {steps} steps");
        if steps == 1000 {
            assert!((found.relative - 1.0 / 3.0).abs() < 1e-3);
        }
    }
}

#[test]
fn the_measure_is_that_of_the_definition_and_stays_in_a_moved_world() {
    let truth = ThreeScrews { settles: false };
    let mut rng = rng(94);
    let noise = chunk(4, &mut rng);
    let steps = 400;
    let measure = |noise: &ActionChunk| {
        let mut field = Twisting::new(|action: &Action, t: f64| truth.velocity(action, t));
        straightness(&mut Flow::Twist(&mut field), Path::Screw, std::slice::from_ref(noise), steps)
            .expect("the field cannot fail")
    };
    // The integral along the exact trajectory, at every hundredth.
    let to = |end: f64| {
        let mut field = Twisting::new(|action: &Action, t: f64| truth.velocity(action, t * end) * end);
        let solver = Solver::Rk4 { steps: 20 };
        integrate(&mut Flow::Twist(&mut field), Path::Screw, vec![noise.clone()], &solver)
            .expect("the field cannot fail")
            .states
            .remove(0)
    };
    let ends = to(1.0);
    let (mut apart, mut way) = (0.0, 0.0);
    for index in 0..100 {
        let t = (f64::from(index) + 0.5) / 100.0;
        let straight = Path::Screw.velocity(&noise, &ends, t).expect("equal horizons");
        for (state, straight) in to(t).iter().zip(&straight.0) {
            apart += (truth.velocity(state, t) - *straight).squared_norm() / 100.0;
            way += straight.squared_norm() / 100.0;
        }
    }
    let found = measure(&noise);
    println!("measured {:.4}, by definition {:.4}", found.relative, apart / way);
    assert!((found.relative / (apart / way) - 1.0).abs() < 0.02, "{found:?} {}", apart / way);
    assert!((found.absolute / (apart / 4.0) - 1.0).abs() < 0.02);

    // Moved about with what drives it: the endpoints of the same flow.
    let goal = chunk(4, &mut rng);
    let bent = |noise: &ActionChunk, goal: &ActionChunk| {
        let mut field = Known::new(|state: &ActionChunk, t: f64| {
            Path::Screw.at(state, goal, 0.5 + 0.5 * t).expect("equal horizons")
        });
        straightness(&mut Flow::Endpoint(&mut field), Path::Screw, std::slice::from_ref(noise), 20)
            .expect("the field cannot fail")
            .relative
    };
    let world = pose(&mut rng);
    let (here, there) = (bent(&noise, &goal), bent(&moved(&world, &noise), &moved(&world, &goal)));
    assert!(here > 1e-3 && (here - there).abs() < 1e-10, "{here} {there}");
}

#[test]
fn standing_still_is_straight_and_no_step_is_refused() {
    let noise = [chunk(2, &mut rng(95))];
    let mut field = Known::new(|state: &ActionChunk, _| state.clone());
    let found = straightness(&mut Flow::Endpoint(&mut field), Path::Screw, &noise, 5);
    assert_eq!(found, Ok(Straightness { absolute: 0.0, relative: 0.0 }));
    let none = straightness(&mut Flow::Endpoint(&mut field), Path::Screw, &noise, 0);
    assert_eq!(none, Err(FlowError::NoSteps));
}
