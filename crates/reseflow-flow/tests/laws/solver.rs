//! Euler on the group: exact where it must be, of order 1 on a field with a known solution, equivariant.

use reseflow_data::{Action, ActionChunk};
use reseflow_flow::{DriftField, FlowError, ScrewPath, integrate_euler};
use reseflow_lie::{BodyTwist, SE3, Vector3};

use crate::{apart, chunk, moved, pose, rng};

/// A field given by a function from one state and the flow time, which remembers what it was asked.
struct Known<F> {
    endpoint: F,
    asked: Vec<(f64, Vec<ActionChunk>)>,
}

impl<F: Fn(&ActionChunk, f64) -> ActionChunk> Known<F> {
    fn new(endpoint: F) -> Known<F> {
        Known { endpoint, asked: Vec::new() }
    }
}

impl<F: Fn(&ActionChunk, f64) -> ActionChunk> DriftField for Known<F> {
    fn endpoints(&mut self, states: &[ActionChunk], t: f64) -> Result<Vec<ActionChunk>, FlowError> {
        self.asked.push((t, states.to_vec()));
        Ok(states.iter().map(|state| (self.endpoint)(state, t)).collect())
    }
}

fn mapped(state: &ActionChunk, action: impl Fn(&Action) -> Action) -> ActionChunk {
    ActionChunk(state.iter().map(action).collect())
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
    let found = integrate_euler(&mut field, noise, 1).expect("the field cannot fail");
    assert_eq!(found.states, expected, "to the last bit");
    assert_eq!(found.evaluations, 1);
}

#[test]
fn a_constant_endpoint_is_reached_along_the_screw_in_any_number_of_steps() {
    let mut rng = rng(12);
    for steps in [1, 2, 3, 7, 10, 100] {
        let (noise, end) = (chunk(5, &mut rng), chunk(5, &mut rng));
        let mut field = Known::new(|_: &ActionChunk, _| end.clone());
        let found = integrate_euler(&mut field, vec![noise.clone()], steps).expect("the field cannot fail");
        assert_eq!(found.states, std::slice::from_ref(&end));
        assert_eq!([found.evaluations, field.asked.len()], [steps; 2]);
        for (index, (t, states)) in field.asked.iter().enumerate() {
            assert!((t - index as f64 / steps as f64).abs() < 1e-15, "a uniform grid");
            let off = apart(&states[0], &ScrewPath.at(&noise, &end, *t));
            assert!(off < 1e-11, "{off:e} off the screw at {t}");
        }
    }
}

/// The body twists of H(t) = H⁰ Exp(a t) Exp(b t), which do not commute: ω(t) = Ad(Exp(−b t)) a + b.
struct TwoScrews {
    a: BodyTwist,
    b: BodyTwist,
}

/// Growth rate of the openings, y' = λ y.
const GROWTH: f64 = -0.8;

impl TwoScrews {
    fn new() -> TwoScrews {
        TwoScrews {
            a: BodyTwist::new(Vector3::new(0.9, -0.4, 0.5), Vector3::new(0.2, 0.3, -0.1)),
            b: BodyTwist::new(Vector3::new(-0.3, 0.8, 0.6), Vector3::new(-0.2, 0.1, 0.4)),
        }
    }

    /// The endpoint at which log(H⁻¹ Ĥ) / (1 − t) is the drift wanted.
    fn endpoint(&self, state: &ActionChunk, t: f64) -> ActionChunk {
        let twist = SE3::exp(&(self.b * -t)).adjoint() * self.a.vector6() + self.b.vector6();
        let rest = SE3::exp(&(BodyTwist::from_vector6(&twist) * (1.0 - t)));
        mapped(state, |action| Action {
            world_from_gripper: action.world_from_gripper * rest,
            opening: action.opening * (1.0 + (1.0 - t) * GROWTH),
        })
    }

    fn solution(&self, noise: &ActionChunk) -> ActionChunk {
        let whole = SE3::exp(&self.a) * SE3::exp(&self.b);
        mapped(noise, |action| Action {
            world_from_gripper: action.world_from_gripper * whole,
            opening: action.opening * GROWTH.exp(),
        })
    }
}

