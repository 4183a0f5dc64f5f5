//! Real spherical harmonics by the stable recurrence in the degree (Numerical Recipes 6.7), written for solid harmonics: polynomials,
//! so that nothing is singular at the poles.

use super::components_up_to;

/// Appends the harmonics of degrees 0 … `max_degree` at `point`, (l_max + 1)² numbers, degree by degree.
///
/// Yˡ is a homogeneous polynomial of degree l: on the unit sphere ‖Yˡ‖² = 2l + 1, elsewhere it scales with ‖point‖ˡ.
pub fn spherical_harmonics_into(max_degree: usize, point: &[f64; 3], out: &mut Vec<f64>) {
    // The polar axis is y; z and x span the equator.
    let [equator_sin, polar, equator_cos] = *point;
    let squared = point.iter().map(|value| value * value).sum::<f64>();
    let first = out.len();
    out.resize(first + components_up_to(max_degree), 0.0);
    let values = &mut out[first..];

    // Real and imaginary part of (z + i x)^m.
    let (mut cosine, mut sine) = (1.0, 0.0);
    // P_m^m = (2m − 1)!!, without sin^m θ, which (z + i x)^m brings.
    let mut diagonal = 1.0;
    for order in 0..=max_degree {
        if order > 0 {
            (cosine, sine) =
                (cosine * equator_cos - sine * equator_sin, sine * equator_cos + cosine * equator_sin);
            diagonal *= (2 * order - 1) as f64;
        }
        let (mut before, mut legendre) = (0.0, diagonal);
        for degree in order..=max_degree {
            if degree > order {
                let (l, m) = (degree as f64, order as f64);
                let next = ((2.0 * l - 1.0) * polar * legendre - (l + m - 1.0) * squared * before) / (l - m);
                (before, legendre) = (legendre, next);
            }
            let value = normalization(degree, order) * legendre;
            let centre = degree * degree + degree;
            values[centre + order] = value * cosine;
            if order > 0 {
                values[centre - order] = value * sine;
            }
        }
    }
}

/// √((2l + 1) (l − m)!/(l + m)!), times √2 for m > 0.
fn normalization(degree: usize, order: usize) -> f64 {
    let ratio: f64 = (degree - order + 1..=degree + order).map(|factor| 1.0 / factor as f64).product();
    let halves = if order > 0 { 2.0 } else { 1.0 };
    ((2 * degree + 1) as f64 * ratio * halves).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn degree_one_is_the_vector_and_degree_two_as_documented() {
        let [x, y, z] = [0.36, -0.48, 0.8];
        let mut values = Vec::new();
        spherical_harmonics_into(2, &[x, y, z], &mut values);
        let second =
            [x * z, x * y, (y * y - (x * x + z * z) / 2.0) / 3f64.sqrt(), y * z, (z * z - x * x) / 2.0];
        let expected = [1.0, 3f64.sqrt() * x, 3f64.sqrt() * y, 3f64.sqrt() * z];
        let expected = expected.into_iter().chain(second.map(|value| 15f64.sqrt() * value));
        for (value, expected) in values.iter().zip(expected) {
            assert!((value - expected).abs() < 1e-14, "{value} {expected}");
        }
    }

    #[test]
    fn the_squares_of_one_degree_sum_to_its_components_and_at_zero_only_degree_zero_is_left() {
        for point in [[0.0, 1.0, 0.0], [0.6, 0.0, -0.8], [2.0 / 7.0, -3.0 / 7.0, 6.0 / 7.0]] {
            let mut values = Vec::new();
            spherical_harmonics_into(8, &point, &mut values);
            for degree in 0..=8 {
                let squares: f64 =
                    values[degree * degree..components_up_to(degree)].iter().map(|value| value * value).sum();
                assert!((squares - (2 * degree + 1) as f64).abs() < 1e-12, "degree {degree}: {squares}");
            }
        }
        let mut values = Vec::new();
        spherical_harmonics_into(3, &[0.0; 3], &mut values);
        assert_eq!(values[0], 1.0);
        assert!(values[1..].iter().all(|&value| value == 0.0));
    }
}
