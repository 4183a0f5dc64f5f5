//! Trajectory tokens: the flow's state as vectors and scalars, relative to the scene's centroid.

use burn::tensor::{Device, Tensor};

use crate::NetError;
use crate::error::check_numbers;
use crate::scene_batch::floats;

/// Offsets in a scene are given over this length, which makes them comparable with unit vectors.
pub(crate) const OFFSET_SCALE_M: f64 = 0.1;

/// Octaves of the time embedding.
const OCTAVES: usize = 8;

/// Vectors of a token: its columns and its position.
pub(crate) const TOKEN_VECTORS: usize = 4;

/// Width of [`fourier`] features.
pub(crate) const FOURIER_WIDTH: usize = 2 * OCTAVES;

/// A gripper pose and opening, world frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GripperState {
    /// The columns of the rotation world_from_gripper.
    pub columns: [[f64; 3]; 3],
    /// The gripper's origin, metres.
    pub position_m: [f64; 3],
    /// The opening, 0 closed to 1 open.
    pub opening: f64,
}

impl GripperState {
    /// Refuses numbers that are none or too large; the state is the `index`th `what`.
    pub(crate) fn check(&self, what: &'static str, index: usize) -> Result<(), NetError> {
        let columns = self.columns.into_iter().flatten();
        check_numbers(what, index, columns.chain(self.position_m).chain([self.opening]))
    }
}

/// L tokens for each of B scenes.
#[derive(Debug, Clone)]
pub struct TokenBatch {
    /// Columns of R^t and the position over the offset scale relative to the centroid, `[3, B·L, 4]`.
    pub vectors: Tensor<3>,
    /// Time features and the opening, `[B·L, 17]`.
    pub scalars: Tensor<2>,
    /// Tokens per scene, L.
    pub horizon: usize,
}

impl TokenBatch {
    /// Puts B trajectories of L states, at one flow time each, in the frames of `origins_m`.
    ///
    /// # Errors
    /// [`NetError::Mismatch`] where counts differ, [`NetError::NonFinite`] and [`NetError::OutOfRange`] naming the token, the flow
    /// time or the origin that has a number that is not finite or beyond 1e6.
    pub fn new(
        trajectories: &[Vec<GripperState>],
        times: &[f64],
        origins_m: &[[f64; 3]],
        device: &Device,
    ) -> Result<Self, NetError> {
        let scenes = origins_m.len();
        for (what, got) in [("trajectories", trajectories.len()), ("flow times", times.len())] {
            if got != scenes {
                return Err(NetError::Mismatch { what, expected: scenes, got });
            }
        }
        let horizon = trajectories.first().map_or(0, Vec::len);
        if let Some(odd) = trajectories.iter().find(|trajectory| trajectory.len() != horizon) {
            return Err(NetError::Mismatch {
                what: "tokens of a trajectory",
                expected: horizon,
                got: odd.len(),
            });
        }
        for (index, state) in trajectories.iter().flatten().enumerate() {
            state.check("token", index)?;
        }
        for (index, (&time, origin_m)) in times.iter().zip(origins_m).enumerate() {
            check_numbers("flow time", index, [time])?;
            check_numbers("origin", index, *origin_m)?;
        }
        let states = || {
            (trajectories.iter().zip(origins_m))
                .flat_map(|(trajectory, origin)| trajectory.iter().map(move |s| (s, origin)))
        };
        let vectors = (0..3)
            .flat_map(|axis| states().flat_map(move |(state, origin)| gripper_vectors(state, origin, axis)));
        let vectors = vectors.collect();
        let mut scalars = Vec::with_capacity(scenes * horizon * (FOURIER_WIDTH + 1));
        for (trajectory, &time) in trajectories.iter().zip(times) {
            let features = fourier(time);
            for state in trajectory {
                scalars.extend_from_slice(&features);
                scalars.push(state.opening);
            }
        }
        Ok(Self {
            vectors: floats(vectors, [3, scenes * horizon, TOKEN_VECTORS], device),
            scalars: floats(scalars, [scenes * horizon, FOURIER_WIDTH + 1], device),
            horizon,
        })
    }
}

/// One component of a gripper's three columns and of its offset from `origin` over the offset scale.
pub(crate) fn gripper_vectors(state: &GripperState, origin: &[f64; 3], axis: usize) -> [f64; 4] {
    let [x, y, z] = state.columns.map(|column| column[axis]);
    [x, y, z, (state.position_m[axis] - origin[axis]) / OFFSET_SCALE_M]
}

/// Cosines and sines of a number in \[0, 1\] at doubling frequencies.
pub(crate) fn fourier(value: f64) -> [f64; FOURIER_WIDTH] {
    std::array::from_fn(|index| {
        let angle = value * std::f64::consts::FRAC_PI_2 * (1u32 << (index % OCTAVES)) as f64;
        if index < OCTAVES { angle.cos() } else { angle.sin() }
    })
}
