//! The irreducible representations of SO(3): real spherical harmonics, Wigner matrices, real Clebsch–Gordan coefficients; f64, host.
//!
//! **Basis**, the same everywhere, and e3nn's: the components of degree l are ordered m = −l … l, and y is the polar axis. So degree
//! 1 is (x, y, z) itself, and D¹(R) = R. With θ from y, and φ in the z-x plane from z towards x, component m is proportional to
//! P_l^|m|(cos θ) times sin |m|φ for m < 0, times cos mφ for m ≥ 0, without the Condon–Shortley sign. Degree 2 is proportional to
//! (xz, xy, y² − (x² + z²)/2, yz, (z² − x²)/2).
//!
//! **Normalisation**: harmonics have ‖Yˡ‖² = 2l + 1 on the unit sphere ("component"), coefficients of one triple have squares
//! that sum to one. `scripts/irreps_golden.py` makes the values of e3nn that both are compared with.

mod clebsch_gordan;
mod spherical_harmonics;
mod wigner;

pub use clebsch_gordan::{ClebschGordan, clebsch_gordan};
pub use spherical_harmonics::spherical_harmonics_into;
pub use wigner::{WignerMatrices, rotation_to_polar};

/// The components of degree l, 2l + 1.
pub const fn components(degree: usize) -> usize {
    2 * degree + 1
}

/// The components of all degrees up to l_max, (l_max + 1)².
pub const fn components_up_to(max_degree: usize) -> usize {
    (max_degree + 1) * (max_degree + 1)
}
