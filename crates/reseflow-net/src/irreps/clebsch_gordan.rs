//! Real Clebsch–Gordan coefficients: Racah's closed form in the complex basis, changed to the real one.

use super::components;

/// The coefficients of one triple of degrees.
#[derive(Debug, Clone, PartialEq)]
pub struct ClebschGordan {
    /// The degrees l₁, l₂, l₃.
    pub degrees: [usize; 3],
    /// Row-major `[2l₁ + 1, 2l₂ + 1, 2l₃ + 1]`; the squares sum to one, or all are zero where |l₁ − l₂| ≤ l₃ ≤ l₁ + l₂ does not hold.
    pub values: Vec<f64>,
}

impl ClebschGordan {
    /// The coefficient of the components m₁, m₂ and m₃, each from −l to l.
    pub fn entry(&self, m1: i64, m2: i64, m3: i64) -> f64 {
        let [l1, l2, l3] = self.degrees.map(|degree| degree as i64);
        self.values[(((m1 + l1) * (2 * l2 + 1) + m2 + l2) * (2 * l3 + 1) + m3 + l3) as usize]
    }
}

/// The one bilinear map l₁ ⊗ l₂ → l₃ that commutes with rotations, up to its factor: z_{m₃} = Σ C\[m₁, m₂, m₃\] x_{m₁} y_{m₂}.
pub fn clebsch_gordan(l1: usize, l2: usize, l3: usize) -> ClebschGordan {
    let mut values = Vec::with_capacity(components(l1) * components(l2) * components(l3));
    let allowed = l1.abs_diff(l2) <= l3 && l3 <= l1 + l2;
    let [j1, j2, j3] = [l1, l2, l3].map(|degree| degree as i64);
    for m1 in -j1..=j1 {
        for m2 in -j2..=j2 {
            for m3 in -j3..=j3 {
                values.push(if allowed { real_coefficient([j1, j2, j3], [m1, m2, m3]) } else { 0.0 });
            }
        }
    }
    let norm = values.iter().map(|value| value * value).sum::<f64>().sqrt();
    if norm > 0.0 {
        values.iter_mut().for_each(|value| *value /= norm);
    }
    ClebschGordan { degrees: [l1, l2, l3], values }
}

/// A complex number.
type Complex = (f64, f64);

fn times(a: Complex, b: Complex) -> Complex {
    (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0)
}

/// Σ U₁\[k₁, m₁\] U₂\[k₂, m₂\] conj U₃\[k₁ + k₂, m₃\] ⟨l₁ k₁ l₂ k₂ | l₃ k₁ + k₂⟩, which is real.
fn real_coefficient([j1, j2, j3]: [i64; 3], [m1, m2, m3]: [i64; 3]) -> f64 {
    let mut sum = 0.0;
    for (k1, first) in complex_parts(j1, m1) {
        for (k2, second) in complex_parts(j2, m2) {
            for (k3, third) in complex_parts(j3, m3) {
                if k1 + k2 == k3 {
                    let factor = times(times(first, second), (third.0, -third.1));
                    sum += factor.0 * racah([j1, j2, j3], [k1, k2, k3]);
                }
            }
        }
    }
    sum
}

/// The complex components that make up the real one m, with their factors; (−i)ˡ makes the coefficients real.
fn complex_parts(degree: i64, m: i64) -> Vec<(i64, Complex)> {
    let half = 0.5f64.sqrt();
    let sign = if m % 2 == 0 { half } else { -half };
    let parts: Vec<(i64, Complex)> = match m {
        0 => vec![(0, (1.0, 0.0))],
        1.. => vec![(m, (sign, 0.0)), (-m, (half, 0.0))],
        _ => vec![(-m, (0.0, sign)), (m, (0.0, -half))],
    };
    let phase = [(1.0, 0.0), (0.0, -1.0), (-1.0, 0.0), (0.0, 1.0)][degree as usize % 4];
    parts.into_iter().map(|(k, factor)| (k, times(phase, factor))).collect()
}

