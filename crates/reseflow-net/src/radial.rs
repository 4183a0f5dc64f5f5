//! Radial basis of edge lengths: Gaussians on a uniform grid, as in SchNet (arXiv 1706.08566).

use serde::{Deserialize, Serialize};

use crate::NetError;

/// Gaussians centred at `count` points spread over \[0, `max_m`\], each as wide as their spacing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RadialBasis {
    /// Number of basis functions, at least 2.
    pub count: usize,
    /// The longest length that the grid covers, metres.
    pub max_m: f64,
}

impl RadialBasis {
    /// Refuses sizes that make no basis; `key` is what the configuration calls it.
    pub(crate) fn validate(&self, key: &str) -> Result<(), NetError> {
        let Self { count, max_m } = *self;
        if count < 2 || !(max_m.is_finite() && max_m > 0.0) {
            let fault =
                format!("{key} needs count >= 2 and max_m > 0, got count = {count} and max_m = {max_m}");
            return Err(NetError::Config(fault));
        }
        Ok(())
    }

    /// Appends the basis functions at `length_m` to `out`.
    pub fn evaluate_into(&self, length_m: f64, out: &mut Vec<f64>) {
        let spacing = self.max_m / (self.count - 1) as f64;
        for index in 0..self.count {
            let offset = (length_m - index as f64 * spacing) / spacing;
            out.push((-offset * offset).exp());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_function_peaks_at_its_own_centre() {
        let basis = RadialBasis { count: 5, max_m: 0.2 };
        for index in 0..5 {
            let mut values = Vec::new();
            basis.evaluate_into(0.05 * index as f64, &mut values);
            assert_eq!(values.len(), 5);
            assert!((values[index] - 1.0).abs() < 1e-12);
            assert!(values.iter().enumerate().all(|(other, &value)| other == index || value < 0.5));
        }
    }
}