#[test]
fn euler_converges_with_order_one() {
    let noise = chunk(4, &mut rng(13));
    let truth = TwoScrews::new();
    let solve = |steps: usize| {
        let mut field = Known::new(|state: &ActionChunk, t| truth.endpoint(state, t));
        integrate_euler(&mut field, vec![noise.clone()], steps)
            .expect("the field cannot fail")
            .states
            .remove(0)
    };
    let expected = truth.solution(&noise);
    let errors: Vec<(usize, f64)> =
        [16, 32, 64, 128, 256, 512].map(|steps| (steps, apart(&solve(steps), &expected))).to_vec();
    for pair in errors.windows(2) {
        let order = (pair[0].1 / pair[1].1).log2();
        assert!((order - 1.0).abs() < 0.1, "order {order} between {pair:?}");
    }
    let finest = apart(&solve(4096), &expected);
    assert!(finest < 1e-3 && finest > 0.0, "4096 steps are off by {finest:e}");
}

#[test]
fn openings_converge_with_order_one_by_themselves() {
    // The poses' errors could hide these: y' = λ y by S steps is y (1 + λ/S)^S exactly.
    let noise = chunk(3, &mut rng(14));
    let truth = TwoScrews::new();
    for steps in [1, 4, 33] {
        let mut field = Known::new(|state: &ActionChunk, t| truth.endpoint(state, t));
        let found = integrate_euler(&mut field, vec![noise.clone()], steps).expect("the field cannot fail");
        let factor = (1.0 + GROWTH / steps as f64).powi(steps as i32);
        for (start, end) in noise.iter().zip(found.states[0].iter()) {
            assert!((end.opening - start.opening * factor).abs() < 1e-13);
        }
    }
}

#[test]
fn every_scene_of_a_batch_is_integrated_by_itself() {
    let mut rng = rng(15);
    let truth = TwoScrews::new();
    let noise: Vec<_> = (0..3).map(|_| chunk(4, &mut rng)).collect();
    let solve = |noise: Vec<ActionChunk>| {
        let mut field = Known::new(|state: &ActionChunk, t| truth.endpoint(state, t));
        integrate_euler(&mut field, noise, 7).expect("the field cannot fail").states
    };
    let together = solve(noise.clone());
    let alone: Vec<_> = noise.into_iter().flat_map(|one| solve(vec![one])).collect();
    assert_eq!(together, alone);
}

#[test]
fn moved_noise_under_a_moved_field_gives_moved_trajectories() {
    let mut rng = rng(16);
    let (noise, goal, world) = (chunk(4, &mut rng), chunk(4, &mut rng), pose(&mut rng));
    // Halfway between the state and a goal, so that both matter.
    let solve = |noise: ActionChunk, goal: ActionChunk| {
        let mut field = Known::new(|state: &ActionChunk, _| ScrewPath.at(state, &goal, 0.5));
        integrate_euler(&mut field, vec![noise], 10).expect("the field cannot fail").states.remove(0)
    };
    let expected = moved(&world, &solve(noise.clone(), goal.clone()));
    let found = solve(moved(&world, &noise), moved(&world, &goal));
    assert!(apart(&found, &expected) < 1e-11);
    let still = solve(noise, moved(&world, &goal));
    assert!(apart(&still, &expected) > 1e-3, "control: noise that stays behind leads elsewhere");
}

#[test]
fn no_step_is_refused_and_a_failing_field_is_reported() {
    let noise = vec![chunk(2, &mut rng(17))];
    let mut field = Known::new(|state: &ActionChunk, _| state.clone());
    assert_eq!(integrate_euler(&mut field, noise.clone(), 0), Err(FlowError::NoSteps));
    assert!(field.asked.is_empty());

    /// Fails at its second evaluation.
    struct Failing(usize);
    impl DriftField for Failing {
        fn endpoints(&mut self, states: &[ActionChunk], _: f64) -> Result<Vec<ActionChunk>, FlowError> {
            self.0 += 1;
            if self.0 < 2 { Ok(states.to_vec()) } else { Err(FlowError::Field("out of range".to_owned())) }
        }
    }
    let error = integrate_euler(&mut Failing(0), noise, 5).expect_err("the field fails");
    assert_eq!(error, FlowError::Field("out of range".to_owned()));
    assert!(error.to_string().contains("out of range"));
}
