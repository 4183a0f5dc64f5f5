//! Wigner matrices of a rotation in the real basis, degree by degree from its 3×3 matrix: the recurrence of Ivanic and Ruedenberg
//! (J. Phys. Chem. 1996, 100, 6342, with the erratum of 1998), without angles and so without a singular direction.

use super::components;

/// D⁰ … D^l_max of one rotation; Yˡ(R v) = Dˡ(R) Yˡ(v).
#[derive(Debug, Clone, PartialEq)]
pub struct WignerMatrices {
    /// Row-major (2l + 1)×(2l + 1) blocks, by degree.
    pub blocks: Vec<Vec<f64>>,
}

impl WignerMatrices {
    /// The matrices of the rotation with these rows, up to `max_degree`.
    pub fn new(max_degree: usize, rotation: &[[f64; 3]; 3]) -> Self {
        let mut blocks = vec![vec![1.0], rotation.as_flattened().to_vec()];
        blocks.truncate(max_degree + 1);
        for degree in 2..=max_degree {
            blocks.push(next_block(degree as i64, rotation, &blocks[degree - 1]));
        }
        Self { blocks }
    }

    /// Dˡ\[m, n\], both from −l to l.
    pub fn entry(&self, degree: usize, m: i64, n: i64) -> f64 {
        let l = degree as i64;
        self.blocks[degree][((m + l) * (2 * l + 1) + n + l) as usize]
    }
}

/// Dˡ from R and D^{l−1}; the letters are those of the paper's table 1.
fn next_block(l: i64, rotation: &[[f64; 3]; 3], before: &[f64]) -> Vec<f64> {
    let rotation = |i: i64, j: i64| rotation[(i + 1) as usize][(j + 1) as usize];
    let before = |m: i64, n: i64| before[((m + l - 1) * (2 * l - 1) + n + l - 1) as usize];
    let p = |i: i64, m: i64, n: i64| {
        if n == l {
            rotation(i, 1) * before(m, l - 1) - rotation(i, -1) * before(m, 1 - l)
        } else if n == -l {
            rotation(i, 1) * before(m, 1 - l) + rotation(i, -1) * before(m, l - 1)
        } else {
            rotation(i, 0) * before(m, n)
        }
    };
    let mut block = Vec::with_capacity(components(l as usize).pow(2));
    for m in -l..=l {
        for n in -l..=l {
            let size = m.abs();
            let denominator = if n.abs() == l { 2 * l * (2 * l - 1) } else { (l + n) * (l - n) } as f64;
            let mut sum = 0.0;
            if size < l {
                sum += (((l + m) * (l - m)) as f64 / denominator).sqrt() * p(0, m, n);
            }
            let v = (((l + size - 1) * (l + size)) as f64 / denominator).sqrt();
            sum += if m == 0 {
                -0.5 * v * 2f64.sqrt() * (p(1, 1, n) + p(-1, -1, n))
            } else {
                // At |m| = 1 one of the two terms is absent, and the other counts √2 times.
                let (plus, minus) = if m > 0 { (m - 1, 1 - m) } else { (m + 1, -m - 1) };
                let (first, second) = match (m, size) {
                    (1, _) => (2f64.sqrt() * p(1, plus, n), 0.0),
                    (-1, _) => (0.0, 2f64.sqrt() * p(-1, minus, n)),
                    _ => (p(1, plus, n), p(-1, minus, n)),
                };
                0.5 * v * if m > 0 { first - second } else { first + second }
            };
            if m != 0 && size < l - 1 {
                let w = (((l - size - 1) * (l - size)) as f64 / denominator).sqrt();
                sum -= 0.5
                    * w
                    * if m > 0 {
                        p(1, m + 1, n) + p(-1, -m - 1, n)
                    } else {
                        p(1, m - 1, n) - p(-1, 1 - m, n)
                    };
            }
            block.push(sum);
        }
    }
    block
}

