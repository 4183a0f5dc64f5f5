//! A field that fails, answers for too few or answers with no number is reported, whoever asks.

use reseflow_data::{Action, ActionChunk};
use reseflow_flow::{
    ActionVelocity, AdaptiveConfig, ChunkVelocity, DriftField, Flow, FlowError, Path, Solver, TwistField,
    integrate, straightness,
};

use crate::{apart, chunk, rng};

const SOLVERS: [Solver; 5] = [
    Solver::Euler { steps: 3 },
    Solver::Midpoint { steps: 3 },
    Solver::Heun { steps: 3 },
    Solver::Rk4 { steps: 3 },
    Solver::DormandPrince(AdaptiveConfig { rtol: 1e-4, atol: 1e-6, max_steps: 100 }),
];

/// Stands still, and spoils its answer from its second evaluation on.
struct Spoilt<A> {
    spoil: fn(&mut Vec<A>),
    asked: usize,
}

impl<A> Spoilt<A> {
    fn answer(&mut self, mut answer: Vec<A>) -> Vec<A> {
        self.asked += 1;
        if self.asked > 1 {
            (self.spoil)(&mut answer);
        }
        answer
    }
}

impl DriftField for Spoilt<ActionChunk> {
    fn endpoints(&mut self, states: &[ActionChunk], _: f64) -> Result<Vec<ActionChunk>, FlowError> {
        Ok(self.answer(states.to_vec()))
    }
}

impl TwistField for Spoilt<ChunkVelocity> {
    fn velocities(&mut self, states: &[ActionChunk], _: f64) -> Result<Vec<ChunkVelocity>, FlowError> {
        let still = |state: &ActionChunk| ChunkVelocity(vec![ActionVelocity::zero(); state.len()]);
        Ok(self.answer(states.iter().map(still).collect()))
    }
}

fn noise() -> Vec<ActionChunk> {
    let mut rng = rng(71);
    vec![chunk(4, &mut rng), chunk(4, &mut rng), chunk(4, &mut rng)]
}

fn fault<T: std::fmt::Debug>(found: Result<T, FlowError>) -> String {
    match found {
        Err(FlowError::Field(fault)) => fault,
        other => panic!("expected a fault of the field, got {other:?}"),
    }
}

#[test]
fn endpoints_that_are_not_one_for_each_action_are_a_fault_of_the_field() {
    type Spoil = fn(&mut Vec<ActionChunk>);
    let cases: [(Spoil, &str); 6] = [
        (|chunks| chunks.truncate(2), "2 scenes, expected 3"),
        (|chunks| chunks.push(ActionChunk::default()), "4 scenes, expected 3"),
        (|chunks| chunks[1].0.truncate(3), "3 actions for scene 1, expected 4"),
        (|chunks| chunks[2].0.push(spare()), "5 actions for scene 2, expected 4"),
        (|chunks| chunks[0].0[3].opening = f64::NAN, "action 3 of scene 0 is not finite"),
        (
            |chunks| chunks[2].0[1].world_from_gripper.translation.y = f64::INFINITY,
            "action 1 of scene 2 is not finite",
        ),
    ];
    for (spoil, expected) in cases {
        for solver in SOLVERS {
            let mut field = Spoilt { spoil, asked: 0 };
            let found = fault(integrate(&mut Flow::Endpoint(&mut field), Path::Screw, noise(), &solver));
            assert!(found.contains(expected), "{}: {found}", solver.name());
            assert_eq!(field.asked, 2, "nothing is asked after a fault");
        }
        let mut field = Spoilt { spoil, asked: 0 };
        let found = fault(straightness(&mut Flow::Endpoint(&mut field), Path::Screw, &noise(), 3));
        assert!(found.contains(expected), "{found}");
    }
}

#[test]
fn velocities_that_are_not_one_for_each_action_are_a_fault_of_the_field() {
    type Spoil = fn(&mut Vec<ChunkVelocity>);
    let cases: [(Spoil, &str); 3] = [
        (|chunks| chunks.truncate(2), "2 scenes, expected 3"),
        (|chunks| chunks[1].0.truncate(3), "3 actions for scene 1, expected 4"),
        (|chunks| chunks[0].0[3].twist.angular.z = f64::NAN, "action 3 of scene 0 is not finite"),
    ];
    for (spoil, expected) in cases {
        for solver in SOLVERS {
            let mut field = Spoilt { spoil, asked: 0 };
            let found = fault(integrate(&mut Flow::Twist(&mut field), Path::Screw, noise(), &solver));
            assert!(found.contains(expected), "{}: {found}", solver.name());
        }
    }
}

#[test]
fn a_field_that_fails_is_reported_in_its_own_words() {
    /// Fails at its second evaluation.
    struct Failing(usize);
    impl DriftField for Failing {
        fn endpoints(&mut self, states: &[ActionChunk], _: f64) -> Result<Vec<ActionChunk>, FlowError> {
            self.0 += 1;
            if self.0 < 2 { Ok(states.to_vec()) } else { Err(FlowError::Field("out of range".to_owned())) }
        }
    }
    for solver in SOLVERS {
        let found = integrate(&mut Flow::Endpoint(&mut Failing(0)), Path::Screw, noise(), &solver);
        assert_eq!(found, Err(FlowError::Field("out of range".to_owned())));
    }
    assert!(FlowError::Field("out of range".to_owned()).to_string().contains("out of range"));
}

#[test]
fn a_field_that_answers_as_it_should_passes() {
    // Control: the same field unspoilt.
    for solver in SOLVERS {
        let mut field = Spoilt { spoil: |_: &mut Vec<ActionChunk>| (), asked: 0 };
        let found = integrate(&mut Flow::Endpoint(&mut field), Path::Screw, noise(), &solver);
        let found = found.expect("the field is right").states;
        for (found, noise) in found.iter().zip(noise()) {
            assert!(apart(found, &noise) < 1e-13, "{}", solver.name());
        }
    }
}

fn spare() -> Action {
    chunk(1, &mut rng(72)).0[0]
}
