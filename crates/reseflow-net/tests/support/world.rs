//! Changes of the world frame: rigid motions, and the reflections that the network must not commute with.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use reseflow_lie::{Matrix3, SO3, Vector3};
use reseflow_net::GripperState;

/// x ↦ turn·x + shift; a rigid motion where det turn = 1, a reflection and a rigid motion where it is −1.
#[derive(Debug, Clone)]
pub(crate) struct World {
    pub(crate) turn: Matrix3<f64>,
    pub(crate) shift: Vector3<f64>,
}

impl World {
    pub(crate) fn identity() -> World {
        World { turn: Matrix3::identity(), shift: Vector3::zeros() }
    }

    /// A rotation drawn uniformly, and a translation of up to 2 m along each axis.
    pub(crate) fn rigid(rng: &mut ChaCha8Rng) -> World {
        let turn = SO3::sample_haar(rng).matrix();
        World { turn, shift: Vector3::from_fn(|_, _| rng.random_range(-2.0..2.0)) }
    }

    /// A rigid motion after a reflection.
    pub(crate) fn reflection(rng: &mut ChaCha8Rng) -> World {
        let World { turn, shift } = World::rigid(rng);
        World { turn: turn * Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, 1.0)), shift }
    }

    pub(crate) fn point(&self, point: &[f64; 3]) -> [f64; 3] {
        (self.turn * Vector3::from(*point) + self.shift).into()
    }

    pub(crate) fn vector(&self, vector: &[f64; 3]) -> [f64; 3] {
        (self.turn * Vector3::from(*vector)).into()
    }

    pub(crate) fn gripper(&self, state: &GripperState) -> GripperState {
        GripperState {
            columns: state.columns.map(|column| self.vector(&column)),
            position_m: self.point(&state.position_m),
            opening: state.opening,
        }
    }

    /// The rotation whose first two columns are the moved ones of `rotation`: turn·R for a rigid motion.
    pub(crate) fn rotation(&self, rotation: &Matrix3<f64>) -> Matrix3<f64> {
        let handedness = self.turn.determinant().signum();
        self.turn * rotation * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, handedness))
    }
}