/// ⟨j₁ m₁ j₂ m₂ | j₃ m₃⟩ by Racah's formula (Varshalovich, 8.2.1), with the Condon–Shortley phases.
fn racah([j1, j2, j3]: [i64; 3], [m1, m2, m3]: [i64; 3]) -> f64 {
    let triangle = factorial(j1 + j2 - j3) * factorial(j1 - j2 + j3) * factorial(j2 + j3 - j1)
        / factorial(j1 + j2 + j3 + 1);
    let orders: f64 =
        [(j1, m1), (j2, m2), (j3, m3)].iter().map(|&(j, m)| factorial(j + m) * factorial(j - m)).product();
    let lowest = 0.max(j2 - j3 - m1).max(j1 - j3 + m2);
    let highest = (j1 + j2 - j3).min(j1 - m1).min(j2 + m2);
    let series: f64 = (lowest..=highest)
        .map(|k| {
            let factors = [k, j1 + j2 - j3 - k, j1 - m1 - k, j2 + m2 - k, j3 - j2 + m1 + k, j3 - j1 - m2 + k];
            let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
            sign / factors.into_iter().map(factorial).product::<f64>()
        })
        .sum();
    ((2 * j3 + 1) as f64 * triangle * orders).sqrt() * series
}

fn factorial(n: i64) -> f64 {
    (2..=n).map(|factor| factor as f64).product()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::irreps::{WignerMatrices, rotation_to_polar};

    fn dot(a: &[f64], b: &[f64]) -> f64 {
        a.iter().zip(b).map(|(a, b)| a * b).sum()
    }

    #[test]
    fn the_product_of_turned_features_is_the_turned_product() {
        let matrices = WignerMatrices::new(5, &rotation_to_polar(&[0.4, -0.3, 0.8]));
        let mut triples = 0;
        for l1 in 0..=5usize {
            for l2 in 0..=5 {
                for l3 in l1.abs_diff(l2)..=(l1 + l2).min(5) {
                    let coefficients = clebsch_gordan(l1, l2, l3);
                    let turn = |degree: usize, x: &[f64]| -> Vec<f64> {
                        let block = matrices.blocks[degree].chunks_exact(components(degree));
                        block.map(|row| dot(row, x)).collect()
                    };
                    let product = |x: &[f64], y: &[f64]| -> Vec<f64> {
                        let mut z = vec![0.0; components(l3)];
                        for (index, value) in coefficients.values.iter().enumerate() {
                            let (i, k) = (index / components(l3), index % components(l3));
                            z[k] += value * x[i / components(l2)] * y[i % components(l2)];
                        }
                        z
                    };
                    let x: Vec<f64> = (0..components(l1)).map(|i| (1.0 + i as f64 * 1.7).sin()).collect();
                    let y: Vec<f64> = (0..components(l2)).map(|i| (2.0 + i as f64 * 0.9).cos()).collect();
                    let turned = product(&turn(l1, &x), &turn(l2, &y));
                    for (a, b) in turned.iter().zip(turn(l3, &product(&x, &y))) {
                        assert!((a - b).abs() < 1e-13, "{l1} {l2} {l3}: {a} {b}");
                    }
                    assert!((dot(&coefficients.values, &coefficients.values) - 1.0).abs() < 1e-13);
                    triples += 1;
                }
            }
        }
        assert_eq!(triples, 111);
    }

    #[test]
    fn of_two_vectors_they_are_the_inner_and_the_cross_product() {
        let [inner, cross] = [0, 1].map(|degree| clebsch_gordan(1, 1, degree));
        for (m1, m2) in [(-1, 0), (0, 1), (1, -1), (0, 0)] {
            let expected = if m1 == m2 { 1.0 / 3f64.sqrt() } else { 0.0 };
            assert!((inner.entry(m1, m2, 0) - expected).abs() < 1e-15);
        }
        for (m1, m2, m3) in [(-1, 0, 1), (0, 1, -1), (1, -1, 0)] {
            assert!((cross.entry(m1, m2, m3) - 6f64.sqrt().recip()).abs() < 1e-15);
            assert!((cross.entry(m2, m1, m3) + 6f64.sqrt().recip()).abs() < 1e-15);
        }
    }

    #[test]
    fn degrees_that_make_no_triangle_have_none() {
        assert!(clebsch_gordan(1, 1, 3).values.iter().all(|&value| value == 0.0));
        assert!(clebsch_gordan(4, 1, 2).values.iter().all(|&value| value == 0.0));
    }
}
