//! Fields given by functions, and flows whose solution is known in closed form.

use reseflow_data::{Action, ActionChunk};
use reseflow_flow::{ActionVelocity, ChunkVelocity, DriftField, FlowError, Path, TwistField};
use reseflow_lie::{BodyTwist, SE3, Vector3};

/// An endpoint field given by a function from one state and the flow time, which remembers what it was asked.
pub(crate) struct Known<F> {
    endpoint: F,
    /// The times and states of every evaluation.
    pub(crate) asked: Vec<(f64, Vec<ActionChunk>)>,
}

impl<F: Fn(&ActionChunk, f64) -> ActionChunk> Known<F> {
    pub(crate) fn new(endpoint: F) -> Known<F> {
        Known { endpoint, asked: Vec::new() }
    }
}

impl<F: Fn(&ActionChunk, f64) -> ActionChunk> DriftField for Known<F> {
    fn endpoints(&mut self, states: &[ActionChunk], t: f64) -> Result<Vec<ActionChunk>, FlowError> {
        self.asked.push((t, states.to_vec()));
        Ok(states.iter().map(|state| (self.endpoint)(state, t)).collect())
    }
}

/// A twist field given by a function from one action and the flow time, which counts its evaluations.
pub(crate) struct Twisting<F> {
    velocity: F,
    /// Evaluations so far.
    pub(crate) asked: usize,
}

impl<F: Fn(&Action, f64) -> ActionVelocity> Twisting<F> {
    pub(crate) fn new(velocity: F) -> Twisting<F> {
        Twisting { velocity, asked: 0 }
    }
}

impl<F: Fn(&Action, f64) -> ActionVelocity> TwistField for Twisting<F> {
    fn velocities(&mut self, states: &[ActionChunk], t: f64) -> Result<Vec<ChunkVelocity>, FlowError> {
        self.asked += 1;
        let chunk = |state: &ActionChunk| {
            ChunkVelocity(state.iter().map(|action| (self.velocity)(action, t)).collect())
        };
        Ok(states.iter().map(chunk).collect())
    }
}

pub(crate) fn mapped(state: &ActionChunk, action: impl Fn(&Action) -> Action) -> ActionChunk {
    ActionChunk(state.iter().map(action).collect())
}

/// Growth rate of the openings.
pub(crate) const GROWTH: f64 = -0.8;

/// H(t) = Exp(c t) H⁰ Exp(a f(t)) Exp(b t), where nothing commutes and the drift depends on the state:
/// ξ_b = Ad_{H⁻¹} c + f′(t) Ad(Exp(−b t)) a + b. The openings follow y′ = λ f′(t) y.
pub(crate) struct ThreeScrews {
    /// Whether f(t) = 1 − (1 − t)⁴, so that the drift settles towards the end, instead of f(t) = t.
    pub(crate) settles: bool,
}

impl ThreeScrews {
    fn a() -> BodyTwist {
        BodyTwist::new(Vector3::new(0.5, -0.2, 0.3), Vector3::new(0.2, 0.3, -0.1))
    }

    fn b() -> BodyTwist {
        BodyTwist::new(Vector3::new(-0.3, 0.6, 0.4), Vector3::new(-0.2, 0.1, 0.4))
    }

    /// c, read as a spatial twist; none where the drift has to settle.
    fn c(&self) -> BodyTwist {
        if self.settles {
            return BodyTwist::zero();
        }
        BodyTwist::new(Vector3::new(0.4, 0.3, -0.5), Vector3::new(-0.1, 0.2, 0.1))
    }

    /// f and f′.
    fn share(&self, t: f64) -> [f64; 2] {
        if self.settles { [1.0 - (1.0 - t).powi(4), 4.0 * (1.0 - t).powi(3)] } else { [t, 1.0] }
    }

    pub(crate) fn velocity(&self, action: &Action, t: f64) -> ActionVelocity {
        let [_, rate] = self.share(t);
        let body_from_world = action.world_from_gripper.inverse().adjoint();
        let twist = body_from_world * self.c().vector6()
            + SE3::exp(&(Self::b() * -t)).adjoint() * Self::a().vector6() * rate
            + Self::b().vector6();
        ActionVelocity { twist: BodyTwist::from_vector6(&twist), opening: action.opening * GROWTH * rate }
    }

    /// The endpoint at which the displacement along `path` over 1 − t is the drift wanted.
    pub(crate) fn endpoint(&self, path: Path, state: &ActionChunk, t: f64) -> ActionChunk {
        mapped(state, |action| {
            let velocity = self.velocity(action, t);
            let rest = velocity.twist * (1.0 - t);
            let world_from_gripper = match path {
                Path::Screw => action.world_from_gripper.plus(&rest),
                Path::Product => action.world_from_gripper.plus_product(&rest),
            };
            Action { world_from_gripper, opening: action.opening + velocity.opening * (1.0 - t) }
        })
    }

    pub(crate) fn solution(&self, noise: &ActionChunk) -> ActionChunk {
        let (before, after) = (SE3::exp(&self.c()), SE3::exp(&Self::a()) * SE3::exp(&Self::b()));
        mapped(noise, |action| Action {
            world_from_gripper: before * action.world_from_gripper * after,
            opening: action.opening * GROWTH.exp(),
        })
    }
}
