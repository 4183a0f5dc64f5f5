//! The scalar functions of an angle that multiply the powers of [ω]× in exponentials and Jacobians.
//!
//! Each has a closed form that cancels near θ = 0. Below θ = π, which holds every principal logarithm, they are
//! evaluated by series long enough for a relative error of about 1e-15; above it the closed forms no longer cancel.

use std::f64::consts::PI;

/// Terms kept of the alternating series. At θ = π the first one left out is below 1e-20 of the sum.
const TERMS: usize = 16;

/// 1/n! for n = 0 … 2·[`TERMS`] + 4.
const INVERSE_FACTORIALS: [f64; 2 * TERMS + 5] = inverse_factorials();

const fn inverse_factorials() -> [f64; 2 * TERMS + 5] {
    let mut inverse = [1.0; 2 * TERMS + 5];
    let mut factorial = 1.0;
    let mut n = 1;
    while n < inverse.len() {
        factorial *= n as f64;
        inverse[n] = 1.0 / factorial;
        n += 1;
    }
    inverse
}

/// Σ_{k ≥ 0} (−1)ᵏ weight(k) θ²ᵏ / (2k + offset)!, by Horner's scheme.
fn alternating_series(theta: f64, offset: usize, weight: impl Fn(usize) -> f64) -> f64 {
    let square = theta * theta;
    (0..TERMS).rev().fold(0.0, |sum, k| weight(k) * INVERSE_FACTORIALS[2 * k + offset] - square * sum)
}

/// sin(θ)/θ; nothing cancels, only 0/0 needs care.
pub(crate) fn sinc(theta: f64) -> f64 {
    if theta == 0.0 { 1.0 } else { theta.sin() / theta }
}

/// (1 − cos θ)/θ² = ½ sinc²(θ/2).
pub(crate) fn one_minus_cos_over_square(theta: f64) -> f64 {
    0.5 * sinc(0.5 * theta).powi(2)
}

/// (θ − sin θ)/θ³.
pub(crate) fn theta_minus_sin_over_cube(theta: f64) -> f64 {
    if theta < PI { alternating_series(theta, 3, |_| 1.0) } else { (theta - theta.sin()) / theta.powi(3) }
}

/// (θ² + 2 cos θ − 2)/(2θ⁴).
pub(crate) fn second_order_coupling(theta: f64) -> f64 {
    if theta < PI {
        alternating_series(theta, 4, |_| 1.0)
    } else {
        (0.5 - one_minus_cos_over_square(theta)) / (theta * theta)
    }
}

/// (2θ − 3 sin θ + θ cos θ)/(2θ⁵).
pub(crate) fn third_order_coupling(theta: f64) -> f64 {
    if theta < PI {
        alternating_series(theta, 5, |k| (k + 1) as f64)
    } else {
        (2.0 * theta - 3.0 * theta.sin() + theta * theta.cos()) / (2.0 * theta.powi(5))
    }
}

/// (1 − (θ/2) cot(θ/2))/θ², the coefficient of [ω]×² in the inverse Jacobians; it has poles at θ = 2πk, k ≥ 1.
///
/// Below π it is Lambert's continued fraction x cot x = 1 − x²/(3 − x²/(5 − …)) at x = θ/2.
pub(crate) fn inverse_jacobian_square(theta: f64) -> f64 {
    let half = 0.5 * theta;
    if theta < PI {
        let square = half * half;
        let tail = [23.0, 21.0, 19.0, 17.0, 15.0, 13.0, 11.0, 9.0, 7.0, 5.0, 3.0];
        0.25 / tail.iter().fold(25.0, |denominator, odd| odd - square / denominator)
    } else {
        (1.0 - half * half.cos() / half.sin()) / (theta * theta)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Coefficient = fn(f64) -> f64;

    /// Computed with 60 digits by `scripts/lie_golden.py`, on both sides of the switch at π.
    #[test]
    fn coefficients_agree_with_sixty_digit_arithmetic() {
        let golden: serde_json::Value =
            serde_json::from_str(include_str!("../tests/golden/lie.json")).unwrap();
        let entries = golden["coefficients"].as_array().unwrap();
        assert!(entries.len() >= 20);
        let functions: [(&str, Coefficient); 5] = [
            ("one_minus_cos_over_square", one_minus_cos_over_square),
            ("theta_minus_sin_over_cube", theta_minus_sin_over_cube),
            ("second_order_coupling", second_order_coupling),
            ("third_order_coupling", third_order_coupling),
            ("inverse_jacobian_square", inverse_jacobian_square),
        ];
        for (name, function) in functions {
            let worst = entries
                .iter()
                .map(|entry| {
                    let want = entry[name].as_f64().unwrap();
                    (function(entry["theta"].as_f64().unwrap()) - want).abs() / want.abs()
                })
                .fold(0.0, f64::max);
            println!("{name}: largest relative error {worst:.1e}");
            assert!(worst < 2e-15, "{name}: relative error {worst}");
        }
    }

    #[test]
    fn coefficients_at_zero_are_their_limits() {
        assert_eq!(sinc(0.0), 1.0);
        assert_eq!(one_minus_cos_over_square(0.0), 0.5);
        assert_eq!(theta_minus_sin_over_cube(0.0), 1.0 / 6.0);
        assert_eq!(second_order_coupling(0.0), 1.0 / 24.0);
        assert_eq!(third_order_coupling(0.0), 1.0 / 120.0);
        assert_eq!(inverse_jacobian_square(0.0), 1.0 / 12.0);
    }
}