/// A rotation that takes `direction` to the polar axis y; the identity for a direction of length zero.
///
/// Which of them does not matter to what is built on it. Here it is the shortest one, after half a turn about x for directions
/// below the equator, so that no direction is close to one where it is badly determined.
pub fn rotation_to_polar(direction: &[f64; 3]) -> [[f64; 3]; 3] {
    let length = direction.iter().map(|value| value * value).sum::<f64>().sqrt();
    if length == 0.0 {
        return [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    }
    let flip = if direction[1] < 0.0 { -1.0 } else { 1.0 };
    let [x, y, z] = [direction[0] / length, flip * direction[1] / length, flip * direction[2] / length];
    // Rodrigues' formula about (x, y, z) × y.
    let factor = 1.0 / (1.0 + y);
    let rows =
        [[1.0 - x * x * factor, -x, -x * z * factor], [x, y, z], [-x * z * factor, -z, 1.0 - z * z * factor]];
    rows.map(|[first, second, third]| [first, flip * second, flip * third])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::irreps::{components_up_to, spherical_harmonics_into};

    const MAX_DEGREE: usize = 7;

    /// Rotations about all axes, with near-identity, half turns and poles among them.
    fn rotations() -> Vec<[[f64; 3]; 3]> {
        let directions = [
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, -1.0, 0.0],
            [0.0, 0.0, -1.0],
            [1e-9, -1.0, 1e-9],
            [0.3, 1e-12, -0.7],
            [-0.5, 0.2, 0.9],
            [0.7, -0.1, 0.2],
        ];
        let polar = directions.map(|direction| rotation_to_polar(&direction));
        let products = polar.iter().flat_map(|a| polar.iter().map(|b| product(a, b)));
        products.collect()
    }

    fn product(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
        a.map(|row| [0, 1, 2].map(|column| (0..3).map(|k| row[k] * b[k][column]).sum()))
    }

    fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
        assert_eq!(a.len(), b.len());
        a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    fn matrix_product(size: usize, a: &[f64], b: &[f64]) -> Vec<f64> {
        let entry =
            |index: usize| (0..size).map(|k| a[index / size * size + k] * b[k * size + index % size]).sum();
        (0..size * size).map(entry).collect()
    }

    #[test]
    fn the_harmonics_of_a_turned_direction_are_the_turned_harmonics() {
        for rotation in rotations() {
            let matrices = WignerMatrices::new(MAX_DEGREE, &rotation);
            let point = [0.48, -0.6, 0.64];
            let turned = rotation.map(|row| (0..3).map(|k| row[k] * point[k]).sum());
            let (mut still, mut moved) = (Vec::new(), Vec::new());
            spherical_harmonics_into(MAX_DEGREE, &point, &mut still);
            spherical_harmonics_into(MAX_DEGREE, &turned, &mut moved);
            for degree in 0..=MAX_DEGREE {
                let range = degree * degree..components_up_to(degree);
                let (still, moved) = (&still[range.clone()], &moved[range]);
                let expected: Vec<f64> = (matrices.blocks[degree].chunks_exact(components(degree)))
                    .map(|row| row.iter().zip(still).map(|(a, b)| a * b).sum())
                    .collect();
                let error = largest_difference(&expected, moved);
                assert!(error < 1e-13, "degree {degree}: {error:e}");
            }
        }
    }

    #[test]
    fn a_product_of_rotations_has_the_product_of_their_matrices() {
        let rotations = rotations();
        for (a, b) in rotations.iter().zip(rotations.iter().rev()) {
            let [left, right, both] =
                [a, b, &product(a, b)].map(|rotation| WignerMatrices::new(MAX_DEGREE, rotation));
            for degree in 0..=MAX_DEGREE {
                let expected =
                    matrix_product(components(degree), &left.blocks[degree], &right.blocks[degree]);
                let error = largest_difference(&expected, &both.blocks[degree]);
                assert!(error < 1e-13, "degree {degree}: {error:e}");
            }
        }
    }

    #[test]
    fn the_direction_becomes_the_polar_axis_and_the_frame_stays_a_rotation() {
        for direction in
            [[0.0, 2.0, 0.0], [0.0, -3.0, 0.0], [1e-8, -1e-8, 0.0], [0.5, -0.4, 0.1], [1.0, 1e-17, 2.0]]
        {
            let rotation = rotation_to_polar(&direction);
            let length = direction.iter().map(|value| value * value).sum::<f64>().sqrt();
            let turned = rotation.map(|row| (0..3).map(|k| row[k] * direction[k] / length).sum::<f64>());
            assert!(
                largest_difference(&turned, &[0.0, 1.0, 0.0]) < 1e-15,
                "{direction:?} went to {turned:?}"
            );
            let [a, b, c] = rotation;
            let triple = a[0] * (b[1] * c[2] - b[2] * c[1])
                + a[1] * (b[2] * c[0] - b[0] * c[2])
                + a[2] * (b[0] * c[1] - b[1] * c[0]);
            assert!((triple - 1.0).abs() < 1e-15, "determinant {triple}");
        }
        assert_eq!(rotation_to_polar(&[0.0; 3])[1], [0.0, 1.0, 0.0]);
    }
}
